"""Where a keeper without the ball goes: the least crowded point to which a pass could come."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import kernel
from rcss_hat.player.fastest import cycles_to_ball
from rcss_hat.player.geometry import in_cone
from rcss_hat.player.motion import ball_after, turn_body_moment
from rcss_hat.player.moving import move_to
from rcss_hat.player.objects import is_known
from rcss_hat.player.records import N_GRID, OPPONENTS
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


def open_grid(length: float, width: float) -> NDArray[np.float64]:
    """Points among which a keeper chooses, by x and then y (m); shape (2, 25)."""
    steps = (BORDER - 0.5) + np.arange(GRID) * (1.0 - 2.0 * BORDER) / (GRID - 1)
    return np.stack([np.repeat(steps * length, GRID), np.tile(steps * width, GRID)])


@kernel
def congestion(agent: Record) -> None:
    """Sum up the inverse distances (1/m) of all other known players to every point of the grid."""
    own, me = agent["top_own"][0], agent["me"][0]
    pos, grid_x, grid_y, crowd = agent["player_pos"], agent["grid"][0, 0], agent["grid"][0, 1], agent["crowd"][0]
    for k in range(N_GRID):
        crowd[k] = 0.0
    for o in range(agent["top_other"][0] - 1, -1, -1):
        if (o >= own and o < OPPONENTS) or o == me or not is_known(agent, o):
            continue
        x, y = pos[0, o, 0], pos[0, o, 1]
        for k in range(N_GRID):
            dx, dy = x - grid_x[k], y - grid_y[k]
            crowd[k] += 1.0 / math.sqrt(max(dx * dx + dy * dy, 1e-12))


@kernel
def lane_is_open(agent: Record, from_x: float, from_y: float, x: float, y: float) -> bool:
    """Tell whether no known opponent stands in the lane of a pass."""
    pos = agent["player_pos"]
    for o in range(OPPONENTS, agent["top_other"][0]):
        if is_known(agent, o) and in_cone(pos[0, o, 0], pos[0, o, 1], from_x, from_y, x, y, LANE):
            return False
    return True


@kernel
def open_point(agent: Record, from_x: float, from_y: float) -> tuple[float, float]:
    """Least crowded point of a grid over the region that a pass from a point can reach; else the centre (m)."""
    congestion(agent)
    grid_x, grid_y, crowd = agent["grid"][0, 0], agent["grid"][0, 1], agent["crowd"][0]
    best_x, best_y, least = 0.0, 0.0, 1000.0
    for k in range(N_GRID):
        if crowd[k] < least and lane_is_open(agent, from_x, from_y, grid_x[k], grid_y[k]):
            best_x, best_y, least = grid_x[k], grid_y[k], crowd[k]
    return best_x, best_y


@kernel
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
    # The pass comes from where the ball will be had, not from where it is now.
    from_x, from_y = ball_after(agent, params, cycles_to_ball(agent, params, fastest))
    x, y = open_point(agent, from_x, from_y)
    dx, dy = x - agent["pos"][0, 0], y - agent["pos"][0, 1]
    if dx * dx + dy * dy < THERE * THERE:
        return TURN, turn_body_moment(agent, params, agent["ball_pos"][0, 0], agent["ball_pos"][0, 1], 1)
    return move_to(agent, params, x, y, PRECISION, 0.0)
