"""Getting the ball: the plan for the next 30 cycles, and what to do when it is about to arrive.

`intercept` follows predictCommandToInterceptBall and interceptClose of the UT Austin players. Points that cannot change
the outcome are skipped: those out of reach by a simple bound, and after the first that can be reached all those that
neither lie near the point chosen in the cycle before nor can shift it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import DEG, normalize_degrees
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.player.fastest import HORIZON, NOT_IN_TIME
from rcss_hat.player.geometry import direction_to
from rcss_hat.player.motion import (
    TURN_AROUND_DISTANCE,
    ball_after,
    dash_power,
    limited,
    miss_after,
    needs_turn,
    own_state_after,
    planned_move,
    roll_out,
    to_body,
    turn_body_moment,
    turn_moment,
)
from rcss_hat.player.objects import ball_distance, closest_in
from rcss_hat.player.records import NOBODY, OPPONENTS
from rcss_hat.protocol.landmarks import PITCH_LENGTH, PITCH_WIDTH
from rcss_hat.protocol.records import DASH, NO_COMMAND, TURN

Record = NDArray[np.void]

_NONE = -1000
AIM_MEMORY = 2
"""Cycles for which the last interception point is remembered."""
FACING = 25.0
"""Heading error (degrees) that is good enough when the ball arrives."""
OPPONENT_NEAR = 3.0
"""An opponent within so many metres makes haste: the ball is taken before the body is turned."""

# Of the plan, from the UT Austin players (getInterceptionMinCyc and its loop over the next cycles).
_INSIDE = 1.0
"""Balls are met at least so many metres inside the pitch."""
_WELL_INSIDE_X, _WELL_INSIDE_Y = 50.0, 32.0
"""A better point than the first is taken only within these coordinates (m)."""
_ROLLING = 0.6
"""Slower balls (m/cycle) are not worth the point chosen before."""
_AFTER_FIRST = 20
"""Cycles after the first possible one in which a better one is looked for."""
_OWN_ROLL = 4
"""Cycles for which the player's own speed counts when he does not dash."""
_SAME_POINT = 1.0
"""A point within so many metres of the one chosen before continues that plan ..."""
_SAFE_MISS = 0.7
"""... if the player comes as near to it as this part of the kickable distance."""
_GOOD_MISS = 0.5
"""A point that is missed by no more than this part of the kickable distance is not improved on."""
_NEXT = 3
"""Cycles after the best point so far in which a nearer one replaces it."""
_ANY_AIM, _ANY_MISS = 100.0, 10.0
"""Farther than any point chosen before, and than any miss (m)."""
_CLOSE = 3
"""A ball met in fewer cycles than this is met by `meet_close_ball`."""
_COMES_HERE = 0.5
"""Nearer to where the player rolls (m) the ball is waited for."""

# Of the last cycles (interceptClose).
_DASH_SHARE, _TURN_SHARE = 0.95, 0.8
"""Part of the kickable distance within which the ball must lie after a dash, and after a turn or a braking dash."""
_MARGIN_PARTS = 6.0
"""A dash leaves the ball one of so many parts of the kickable margin away from the body."""
_NEAR_GOAL_X = 31.0
"""Beyond it (m) one faces the opponents' goal, not +x."""


@kernel
def _outside(x: float, y: float) -> bool:
    """Tell whether a point is too near the edge of the pitch to meet a ball there."""
    return abs(x) >= 0.5 * PITCH_LENGTH - _INSIDE or abs(y) >= 0.5 * PITCH_WIDTH - _INSIDE


@inlined
def _aim_lies_ahead(agent: Record, has_aim: bool, x: float, y: float, ball_vx: float, ball_vy: float) -> bool:
    """Tell whether the ball, now at a point, may still pass the point chosen in the cycle before, and fast enough."""
    speed2 = ball_vx * ball_vx + ball_vy * ball_vy
    if not has_aim or speed2 <= _ROLLING * _ROLLING:
        return False
    past = (x - agent["aim"][0, 0]) * ball_vx + (y - agent["aim"][0, 1]) * ball_vy
    return past <= 0.0 or past * past <= speed2


