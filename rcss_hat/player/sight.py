"""What a see message changes: own pose, players, ball, and the ghosts of those who should have been seen."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import DEG, normalize_degrees
from rcss_hat.numeric.jit import kernel
from rcss_hat.player.bodily import set_ball
from rcss_hat.player.geometry import whole_cos, whole_sin
from rcss_hat.player.ghosts import remove_ghosts
from rcss_hat.player.localisation import locate
from rcss_hat.player.motion import face_along, sensed_velocity
from rcss_hat.player.objects import FAR, closest_opponent, distance2_to, is_known
from rcss_hat.player.records import N_SLOTS, OPPONENTS
from rcss_hat.player.strangers import forget_strangers_near, recognise
from rcss_hat.protocol.records import (
    BALL,
    CLOSE_BALL,
    CLOSE_PLAYER,
    HAS_CHANGE,
    HAS_DISTANCE,
    HAS_FACING,
    OWN_TEAM,
    PLAYER,
    UNKNOWN_TEAM,
)

Record = NDArray[np.void]

_STILL = 1e-4


@kernel
def shows_everyone(agent: Record, see: Record) -> bool:
    """Tell whether a see message shows every other known player, with number."""
    shown = 1 << agent["me"][0]
    for i in range(see["n"][0] - 1, -1, -1):
        code = see["code"][0, i]
        if code < BALL:
            break
        if code == PLAYER and see["fields"][0, i] & HAS_CHANGE and see["unum"][0, i] > 0:
            shown |= 1 << _slot(see, i)
    missing = 0
    for o in range(agent["top_own"][0]):
        if not (shown >> o) & 1 and is_known(agent, o):
            missing += 1
    for o in range(OPPONENTS, agent["top_other"][0]):
        if not (shown >> o) & 1 and is_known(agent, o):
            missing += 1
    return missing == 0


@kernel
def _slot(see: Record, i: int) -> int:
    slot = int(see["unum"][0, i]) - 1
    return slot if see["team"][0, i] == OWN_TEAM else slot + OPPONENTS


@kernel
def watch(agent: Record, params: Record, see: Record) -> None:
    """Apply a see message."""
    agent["see_time"][0] = see["time"][0]
    _set_pose(agent, see)
    strangers, ball = False, -1
    for i in range(see["n"][0] - 1, -1, -1):
        code = see["code"][0, i]
        if code < BALL:
            break
        if not see["fields"][0, i] & HAS_DISTANCE:
            continue
        if code in (BALL, CLOSE_BALL):
            ball = i
        elif code in (PLAYER, CLOSE_PLAYER):
            if code == PLAYER and see["unum"][0, i] > 0 and see["team"][0, i] != UNKNOWN_TEAM:
                _see_player(agent, params, see, i, _slot(see, i))
            else:
                strangers = True
    if strangers:
        recognise(agent, params, see)
    if ball >= 0:
        _see_ball(agent, params, see, ball)
    remove_ghosts(agent, params)


@kernel
def _set_pose(agent: Record, see: Record) -> None:
    x, y, neck, c, s = locate(agent, see)
    face_along(agent, neck, c, s)
    agent["shift"][0, 0] = x - agent["pos"][0, 0]
    agent["shift"][0, 1] = y - agent["pos"][0, 1]
    agent["pos"][0, 0] = x
    agent["pos"][0, 1] = y
    agent["vel"][0, 0], agent["vel"][0, 1] = sensed_velocity(agent)
    me, time = agent["me"][0], see["time"][0]
    agent["player_seen"][0, me] = time
    agent["player_see_time"][0, me] = time
    for axis in range(2):
        agent["player_pos"][0, me, axis] = agent["pos"][0, axis]
        agent["player_see_pos"][0, me, axis] = agent["pos"][0, axis]


@kernel
def _world_direction(agent: Record, see: Record, i: int) -> tuple[float, float]:
    """Unit vector towards a seen object."""
    dc, ds = whole_cos(see["direction"][0, i]), whole_sin(see["direction"][0, i])
    c, s = agent["neck_cos"][0], agent["neck_sin"][0]
    return dc * c - ds * s, dc * s + ds * c


@kernel
def _seen_velocity(agent: Record, see: Record, i: int, wx: float, wy: float) -> tuple[float, float]:
    """Velocity (m/cycle) of an object seen in the direction (wx, wy), from the changes of distance and direction."""
    outwards = see["distance_change"][0, i]
    around = see["direction_change"][0, i] * DEG * see["distance"][0, i]
    return agent["vel"][0, 0] + outwards * wx - around * wy, agent["vel"][0, 1] + outwards * wy + around * wx


@kernel
def _see_player(agent: Record, params: Record, see: Record, i: int, o: int) -> None:
    """Take over what is seen of a player whose number was read."""
    time, fields = see["time"][0], see["fields"][0, i]
    wx, wy = _world_direction(agent, see, i)
    x = agent["pos"][0, 0] + see["distance"][0, i] * wx
    y = agent["pos"][0, 1] + see["distance"][0, i] * wy
    if agent["guessed"][0]:
        forget_strangers_near(agent, params, o, x, y)
    vx, vy = agent["player_vel"][0, o, 0], agent["player_vel"][0, o, 1]
    if fields & HAS_CHANGE:
        vx, vy = _seen_velocity(agent, see, i, wx, wy)
        agent["player_change"][0, o] = time
        speed2, top = vx * vx + vy * vy, params["player_speed_max"][0]
        if speed2 >= ((1.0 + params["player_rand"][0]) * top) ** 2:
            scale = top / math.sqrt(speed2)
            vx *= scale
            vy *= scale
        elif speed2 < _STILL * _STILL:
            vx, vy = 0.0, 0.0
    agent["player_vel"][0, o, 0] = vx
    agent["player_vel"][0, o, 1] = vy
    if fields & HAS_FACING:
        body = normalize_degrees(agent["neck"][0] + see["body"][0, i])
        agent["player_body"][0, o] = body
        agent["player_see_body"][0, o] = body
        agent["player_angles"][0, o] = time
        agent["player_see_vel"][0, o, 0] = vx
        agent["player_see_vel"][0, o, 1] = vy
    agent["player_pos"][0, o, 0] = x
    agent["player_pos"][0, o, 1] = y
    agent["player_see_pos"][0, o, 0] = x
    agent["player_see_pos"][0, o, 1] = y
    agent["player_time"][0, o] = time
    agent["player_see_time"][0, o] = time
    agent["player_seen"][0, o] = time
    agent["player_known"][0, o] = 1


@kernel
def _see_ball(agent: Record, params: Record, see: Record, i: int) -> None:
    """Take over what is seen of the ball."""
    time, distance = see["time"][0], see["distance"][0, i]
    wx, wy = _world_direction(agent, see, i)
    x, y = agent["pos"][0, 0] + distance * wx, agent["pos"][0, 1] + distance * wy
    if see["fields"][0, i] & HAS_CHANGE:
        agent["ball_change"][0] = time
        vx, vy = _seen_velocity(agent, see, i, wx, wy)
        expected_x, expected_y = agent["ball_vel"][0, 0], agent["ball_vel"][0, 1]
        usual = 2.0 * params["ball_rand"][0] * math.sqrt(expected_x * expected_x + expected_y * expected_y)
        if abs(vx - expected_x) <= usual and abs(vy - expected_y) <= usual:
            # Both are off by chance only: what was expected by the ball's noise, what is seen by rounding.
            vx, vy = 0.5 * (vx + expected_x), 0.5 * (vy + expected_y)
    else:
        vx, vy = _ball_velocity_from_positions(agent, params, time, distance, x, y)
    reach = agent["kick_dist"][0]
    _, opponent = closest_opponent(agent, x, y)
    speed2, top = vx * vx + vy * vy, params["ball_speed_max"][0]
    if opponent < reach and distance > reach:  # he has it, and will have stopped it
        vx, vy = 0.0, 0.0
    elif speed2 > ((1.0 + params["ball_rand"][0]) * top) ** 2:
        scale = top / math.sqrt(speed2)
        vx *= scale
        vy *= scale
    set_ball(agent, x, y, vx, vy)
    agent["ball_see_pos"][0, 0] = x
    agent["ball_see_pos"][0, 1] = y
    agent["ball_see_time"][0] = time
    agent["ball_seen"][0] = time


@kernel
def _ball_velocity_from_positions(
    agent: Record, params: Record, time: int, distance: float, x: float, y: float
) -> tuple[float, float]:
    """Velocity (m/cycle) of a near ball that is seen without it, from where it was one or two cycles ago."""
    cycles = time - agent["ball_see_time"][0]
    vx, vy = agent["ball_vel"][0, 0], agent["ball_vel"][0, 1]
    if distance >= params["visible_distance"][0] or agent["collided"][0]:
        return vx, vy
    dx = x - agent["ball_see_pos"][0, 0] - agent["shift"][0, 0]
    dy = y - agent["ball_see_pos"][0, 1] - agent["shift"][0, 1]
    decay = params["ball_decay"][0]
    if cycles == 1:
        return dx * decay, dy * decay
    if cycles == 2 and not agent["kicked"][0] and agent["now"][0] - agent["collision_time"][0] > 3:
        part = decay / (1.0 + decay)
        if _closest_player(agent, x - dx * part, y - dy * part) > agent["kick_dist"][0]:
            return dx * part * decay, dy * part * decay
    return vx, vy


@kernel
def _closest_player(agent: Record, x: float, y: float) -> float:
    """Distance of the nearest known player, oneself included (m)."""
    best2 = FAR * FAR
    for o in range(N_SLOTS):
        if is_known(agent, o):
            best2 = min(best2, distance2_to(agent, o, x, y))
    return math.sqrt(best2)
