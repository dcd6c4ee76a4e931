"""How a player will move: rolling, dashing, turning, and the planned move towards a point.

Straight motion is predicted in the body frame, where it needs no trigonometry: `forward` and `side` are the target's
coordinates there, `v_forward` and `v_side` the velocity after decay. A dash changes `v_forward` only; a turn rotates
target and velocity.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import DEG, RAD, normalize_degrees
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.player.geometry import direction_to, whole_cos, whole_sin
from rcss_hat.player.records import N_AHEAD
from rcss_hat.protocol.records import DASH, TURN

Record = NDArray[np.void]

TURN_AROUND_DISTANCE = 2.5
"""Targets nearer than this may be reached backwards (m)."""
_ATAN_1_5 = math.atan(1.5) * RAD


@kernel
def face(agent: Record, neck: float) -> None:
    """Set the global direction of the own neck; the body follows from the sensed head angle."""
    neck = normalize_degrees(neck)
    if neck == agent["neck"][0]:
        face_along(agent, neck, agent["neck_cos"][0], agent["neck_sin"][0])
    else:
        face_along(agent, neck, math.cos(neck * DEG), math.sin(neck * DEG))


@inlined
def face_along(agent: Record, neck: float, c: float, s: float) -> None:
    """`face` for a direction in (-180, 180] whose cosine and sine are known."""
    head = agent["head"][0]
    agent["neck"][0] = neck
    agent["neck_cos"][0] = c
    agent["neck_sin"][0] = s
    agent["body"][0] = normalize_degrees(neck - head)
    agent["body_cos"][0] = c * whole_cos(head) + s * whole_sin(head)
    agent["body_sin"][0] = s * whole_cos(head) - c * whole_sin(head)


@inlined
def sensed_velocity(agent: Record) -> tuple[float, float]:
    """Own velocity (m/cycle, after decay) as sensed, for the present direction of the neck."""
    c, s = whole_cos(agent["speed_direction"][0]), whole_sin(agent["speed_direction"][0])
    speed, neck_cos, neck_sin = agent["speed"][0], agent["neck_cos"][0], agent["neck_sin"][0]
    return speed * (neck_cos * c - neck_sin * s), speed * (neck_sin * c + neck_cos * s)


@inlined
def limited(vx: float, vy: float, top: float) -> tuple[float, float]:
    """Return a velocity, shortened to a speed limit if need be."""
    speed2 = vx * vx + vy * vy
    if speed2 > top * top:
        scale = top / math.sqrt(speed2)
        return vx * scale, vy * scale
    return vx, vy


@inlined
def roll_out(agent: Record, cycles: int) -> tuple[float, float]:
    """Own position after rolling up to 4 cycles (m)."""
    roll = agent["roll"][0, cycles]
    return agent["pos"][0, 0] + agent["vel"][0, 0] * roll, agent["pos"][0, 1] + agent["vel"][0, 1] * roll


@inlined
def ball_after(agent: Record, params: Record, cycles: int) -> tuple[float, float]:
    """Position of the ball after rolling freely for some cycles (m)."""
    if cycles < N_AHEAD:
        roll = agent["ball_roll"][0, cycles]
    else:
        decay = params["ball_decay"][0]
        roll = (1.0 - decay**cycles) / (1.0 - decay)
    return (
        agent["ball_pos"][0, 0] + agent["ball_vel"][0, 0] * roll,
        agent["ball_pos"][0, 1] + agent["ball_vel"][0, 1] * roll,
    )


@inlined
def to_body(agent: Record, x: float, y: float) -> tuple[float, float]:
    """Turn a vector of the own frame into (forward, side) of the body."""
    c, s = agent["body_cos"][0], agent["body_sin"][0]
    return x * c + y * s, y * c - x * s


@inlined
def dash_acceleration(
    agent: Record, params: Record, forward: float, v_forward: float, cycles: int, strongest: float
) -> float:
    """Acceleration of the first of some dashes that together cover a distance along the body (m/cycle2).

    Parameters
    ----------
    agent, params : record
    forward : float
        Distance (m).
    v_forward : float
        Speed along the body (m/cycle).
    cycles : int
        Number of cycles, from 1.
    strongest : float
        Acceleration of a dash with full power, see `strongest_dash`.
    """
    speed = min(forward * agent["first_share"][0, cycles], params["player_speed_max"][0])
    return min(max(speed - v_forward, -strongest), strongest)


@inlined
def strongest_dash(agent: Record, params: Record) -> float:
    """Acceleration of a dash with full power (m/cycle2); a dash backwards is taken to be as strong."""
    return params["maxpower"][0] * params["dash_power_rate"][0] * agent["effort"][0]


@kernel
def dash_power(agent: Record, params: Record, forward: float, v_forward: float, cycles: int) -> float:
    """Power of the first of some dashes that together cover a distance along the body.

    Parameters
    ----------
    agent, params : record
    forward : float
        Distance (m).
    v_forward : float
        Speed along the body (m/cycle).
    cycles : int
        Number of cycles; below 1 counts as 1.
    """
    speed = forward * agent["first_share"][0, min(max(cycles, 1), N_AHEAD - 1)]
    speed = min(speed, params["player_speed_max"][0])
    power = (speed - v_forward) / (params["dash_power_rate"][0] * agent["effort"][0])
    return min(max(power, params["minpower"][0]), params["maxpower"][0])


@kernel
def turn_moment(params: Record, angle: float, speed: float) -> float:
    """Argument of the turn command that turns by an angle at a speed (degrees)."""
    moment = angle * (1.0 + params["inertia_moment"][0] * speed)
    return min(max(moment, params["minmoment"][0]), params["maxmoment"][0])


@inlined
def needs_turn(
    agent: Record, forward: float, side: float, v_forward: float, v_side: float, cycles: int, back: float
) -> bool:
    """Tell whether the planned move towards a point begins with a turn.

    It does when the line along the body, through the point where the player would roll to, passes too far from the
    target, or when the target lies behind and not near.
    """
    roll = agent["roll"][0, min(cycles, 4)]
    ahead = forward - v_forward * roll
    across = side - v_side * roll
    distance2 = forward * forward + side * side
    wide = 0.9
    if distance2 > 100.0:
        wide = 3.0 if distance2 > 400.0 else 2.0
    if abs(across) > wide * agent["kick_dist"][0]:
        return True
    return ahead < 0.0 and ahead * ahead + across * across > back * back


@kernel
def planned_turn(
    agent: Record,
    params: Record,
    forward: float,
    side: float,
    v_forward: float,
    v_side: float,
    cycles: int,
    back: float,
) -> float:
    """Moment of the turn with which a planned move begins (degrees).

    When one turn is not enough and the target is near in space and time, the player turns its back instead if that
    takes one turn only.
    """
    roll = agent["roll"][0, min(cycles, 4)]
    ahead = forward - v_forward * roll
    across = side - v_side * roll
    angle = math.atan2(across, ahead) * RAD
    inertia = 1.0 + params["inertia_moment"][0] * math.sqrt(v_forward * v_forward + v_side * v_side)
    top = params["maxmoment"][0]
    moment = min(max(angle * inertia, params["minmoment"][0]), top)
    if abs(angle * inertia) <= top or cycles >= 4 or ahead * ahead + across * across >= back * back:
        return moment
    limit = 0.9 * agent["kick_dist"][0]
    turned = moment / inertia * DEG
    if abs(across * math.cos(turned) - ahead * math.sin(turned)) <= limit:
        return moment
    back_moment = min(max(normalize_degrees(angle + 180.0) * inertia, params["minmoment"][0]), top)
    turned = back_moment / inertia * DEG
    if abs(across * math.cos(turned) - ahead * math.sin(turned)) < limit:
        return back_moment
    return moment


@kernel
def planned_move(agent: Record, params: Record, x: float, y: float, cycles: int, back: float) -> tuple[int, float]:
    """First command of a plan to be at a point in some cycles.

    Returns
    -------
    (int, float)
        TURN and moment (degrees), or DASH and power.
    """
    forward, side = to_body(agent, x - agent["pos"][0, 0], y - agent["pos"][0, 1])
    v_forward, v_side = to_body(agent, agent["vel"][0, 0], agent["vel"][0, 1])
    if needs_turn(agent, forward, side, v_forward, v_side, cycles, back):
        return TURN, planned_turn(agent, params, forward, side, v_forward, v_side, cycles, back)
    return DASH, dash_power(agent, params, forward, v_forward, cycles)


@kernel
def planned_rotation(
    agent: Record, params: Record, forward: float, side: float, v_forward: float, v_side: float, cycles: int
) -> tuple[float, float]:
    """Cosine and sine of the angle that the turn of a planned move turns by."""
    roll = agent["roll"][0, min(cycles, 4)]
    ahead = forward - v_forward * roll
    across = side - v_side * roll
    inertia = 1.0 + params["inertia_moment"][0] * math.sqrt(v_forward * v_forward + v_side * v_side)
    if ahead > 0.0 and abs(across) < 1.5 * ahead and inertia * _ATAN_1_5 < params["maxmoment"][0]:
        # One turn is enough: afterwards the body points at the target.
        scale = 1.0 / math.sqrt(ahead * ahead + across * across)
        return ahead * scale, across * scale
    moment = planned_turn(agent, params, forward, side, v_forward, v_side, cycles, TURN_AROUND_DISTANCE)
    turned = moment / inertia * DEG
    return math.cos(turned), math.sin(turned)


@inlined
def after_turn(
    params: Record, c: float, s: float, forward: float, side: float, v_forward: float, v_side: float
) -> tuple[float, float, float, float]:
    """Target and velocity in the body frame after a cycle in which the player turned by an angle (cosine, sine)."""
    v_forward, v_side = limited(v_forward, v_side, params["player_speed_max"][0])
    forward -= v_forward
    side -= v_side
    decay = params["player_decay"][0]
    return (
        forward * c + side * s,
        side * c - forward * s,
        decay * (v_forward * c + v_side * s),
        decay * (v_side * c - v_forward * s),
    )


@inlined
def after_dash(
    params: Record, acceleration: float, forward: float, side: float, v_forward: float, v_side: float
) -> tuple[float, float, float, float]:
    """Target and velocity in the body frame after a cycle in which the player dashed."""
    v_forward, v_side = limited(v_forward + acceleration, v_side, params["player_speed_max"][0])
    decay = params["player_decay"][0]
    return forward - v_forward, side - v_side, v_forward * decay, v_side * decay


@kernel
def miss_after(
    agent: Record, params: Record, forward: float, side: float, v_forward: float, v_side: float, cycles: int
) -> float:
    """Distance to a point after planned moves that shall reach it in some cycles (m)."""
    strongest = strongest_dash(agent, params)
    for i in range(cycles):
        left = cycles - i
        if needs_turn(agent, forward, side, v_forward, v_side, left, TURN_AROUND_DISTANCE):
            c, s = planned_rotation(agent, params, forward, side, v_forward, v_side, left)
            forward, side, v_forward, v_side = after_turn(params, c, s, forward, side, v_forward, v_side)
        else:
            acceleration = dash_acceleration(agent, params, forward, v_forward, left, strongest)
            forward, side, v_forward, v_side = after_dash(params, acceleration, forward, side, v_forward, v_side)
    return math.sqrt(forward * forward + side * side)


@kernel
def own_state_after(
    agent: Record, params: Record, kind: int, amount: float
) -> tuple[float, float, float, float, float]:
    """Own state one cycle ahead, as the server would make it without noise.

    Parameters
    ----------
    agent, params : record
    kind : int
        Body command; everything but DASH and TURN lets the player roll.
    amount : float
        Power or moment.

    Returns
    -------
    tuple of float
        x, y (m), velocity before decay (m/cycle), and the angle turned by (degrees).
    """
    vx, vy = agent["vel"][0, 0], agent["vel"][0, 1]
    turned = 0.0
    if kind == DASH:
        acceleration = amount * params["dash_power_rate"][0] * agent["effort"][0]
        vx += acceleration * agent["body_cos"][0]
        vy += acceleration * agent["body_sin"][0]
    elif kind == TURN:
        turned = amount / (1.0 + params["inertia_moment"][0] * math.sqrt(vx * vx + vy * vy))
    vx, vy = limited(vx, vy, params["player_speed_max"][0])
    return agent["pos"][0, 0] + vx, agent["pos"][0, 1] + vy, vx, vy, turned


@kernel
def turn_body_moment(agent: Record, params: Record, x: float, y: float, cycles: int) -> float:
    """Moment that turns the body towards a point as seen from where the player will have rolled to (degrees)."""
    px, py = roll_out(agent, cycles)
    angle = normalize_degrees(direction_to(x - px, y - py) - agent["body"][0])
    vx, vy = agent["vel"][0, 0], agent["vel"][0, 1]
    return turn_moment(params, angle, math.sqrt(vx * vx + vy * vy))