@kernel
def _choose_cycle(agent: Record, params: Record) -> int:
    """After how many cycles to meet the ball; NOT_IN_TIME when it cannot be reached within the horizon."""
    has_aim = agent["now"][0] - agent["aim_time"][0] <= AIM_MEMORY
    aim_x, aim_y = agent["aim"][0, 0], agent["aim"][0, 1]
    px, py = agent["pos"][0, 0], agent["pos"][0, 1]
    vx, vy = agent["vel"][0, 0], agent["vel"][0, 1]
    v_forward, v_side = to_body(agent, vx, vy)
    reach, top, decay = agent["kick_dist"][0], params["player_speed_max"][0], params["player_decay"][0]
    push = params["maxpower"][0] * params["dash_power_rate"][0]
    first, best, old = NOT_IN_TIME, NOT_IN_TIME, _NONE
    nearest_aim, smallest_miss = _ANY_AIM, _ANY_MISS
    # Farthest the player can have come: running from the start, or turning in the first cycle.
    speed = math.sqrt(vx * vx + vy * vy)
    speed_turned, covered, covered_turned = speed, 0.0, 0.0
    before_x, before_y = 0.0, 0.0
    for t in range(HORIZON + 1):
        if t > first + _AFTER_FIRST or (t > 0 and _outside(before_x, before_y)):
            break
        x, y = ball_after(agent, params, t)
        if t == 0:
            ball_vx, ball_vy = agent["ball_vel"][0, 0], agent["ball_vel"][0, 1]
        else:
            ball_vx, ball_vy = x - before_x, y - before_y
            speed = min(speed * decay + push, top) if t > 1 else min(speed + push, top)
            speed_turned = min(speed_turned * decay + push, top) if t > 1 else speed_turned
            covered += speed
            covered_turned += speed_turned
        before_x, before_y = x, y
        dx, dy = x - px, y - py
        if first < NOT_IN_TIME and old == _NONE and not _aim_lies_ahead(agent, has_aim, x, y, ball_vx, ball_vy):
            return first
        if _outside(x, y) or dx * dx + dy * dy > (covered + reach) ** 2:
            continue
        qx, qy = roll_out(agent, min(t, _OWN_ROLL))
        if (x - qx) ** 2 + (y - qy) ** 2 > (top * (t + reach)) ** 2:
            continue
        aim_distance = math.sqrt((x - aim_x) ** 2 + (y - aim_y) ** 2)
        fast_enough = ball_vx * ball_vx + ball_vy * ball_vy > _ROLLING * _ROLLING
        near_aim = has_aim and aim_distance < min(_SAME_POINT, nearest_aim) and fast_enough
        in_turn = smallest_miss > _GOOD_MISS * reach and (t <= best + _NEXT or t <= old + _NEXT)
        if first < NOT_IN_TIME and not near_aim and not (has_aim and in_turn):
            continue
        forward, side = to_body(agent, dx, dy)
        if dx * dx + dy * dy > (covered_turned + reach) ** 2:
            if t > 0 and needs_turn(agent, forward, side, v_forward, v_side, t, TURN_AROUND_DISTANCE):
                continue
        miss = miss_after(agent, params, forward, side, v_forward, v_side, t)
        if miss >= reach:
            continue
        if first == NOT_IN_TIME:
            first, best = t, t
        if near_aim and miss < _SAFE_MISS * reach:
            old, smallest_miss, nearest_aim = t, miss, aim_distance
        elif miss < smallest_miss and smallest_miss > _GOOD_MISS * reach and (t <= best + _NEXT or t <= old + _NEXT):
            if abs(y) < _WELL_INSIDE_Y and abs(x) < _WELL_INSIDE_X:
                best, smallest_miss = t, miss
                if old == best - 1:
                    old = best
    return old if old != _NONE and best <= old + 2 else first


@kernel
def intercept(agent: Record, params: Record) -> tuple[int, float]:
    """First command on the way to the ball.

    Returns
    -------
    (int, float)
        TURN and moment (degrees), or DASH and power.
    """
    cycles = _choose_cycle(agent, params)
    x, y = ball_after(agent, params, cycles)
    agent["aim_time"][0] = agent["now"][0]
    agent["aim"][0, 0] = x
    agent["aim"][0, 1] = y
    if cycles < _CLOSE:
        kind, amount = meet_close_ball(agent, params)
        if kind != NO_COMMAND:
            return kind, amount
    qx, qy = roll_out(agent, min(cycles, _OWN_ROLL))
    if (qx - x) ** 2 + (qy - y) ** 2 < _COMES_HERE * _COMES_HERE:
        # The ball comes here: wait, facing +x.
        return TURN, turn_body_moment(agent, params, agent["pos"][0, 0] + 1.0, agent["pos"][0, 1], 1)
    return planned_move(agent, params, x, y, cycles, TURN_AROUND_DISTANCE)


@kernel
def _gap_after(agent: Record, params: Record, kind: int, amount: float, cycles: int) -> float:
    """Distance (m) between the player one cycle after a command and the ball some cycles ahead."""
    x, y, _, _, _ = own_state_after(agent, params, kind, amount)
    bx, by = ball_after(agent, params, cycles)
    return math.sqrt((x - bx) ** 2 + (y - by) ** 2)


@kernel
def _dash_towards(agent: Record, params: Record, x: float, y: float) -> float:
    forward, _ = to_body(agent, x - agent["pos"][0, 0], y - agent["pos"][0, 1])
    v_forward, _ = to_body(agent, agent["vel"][0, 0], agent["vel"][0, 1])
    return dash_power(agent, params, forward, v_forward, 1)


