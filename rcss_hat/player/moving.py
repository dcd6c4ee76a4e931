"""Skills without the ball: going somewhere, searching the ball, turning the neck."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import DEG, normalize_degrees
from rcss_hat.numeric.jit import kernel
from rcss_hat.player.geometry import direction_to, in_interval
from rcss_hat.player.motion import dash_power, own_state_after, to_body, turn_body_moment
from rcss_hat.protocol.records import DASH, TURN

Record = NDArray[np.void]

SEARCH_STEP = 60.0
"""Degrees turned per cycle while searching the ball."""
SEARCH_MEMORY = 3
"""Cycles after which a new search chooses its direction anew."""


@kernel
def move_to(agent: Record, params: Record, x: float, y: float, precision: float, back: float) -> tuple[int, float]:
    """Go to a point: dash when heading there, else turn, or brake first when too fast to turn.

    Parameters
    ----------
    agent, params : record
    x, y : float
        The point (m).
    precision : float
        Heading error that is good enough (degrees).
    back : float
        Points nearer than this may be reached backwards (m).

    Returns
    -------
    (int, float)
        DASH and power, or TURN and moment (degrees).
    """
    px, py = agent["pos"][0, 0], agent["pos"][0, 1]
    vx, vy = agent["vel"][0, 0], agent["vel"][0, 1]
    stop = 1.0 / (1.0 - params["player_decay"][0])
    angle = normalize_degrees(direction_to(x - px - vx * stop, y - py - vy * stop) - agent["body"][0])
    forward, side = to_body(agent, x - px, y - py)
    v_forward, _ = to_body(agent, vx, vy)
    backwards = abs(normalize_degrees(angle + 180.0)) < precision and forward * forward + side * side < back * back
    if abs(angle) < precision or backwards:
        return DASH, dash_power(agent, params, forward, v_forward, 1)
    speed = math.sqrt(vx * vx + vy * vy)
    turns = 0
    while abs(angle) > precision and turns < 5:
        turns += 1
        inertia = 1.0 + params["inertia_moment"][0] * speed
        moment = min(max(angle * inertia, params["minmoment"][0]), params["maxmoment"][0])
        angle = normalize_degrees(angle - moment / inertia)
        speed *= params["player_decay"][0]
    if turns <= 2:
        return TURN, turn_body_moment(agent, params, x, y, 2)
    return DASH, dash_power(agent, params, 0.0, v_forward, 1)


@kernel
def search_ball(agent: Record, params: Record) -> tuple[int, float]:
    """Turn to look for the ball, at first to the side on which it was last.

    Returns
    -------
    (int, float)
        TURN and moment (degrees).
    """
    body = agent["body"][0]
    px, py = agent["pos"][0, 0], agent["pos"][0, 1]
    if agent["now"][0] - agent["search_time"][0] > SEARCH_MEMORY:
        ball = direction_to(agent["ball_pos"][0, 0] - px, agent["ball_pos"][0, 1] - py)
        agent["search_sign"][0] = 1.0 if in_interval(ball, body, body + 180.0) else -1.0
    agent["search_time"][0] = agent["now"][0]
    way = (body + SEARCH_STEP * agent["search_sign"][0]) * DEG
    return TURN, turn_body_moment(agent, params, px + math.cos(way), py + math.sin(way), 1)


@kernel
def turn_neck_to(agent: Record, params: Record, x: float, y: float, kind: int, amount: float) -> float:
    """Moment of turn_neck (degrees) that faces a point after a body command.

    Parameters
    ----------
    agent, params : record
    x, y : float
        The point (m).
    kind : int
        Body command of this cycle.
    amount : float
        Its power or moment.
    """
    px, py, _, _, turned = own_state_after(agent, params, kind, amount)
    body = agent["body"][0] + turned
    wanted = normalize_degrees(direction_to(x - px, y - py) - body)
    wanted = min(max(wanted, params["minneckang"][0]), params["maxneckang"][0])
    return wanted - agent["head"][0]
