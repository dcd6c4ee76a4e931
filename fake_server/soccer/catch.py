"""Goalie's catch.

Source: 19.0.0, src/player.cpp (goalieCatch) and src/referee.cpp (CatchRef, ballCaught); not used in Keepaway. Back
passes are not detected.
"""

from __future__ import annotations

import math

from fake_server.soccer.referee import free_kick
from rcss_hat.numeric.angles import DEG
from rcss_hat.numeric.rng import bernoulli
from rcss_hat.protocol.records import LEFT
from rcss_hat.simulation.collision import resolve_collisions
from rcss_hat.simulation.dash import clamp
from rcss_hat.simulation.pitch import in_penalty_area, move_out_of_penalty_area, truncate_to_pitch
from rcss_hat.simulation.placement import place_ball
from rcss_hat.simulation.referee import change_play_mode, other_side
from rcss_hat.simulation.state import (
    C_CATCH,
    CATCH_FAULT_LEFT,
    CATCH_FAULT_RIGHT,
    E_CAUGHT,
    F_CATCH,
    F_CATCH_FAULT,
    PHYSICS,
    PLAY_ON,
    side_of,
)
from rcss_hat.simulation.world import World


def catch_probability(world: World, i: int, angle: float) -> float:
    """Probability that a catch in a direction (radians, world) succeeds; -1 outside the goalie's area.

    The area is a rectangle before him, ``catchable_area_l * stretch`` long and ``catchable_area_w`` wide; in its
    stretched part the probability falls to 0.
    """
    match, params, types = world.match, world.params, world.types
    dx = match["ball_pos"][0, 0] - match["pos"][0, i, 0]
    dy = match["ball_pos"][0, 1] - match["pos"][0, i, 1]
    c, s = math.cos(-angle), math.sin(-angle)
    x, y = dx * c - dy * s, dx * s + dy * c
    length = params["catchable_area_l"][0]
    stretch = length * (types["catchable_area_l_stretch"][match["type"][0, i]] - 1.0)
    if abs(y) > 0.5 * params["catchable_area_w"][0] or not 0.0 <= x <= length + stretch:
        return -1.0
    certain = params["catch_probability"][0]
    if x <= length - stretch:
        return float(certain)
    return float(min(max(certain - certain * (x - length + stretch) / (2.0 * stretch), 0.0), 1.0))


def _award(world: World, i: int) -> None:
    """Give the free kick for a catch, or for a catch outside the penalty area to the other side."""
    match, params = world.match, world.params
    side = side_of(i)
    x, y = match["ball_pos"][0, 0], match["ball_pos"][0, 1]
    match["events"][0] |= E_CAUGHT
    if in_penalty_area(side, x, y, params["ball_size"][0]):
        x, y = truncate_to_pitch(x, y)
        x, y = move_out_of_penalty_area(other_side(side), x, y)
        free_kick(world, side, x, y)
        match["catcher"][0] = i
        return
    x, y = truncate_to_pitch(x, y)
    x, y = move_out_of_penalty_area(side, x, y)
    match["catcher"][0] = -1
    place_ball(match, x, y, 0.0, 0.0)
    match["kick_off_side"][0] = other_side(side)
    change_play_mode(world, CATCH_FAULT_LEFT if side == LEFT else CATCH_FAULT_RIGHT)


def try_catch(world: World, i: int, angle: float) -> tuple[bool, bool]:
    """Try to catch the ball in a direction (radians, world).

    Returns
    -------
    reached : bool
        The ball was in the area.
    caught : bool
        It was caught; when only reached, it bounces off.
    """
    match, params, rng = world.match, world.params, world.streams[PHYSICS]
    probability = catch_probability(world, i, angle)
    if probability < 0.0:
        return False, False
    if not bernoulli(rng, probability):
        vx, vy = match["ball_vel"][0, 0], match["ball_vel"][0, 1]
        along = 2.0 * (vx * math.cos(angle) + vy * math.sin(angle))
        match["ball_acc"][0, 0] -= along * math.cos(angle)
        match["ball_acc"][0, 1] -= along * math.sin(angle)
        return True, False
    dx = match["ball_pos"][0, 0] - match["pos"][0, i, 0]
    dy = match["ball_pos"][0, 1] - match["pos"][0, i, 1]
    far = math.sqrt(dx * dx + dy * dy)
    scale = (far - params["ball_size"][0] - match["size"][0, i]) / max(far, 1e-10)
    match["pos"][0, i, 0] += dx * scale
    match["pos"][0, i, 1] += dy * scale
    if scale != 0.0 and far > 0.0:
        match["body_pending"][0, i] = math.atan2(dy * scale, dx * scale)
    match["vel"][0, i, 0] = match["vel"][0, i, 1] = 0.0
    resolve_collisions(world)
    _award(world, i)
    return True, True


def catch_ball(world: World, i: int, direction: float) -> bool:
    """Catch in a direction (degrees from the body); only a goalie can, in play_on, every ``catch_ban_cycle`` cycles."""
    match, params = world.match, world.params
    if match["command_done"][0, i]:
        return False
    match["command_done"][0, i] = 1
    match["flags_next"][0, i] |= F_CATCH
    if not match["goalie"][0, i] or match["catch_ban"][0, i] > 0 or match["mode"][0] != PLAY_ON:
        match["flags_next"][0, i] |= F_CATCH_FAULT
        return False
    if not params["version_11"][0]:
        match["catch_ban"][0, i] = int(params["catch_ban_cycle"][0])
    direction = clamp(direction, params["min_catch_angle"][0], params["max_catch_angle"][0])
    reached, caught = try_catch(world, i, match["body"][0, i] + direction * DEG)
    if not caught:
        match["flags_next"][0, i] |= F_CATCH_FAULT
    elif params["version_11"][0]:
        match["catch_ban"][0, i] = int(params["catch_ban_cycle"][0])
    if not reached:
        return False
    match["counts"][0, i, C_CATCH] += 1
    match["moves_since_catch"][0, i] = 0
    return True