@kernel
def _one_dash(agent: Record, params: Record) -> tuple[int, float]:
    """A dash that brings the ball into reach in one cycle, if there is one: DASH or NO_COMMAND, and power."""
    bx, by = ball_after(agent, params, 1)
    limit = _DASH_SHARE * agent["kick_dist"][0]
    c, s = agent["body_cos"][0], agent["body_sin"][0]
    qx, qy = roll_out(agent, 1)
    along, across = (bx - qx) * c + (by - qy) * s, (by - qy) * c - (bx - qx) * s
    radius = params["player_size"][0] + params["ball_size"][0] + params["kickable_margin"][0] / _MARGIN_PARTS
    half2 = radius * radius - across * across
    if half2 > 0.0:
        half = math.sqrt(half2)
        # The one of two points with larger x first.
        if c < 0.0:
            half = -half
        for half_way in (half, -half):
            power = _dash_towards(agent, params, qx + (along + half_way) * c, qy + (along + half_way) * s)
            if _gap_after(agent, params, DASH, np.trunc(power), 1) < limit:
                return DASH, power
    power = _dash_towards(agent, params, bx, by)
    if _gap_after(agent, params, DASH, power, 1) < limit:
        return DASH, power
    return NO_COMMAND, 0.0


@kernel
def _collide(agent: Record, params: Record) -> tuple[int, float]:
    """Run into the ball to stop it, if that works within one cycle: a command or NO_COMMAND, and its argument."""
    speed = math.sqrt(agent["ball_vel"][0, 0] ** 2 + agent["ball_vel"][0, 1] ** 2)
    if ball_distance(agent) > speed + params["player_speed_max"][0]:
        return NO_COMMAND, 0.0
    size = params["ball_size"][0] + params["player_size"][0]
    moment = turn_body_moment(agent, params, agent["pos"][0, 0] + 1.0, agent["pos"][0, 1], 1)
    if _gap_after(agent, params, TURN, moment, 1) < size:
        return TURN, moment
    bx, by = ball_after(agent, params, 1)
    power = _dash_towards(agent, params, bx, by)
    if _gap_after(agent, params, DASH, power, 1) < size:
        return DASH, power
    return NO_COMMAND, 0.0


@kernel
def _wanted_heading(agent: Record) -> float:
    """Where to face when the ball arrives: +x, or the opponents' goal when near it (degrees)."""
    if agent["pos"][0, 0] > _NEAR_GOAL_X:
        return direction_to(0.5 * PITCH_LENGTH - agent["pos"][0, 0], -agent["pos"][0, 1])
    return 0.0


@kernel
def meet_close_ball(agent: Record, params: Record) -> tuple[int, float]:
    """What to do when the ball will be here within a few cycles.

    Returns
    -------
    (int, float)
        TURN or DASH and its argument, or NO_COMMAND.
    """
    near = (
        3.0 * params["player_speed_max"][0]
        + (1.0 + params["ball_decay"][0]) * params["ball_speed_max"][0]
        + agent["kick_dist"][0]
    )
    if ball_distance(agent) > near:
        return NO_COMMAND, 0.0
    dash, power = _one_dash(agent, params)
    opponent, distance = closest_in(agent, OPPONENTS, agent["top_other"][0], agent["pos"][0, 0], agent["pos"][0, 1])
    if opponent != NOBODY and distance < OPPONENT_NEAR and dash != NO_COMMAND:
        return dash, power
    heading = _wanted_heading(agent)
    error = abs(normalize_degrees(heading - agent["body"][0]))
    turn_ok, good, moment = _turn_first(agent, params, heading)
    if good:
        return TURN, moment
    if error > FACING:
        kind, amount = _collide(agent, params)
        if kind != NO_COMMAND:
            return kind, amount
        brake = _dash_towards(agent, params, agent["pos"][0, 0], agent["pos"][0, 1])
        if _gap_after(agent, params, DASH, brake, 2) < _TURN_SHARE * agent["kick_dist"][0]:
            return DASH, brake
    if turn_ok:
        return TURN, moment
    return dash, power


@kernel
def _turn_first(agent: Record, params: Record, heading: float) -> tuple[bool, bool, float]:
    """Turn to a heading and still be near the ball afterwards, after one or two turns.

    Returns
    -------
    (bool, bool, float)
        Whether that is possible, whether it also ends with the wanted heading, and the moment of the first turn.
    """
    limit = _TURN_SHARE * agent["kick_dist"][0]
    qx, qy = roll_out(agent, 1)
    moment = turn_body_moment(agent, params, qx + math.cos(heading * DEG), qy + math.sin(heading * DEG), 1)
    x, y, vx, vy, turned = own_state_after(agent, params, TURN, moment)
    error = normalize_degrees(heading - agent["body"][0] - turned)
    bx, by = ball_after(agent, params, 1)
    possible = (x - bx) ** 2 + (y - by) ** 2 < limit * limit
    if possible and abs(error) < FACING:
        return True, True, moment
    decay = params["player_decay"][0]
    vx *= decay
    vy *= decay
    speed = math.sqrt(vx * vx + vy * vy)
    again = turn_moment(params, error, speed) / (1.0 + params["inertia_moment"][0] * speed)
    vx, vy = limited(vx, vy, params["player_speed_max"][0])
    bx, by = ball_after(agent, params, 2)
    if (x + vx - bx) ** 2 + (y + vy - by) ** 2 < limit * limit:
        return True, abs(normalize_degrees(error - again)) < FACING, moment
    return possible, False, moment
