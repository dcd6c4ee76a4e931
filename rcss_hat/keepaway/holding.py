"""Hold and pass: what a player does with the ball."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import DEG, normalize_degrees
from rcss_hat.numeric.jit import kernel
from rcss_hat.player.geometry import direction_to, sign
from rcss_hat.player.kicking import kick_close, kick_to
from rcss_hat.player.motion import ball_after, own_state_after, turn_body_moment
from rcss_hat.player.objects import closest_opponent, sort_by_distance
from rcss_hat.protocol.landmarks import PITCH_LENGTH
from rcss_hat.protocol.records import KICK, TURN

Record = NDArray[np.void]

KEEPER_HOLD, TAKER_HOLD = 0.7, 0.3
"""Part of the kickable margin at which the ball is held."""
HARASSED = 5.0
"""Opponents farther than this from the ball do not count (m)."""
PASS_END_SPEED = 1.2
"""Speed with which a pass shall arrive (m/cycle)."""


@kernel
def hold_ball(agent: Record, params: Record, part: float) -> tuple[int, float, float]:
    """Keep the ball for a cycle, away from the nearest opponent (holdBall of the UT Austin players).

    Parameters
    ----------
    agent, params : record
    part : float
        How far out the ball is held, as part of the kickable margin.

    Returns
    -------
    (int, float, float)
        KICK, power and direction (degrees), or TURN and moment (degrees).
    """
    px, py = agent["pos"][0, 0], agent["pos"][0, 1]
    bx, by = agent["ball_pos"][0, 0], agent["ball_pos"][0, 1]
    angle = 0.0
    opponent, distance = closest_opponent(agent, bx, by)
    if opponent >= 0 and distance < HARASSED:
        away = direction_to(px - agent["player_pos"][0, opponent, 0], py - agent["player_pos"][0, opponent, 1])
        side = -sign(normalize_degrees(agent["player_body"][0, opponent] - away))
        angle = normalize_degrees(away + 45.0 * side - agent["body"][0])
    # The place is compared as if the angle were global: the UT Austin players do so, and their Hold depends on it.
    dx, dy = bx - px - part * math.cos(angle * DEG), by - py - part * math.sin(angle * DEG)
    if dx * dx + dy * dy < 0.3 * 0.3:
        moment = turn_body_moment(agent, params, 0.5 * PITCH_LENGTH, 0.0, 1)
        x, y, _, _, _ = own_state_after(agent, params, TURN, moment)
        next_x, next_y = ball_after(agent, params, 1)
        if (x - next_x) ** 2 + (y - next_y) ** 2 < (0.85 * agent["kick_dist"][0]) ** 2:
            return TURN, moment, 0.0
    power, direction = kick_close(agent, params, angle, part)
    return KICK, power, direction


@kernel
def pass_ball(agent: Record, params: Record, action: int) -> tuple[int, float, float]:
    """Pass to the keeper who is the action-th nearest to oneself, where it is now.

    Returns
    -------
    (int, float, float)
        KICK, power and direction (degrees).
    """
    order, distance = agent["order"][0], agent["distance"][0]
    n = agent["n_keepers"][0]
    sort_by_distance(agent, 0, n, agent["pos"][0, 0], agent["pos"][0, 1], order[:n], distance[:n])
    receiver = order[action]
    x, y = agent["player_pos"][0, receiver, 0], agent["player_pos"][0, receiver, 1]
    power, direction = kick_to(agent, params, x, y, PASS_END_SPEED)
    return KICK, power, direction
