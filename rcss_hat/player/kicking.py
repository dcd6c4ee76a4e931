"""Kicks: how strong one is, and which one brings the ball where it shall go.

Formulas of the UT Austin players (BasicPlayer.cc); the kick model is the server's (19.0.0, 5.4), without noise.
Functions that choose a command return power and direction relative to the body (degrees), not yet truncated.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import DEG, RAD, normalize_degrees
from rcss_hat.numeric.jit import kernel
from rcss_hat.player.geometry import direction_to, sign
from rcss_hat.player.motion import limited, roll_out
from rcss_hat.player.objects import closest_opponent
from rcss_hat.protocol.landmarks import PITCH_LENGTH, PITCH_WIDTH

Record = NDArray[np.void]

READY = 0.85
"""A kick that cannot reach its target is made if it comes up to this part of the strongest one."""
SURPLUS, HURRY = 1.05, 1.30
"""A kick may ask for so much more power than there is; the second when an opponent is within HURRY_DISTANCE."""
HURRY_DISTANCE = 2.0
IN_FRONT = 0.16
"""Part of the kickable margin at which the ball lies best for a strong kick."""
_FROZEN, _AT_REST = 0.8, 0.7
"""Parts of the kickable distance: within the first a stopped ball is near enough, else it is brought to the second."""
_CLOSER = 0.1
"""By so much (m) at least it comes nearer then."""
_INSIDE = 0.2
"""The ball is put at least so many metres inside the pitch."""
_SLOW = 0.1
"""A faster ball (m/cycle) than this is stopped first, when one kick cannot put it close."""


@kernel
def kick_rate(agent: Record, params: Record) -> float:
    """Speed per power that a kick gives the ball from where it lies (m/cycle)."""
    dx, dy = agent["ball_pos"][0, 0] - agent["pos"][0, 0], agent["ball_pos"][0, 1] - agent["pos"][0, 1]
    c, s = agent["body_cos"][0], agent["body_sin"][0]
    angle = abs(math.atan2(dy * c - dx * s, dx * c + dy * s)) / math.pi
    margin = params["kickable_margin"][0]
    gap = (math.sqrt(dx * dx + dy * dy) - params["player_size"][0] - params["ball_size"][0]) / margin
    return params["kick_power_rate"][0] * (1.0 - 0.25 * angle - 0.25 * gap)


@kernel
def ball_after_kick(agent: Record, params: Record, power: float, direction: float) -> tuple[float, float, float, float]:
    """Position (m) and velocity (after decay) of the ball one cycle after a kick, whose numbers get truncated."""
    way = (np.trunc(direction) + agent["body"][0]) * DEG
    push = kick_rate(agent, params) * np.trunc(power)
    vx, vy = limited(
        agent["ball_vel"][0, 0] + push * math.cos(way),
        agent["ball_vel"][0, 1] + push * math.sin(way),
        params["ball_speed_max"][0],
    )
    decay = params["ball_decay"][0]
    return agent["ball_pos"][0, 0] + vx, agent["ball_pos"][0, 1] + vy, vx * decay, vy * decay


@kernel
def _full_kick(agent: Record, params: Record, dx: float, dy: float, rate: float) -> float:
    """Global direction (degrees) of the strongest kick that leaves the ball moving along (dx, dy)."""
    length = math.sqrt(dx * dx + dy * dy)
    across = (agent["ball_vel"][0, 1] * dx - agent["ball_vel"][0, 0] * dy) / length if length > 0.0 else 0.0
    strength = rate * params["maxpower"][0]
    return direction_to(dx, dy) - math.asin(min(max(across / strength, -1.0), 1.0)) * RAD


@kernel
def accelerate_to(agent: Record, params: Record, vx: float, vy: float) -> tuple[float, float]:
    """Kick that gives the ball a velocity (m/cycle), or at least its direction."""
    rate = kick_rate(agent, params)
    ax, ay = vx - agent["ball_vel"][0, 0], vy - agent["ball_vel"][0, 1]
    need = math.sqrt(ax * ax + ay * ay)
    if need < params["ball_accel_max"][0] and need / rate <= params["maxpower"][0]:
        return need / rate, normalize_degrees(direction_to(ax, ay) - agent["body"][0])
    return params["maxpower"][0], normalize_degrees(_full_kick(agent, params, vx, vy, rate) - agent["body"][0])


@kernel
def freeze(agent: Record, params: Record) -> tuple[float, float]:
    """Kick that stops the ball, or else brings it to rest near the player."""
    x, y = roll_out(agent, 1)
    vx, vy = agent["ball_vel"][0, 0], agent["ball_vel"][0, 1]
    power = min(math.sqrt(vx * vx + vy * vy) / kick_rate(agent, params), params["maxpower"][0])
    direction = normalize_degrees(direction_to(vx, vy) + 180.0 - agent["body"][0])
    bx, by, _, _ = ball_after_kick(agent, params, power, direction)
    reach = agent["kick_dist"][0]
    if math.sqrt((bx - x) ** 2 + (by - y) ** 2) < _FROZEN * reach:
        return power, direction
    dx, dy = agent["ball_pos"][0, 0] - x, agent["ball_pos"][0, 1] - y
    distance = math.sqrt(dx * dx + dy * dy)
    part = min(_AT_REST * reach, distance - _CLOSER) / distance if distance > 0.0 else 0.0
    return accelerate_to(
        agent, params, x + part * dx - agent["ball_pos"][0, 0], y + part * dy - agent["ball_pos"][0, 1]
    )


@kernel
def _on_the_pitch(x: float, y: float, distance: float, way: float) -> float:
    """Distance at which a point in a direction still lies well inside the pitch."""
    c, s = math.cos(way), math.sin(way)
    px, py = x + distance * c, y + distance * s
    if abs(py) > 0.5 * PITCH_WIDTH and s != 0.0:
        return abs((sign(py) * 0.5 * PITCH_WIDTH - y) / s) - _INSIDE
    if abs(px) > 0.5 * PITCH_LENGTH and c != 0.0:
        return abs((sign(px) * 0.5 * PITCH_LENGTH - x) / c) - _INSIDE
    return distance


@kernel
def kick_close(agent: Record, params: Record, angle: float, part: float) -> tuple[float, float]:
    """Kick that puts the ball near the body.

    Parameters
    ----------
    agent, params : record
    angle : float
        Where, relative to the body (degrees).
    part : float
        How far out, as part of the kickable margin.
    """
    x, y = roll_out(agent, 1)
    way = (agent["body"][0] + angle) * DEG
    distance = params["player_size"][0] + params["ball_size"][0] + params["kickable_margin"][0] * part
    distance = _on_the_pitch(x, y, distance, way)
    vx, vy = agent["ball_vel"][0, 0], agent["ball_vel"][0, 1]
    ax = x + distance * math.cos(way) - agent["ball_pos"][0, 0] - vx
    ay = y + distance * math.sin(way) - agent["ball_pos"][0, 1] - vy
    power = math.sqrt(ax * ax + ay * ay) / kick_rate(agent, params)
    if power > params["maxpower"][0]:
        if vx * vx + vy * vy > _SLOW * _SLOW:
            return freeze(agent, params)
        power = params["maxpower"][0]
    return power, normalize_degrees(direction_to(ax, ay) - agent["body"][0])


@kernel
def kick_to(agent: Record, params: Record, x: float, y: float, end_speed: float) -> tuple[float, float]:
    """Kick, or first of several, that sends the ball to a point.

    Parameters
    ----------
    agent, params : record
    x, y : float
        Target (m).
    end_speed : float
        Speed with which the ball shall arrive (m/cycle).
    """
    dx, dy = x - agent["ball_pos"][0, 0], y - agent["ball_pos"][0, 1]
    distance = math.sqrt(dx * dx + dy * dy)
    if distance == 0.0:
        dx, distance = 1e-10, 1e-10
    ux, uy = dx / distance, dy / distance
    growth = 1.0 / params["ball_decay"][0]
    cycles = float(round(math.log(distance * (growth - 1.0) / end_speed + 1.0) / math.log(growth)))
    speed = _past_own_body(agent, params, ux, uy, end_speed * growth**cycles)
    vx, vy = ux * speed, uy * speed
    rate = kick_rate(agent, params)
    if abs(speed) > params["ball_speed_max"][0]:
        return _unreachable(agent, params, vx, vy, rate)
    need = math.sqrt((vx - agent["ball_vel"][0, 0]) ** 2 + (vy - agent["ball_vel"][0, 1]) ** 2) / rate
    if need > SURPLUS * params["maxpower"][0]:
        _, opponent = closest_opponent(agent, agent["ball_pos"][0, 0], agent["ball_pos"][0, 1])
        if opponent >= HURRY_DISTANCE or need > HURRY * params["maxpower"][0]:
            return kick_close(agent, params, 0.0, IN_FRONT)
    return accelerate_to(agent, params, vx, vy)


@kernel
def _past_own_body(agent: Record, params: Record, ux: float, uy: float, speed: float) -> float:
    """Change a first speed (m/cycle) that would make the ball end its first cycle in the player itself."""
    size = params["player_size"][0] + params["ball_size"][0]
    x, y = roll_out(agent, 1)
    bx, by = agent["ball_pos"][0, 0], agent["ball_pos"][0, 1]
    if (bx + ux * speed - x) ** 2 + (by + uy * speed - y) ** 2 >= size * size:
        return speed
    foot = abs((agent["pos"][0, 0] - bx) * ux + (agent["pos"][0, 1] - by) * uy)
    return foot - size if speed < foot else foot + size


@kernel
def _unreachable(agent: Record, params: Record, vx: float, vy: float, rate: float) -> tuple[float, float]:
    """Kick for a target too far for any kick: shoot if the ball lies well, else prepare."""
    strength = rate * params["maxpower"][0]
    way = _full_kick(agent, params, vx, vy, rate) * DEG
    sx = agent["ball_vel"][0, 0] + strength * math.cos(way)
    sy = agent["ball_vel"][0, 1] + strength * math.sin(way)
    if math.sqrt(sx * sx + sy * sy) > READY * params["ball_accel_max"][0]:
        return accelerate_to(agent, params, vx, vy)
    if rate > READY * params["kick_power_rate"][0]:
        return freeze(agent, params)
    return kick_close(agent, params, 0.0, IN_FRONT)
