"""Who is known, and who is nearest: questions to the beliefs about players and ball.

Where several players are equally near the higher uniform number counts, as in the UT Austin players.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.player.records import NOBODY, OPPONENTS

Record = NDArray[np.void]

PLAYER_MEMORY = 12
"""Cycles for which a player is believed to be where it was (confidence 0.88)."""
BALL_MEMORY = 10
"""Cycles for which the ball is (confidence 0.90)."""
FAR = 1000.0
"""A distance beyond all others (m)."""


@inlined
def is_known(agent: Record, slot: int) -> bool:
    """Tell whether a player's position is recent enough to be used."""
    age = agent["now"][0] - agent["player_seen"][0, slot]
    return 0 <= age <= PLAYER_MEMORY


@inlined
def ball_is_known(agent: Record) -> bool:
    """Tell whether the ball's position is recent enough to be used."""
    return 0 <= agent["now"][0] - agent["ball_seen"][0] <= BALL_MEMORY


@kernel
def ball_distance(agent: Record) -> float:
    """Distance to the ball (m)."""
    dx, dy = agent["ball_pos"][0, 0] - agent["pos"][0, 0], agent["ball_pos"][0, 1] - agent["pos"][0, 1]
    return math.sqrt(dx * dx + dy * dy)


@inlined
def distance2_to(agent: Record, slot: int, x: float, y: float) -> float:
    """Squared distance of a player to a point (m2)."""
    dx, dy = agent["player_pos"][0, slot, 0] - x, agent["player_pos"][0, slot, 1] - y
    return dx * dx + dy * dy


@kernel
def closest_in(agent: Record, first: int, end: int, x: float, y: float) -> tuple[int, float]:
    """Nearest known player among slots ``first .. end-1``.

    Returns
    -------
    (int, float)
        Slot or NOBODY, and its distance (m; FAR for nobody).
    """
    best, best2 = NOBODY, FAR * FAR
    for o in range(end - 1, first - 1, -1):
        if is_known(agent, o):
            d2 = distance2_to(agent, o, x, y)
            if d2 < best2:
                best, best2 = o, d2
    return best, math.sqrt(best2)


@kernel
def closest_opponent(agent: Record, x: float, y: float) -> tuple[int, float]:
    """Nearest known opponent: slot or NOBODY, and its distance (m)."""
    return closest_in(agent, OPPONENTS, agent["top_other"][0], x, y)


@kernel
def closest_teammate(agent: Record, x: float, y: float) -> tuple[int, float]:
    """Nearest known player of the own team, the player itself included: slot or NOBODY, and its distance (m)."""
    return closest_in(agent, 0, agent["top_own"][0], x, y)


@kernel
def closest_other(agent: Record, x: float, y: float) -> float:
    """Distance to the nearest known player of either team other than the player itself (m)."""
    best2 = FAR * FAR
    for o in range(agent["top_other"][0]):
        if (o < agent["top_own"][0] or o >= OPPONENTS) and o != agent["me"][0] and is_known(agent, o):
            best2 = min(best2, distance2_to(agent, o, x, y))
    return math.sqrt(best2)


@kernel
def sort_by_distance(
    agent: Record, first: int, n: int, x: float, y: float, order: NDArray[np.int64], distance: NDArray[np.float64]
) -> bool:
    """Sort the players of slots ``first .. first+n-1`` by distance to a point.

    Parameters
    ----------
    agent : record
    first, n : int
        Slots.
    x, y : float
        The point (m).
    order : ndarray of int64
        Gets the slots; they stay in the order of uniform numbers when someone is unknown.
    distance : ndarray of float64
        Gets the distances in that order (m).

    Returns
    -------
    bool
        False when someone is unknown.
    """
    complete = True
    for i in range(n):
        order[i] = first + i
        complete = complete and is_known(agent, first + i)
        distance[i] = math.sqrt(distance2_to(agent, first + i, x, y))
    if not complete:
        return False
    for i in range(1, n):
        slot, d = order[i], distance[i]
        j = i
        while j > 0 and distance[j - 1] > d:
            order[j] = order[j - 1]
            distance[j] = distance[j - 1]
            j -= 1
        order[j] = slot
        distance[j] = d
    return True
