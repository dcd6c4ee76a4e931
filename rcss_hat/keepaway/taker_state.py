"""What a taker that learns sees: distances and angles around the keeper with the ball (K1), and to itself.

K1 is the keeper nearest to the ball; K2 .. Kn and T1 .. Tm are sorted by distance to K1, T is the taker itself; C is
the centre of the region. Metres and degrees.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.keepaway.state import angle_at
from rcss_hat.numeric.jit import kernel
from rcss_hat.player.objects import ball_distance, ball_is_known, closest_opponent, sort_by_distance
from rcss_hat.player.records import NOBODY, OPPONENTS

Record = NDArray[np.void]


def n_taker_variables(n_keepers: int, n_takers: int) -> int:
    """Number of a taker's state variables: 13 in 3v2."""
    return 4 * n_keepers + n_takers - 1


def taker_state_names(n_keepers: int, n_takers: int) -> list[str]:
    """Names of a taker's state variables, in order."""
    keepers = [f"K{i}" for i in range(2, n_keepers + 1)]
    return [
        "dist(K1,C)",
        *(f"dist(K1,{k})" for k in keepers),
        *(f"dist(K1,T{j})" for j in range(1, n_takers + 1)),
        *(f"dist(T,{k})" for k in ["K1", *keepers]),
        *(f"min_ang({k},K1,T)" for k in keepers),
        *(f"ang({k},K1,T)" for k in keepers),
        "dist(T,B)",
    ]


@kernel
def taker_state_variables(agent: Record, state: NDArray[np.float64]) -> bool:
    """Compute a taker's state variables as it believes them to be.

    Parameters
    ----------
    agent : record
    state : ndarray of float64, shape (n_taker_variables,)
        Filled in: distances (m) from K1 to the centre, the other keepers and the takers; from the taker to the
        keepers; the least angle (degrees) at K1 between each other keeper and a taker, and that between it and the
        taker itself; the taker's distance to the ball.

    Returns
    -------
    bool
        False when the ball or somebody is unknown; the state is then undefined.
    """
    n, m, me = agent["n_keepers"][0], agent["n_takers"][0], agent["me"][0]
    if not ball_is_known(agent):
        return False
    holder, _ = closest_opponent(agent, agent["ball_pos"][0, 0], agent["ball_pos"][0, 1])
    if holder == NOBODY:
        return False
    pos = agent["player_pos"]
    x, y = pos[0, holder, 0], pos[0, holder, 1]
    order, distance = agent["order"][0], agent["distance"][0]
    keepers, takers = order[:n], order[n : n + m]
    if not sort_by_distance(agent, OPPONENTS, n, x, y, keepers, distance[:n]):
        return False
    if not sort_by_distance(agent, 0, m, x, y, takers, distance[n : n + m]):
        return False
    state[0] = math.sqrt(x * x + y * y)
    for i in range(1, n + m):
        state[i] = distance[i]
    mx, my = pos[0, me, 0], pos[0, me, 1]
    for i in range(n):
        kx, ky = pos[0, keepers[i], 0], pos[0, keepers[i], 1]
        state[n + m + i] = math.sqrt((kx - mx) ** 2 + (ky - my) ** 2)
        if i > 0:
            narrowest = 180.0
            for j in range(m):
                narrowest = min(narrowest, angle_at(x, y, kx, ky, pos[0, takers[j], 0], pos[0, takers[j], 1]))
            state[2 * n + m - 1 + i] = narrowest
            state[3 * n + m - 2 + i] = angle_at(x, y, kx, ky, mx, my)
    state[4 * n + m - 2] = ball_distance(agent)
    return True
