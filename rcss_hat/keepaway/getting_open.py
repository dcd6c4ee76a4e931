"""Where a keeper without the ball goes: the least crowded point to which a pass could come."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import njit
from rcss_hat.player.fastest import cycles_to_ball
from rcss_hat.player.geometry import in_cone
from rcss_hat.player.motion import ball_after, turn_body_moment
from rcss_hat.player.moving import move_to
from rcss_hat.player.objects import is_known
from rcss_hat.player.records import OPPONENTS
from rcss_hat.protocol.records import TURN

Record = NDArray[np.void]

GRID = 5
"""Points per axis."""
BORDER = 0.15
"""Part of the region kept free at each side."""
LANE = 0.3
"""Half-width of a pass lane, metres per metre."""
THERE = 1.5
"""Near enough to the chosen point (m)."""
PRECISION = 7.0
"""Heading error (degrees) that is good enough for running."""


@njit
def congestion(agent: Record, x: float, y: float) -> float:
    """Sum of the inverse distances (1/m) of all other known players to a point."""
    total = 0.0
    own, me = agent["top_own"][0], agent["me"][0]
    pos = agent["player_pos"]
    for o in range(agent["top_other"][0] - 1, -1, -1):
        if (o >= own and o < OPPONENTS) or o == me or not is_known(agent, o):
            continue
        dx, dy = pos[0, o, 0] - x, pos[0, o, 1] - y
        if dx != 0.0 or dy != 0.0:
            total += 1.0 / math.sqrt(dx * dx + dy * dy)
    return total


@njit
def lane_is_open(agent: Record, from_x: float, from_y: float, x: float, y: float) -> bool:
    """Tell whether no known opponent stands in the lane of a pass."""
    pos = agent["player_pos"]
    for o in range(OPPONENTS, agent["top_other"][0]):
        if is_known(agent, o) and in_cone(pos[0, o, 0], pos[0, o, 1], from_x, from_y, x, y, LANE):
            return False
    return True


@njit
def open_point(agent: Record, params: Record, from_x: float, from_y: float) -> tuple[float, float]:
    """Least crowded point of a grid over the region that a pass from a point can reach; else the centre (m)."""
    length, width = params["keepaway_length"][0], params["keepaway_width"][0]
    step_x = length * (1.0 - 2.0 * BORDER) / (GRID - 1)
    step_y = width * (1.0 - 2.0 * BORDER) / (GRID - 1)
    best_x, best_y, least = 0.0, 0.0, 1000.0
    for i in range(GRID):
        x = (BORDER - 0.5) * length + i * step_x
        for j in range(GRID):
            y = (BORDER - 0.5) * width + j * step_y
            crowd = congestion(agent, x, y)
            if crowd < least and lane_is_open(agent, from_x, from_y, x, y):
                best_x, best_y, least = x, y, crowd
    return best_x, best_y


@njit
def get_open(agent: Record, params: Record, fastest: int) -> tuple[int, float]:
    """Go where a pass can come, from where the fastest keeper will have the ball.

    Parameters
    ----------
    agent, params : record
    fastest : int
        Slot of the keeper who is first at the ball, or NOBODY.

    Returns
    -------
    (int, float)
        TURN and moment (degrees), or DASH and power.
    """
    from_x, from_y = ball_after(agent, params, cycles_to_ball(agent, params, fastest))
    x, y = open_point(agent, params, from_x, from_y)
    dx, dy = x - agent["pos"][0, 0], y - agent["pos"][0, 1]
    if dx * dx + dy * dy < THERE * THERE:
        return TURN, turn_body_moment(agent, params, agent["ball_pos"][0, 0], agent["ball_pos"][0, 1], 1)
    return move_to(agent, params, x, y, PRECISION, 0.0)
