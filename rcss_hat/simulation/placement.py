"""Putting ball and players somewhere: by the referee and by a trainer.

Source: 19.0.0, src/stadium.cpp (moveBall, movePlayer, placePlayersInField) and src/referee.cpp
(placePlayersInTheirField, clearPlayersFromBall).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.numeric.rng import uniform
from rcss_hat.protocol.records import LEFT, NO_SIDE, RIGHT
from rcss_hat.simulation.collision import resolve_collisions
from rcss_hat.simulation.pitch import (
    CLEAR_DISTANCE,
    GOAL_AREA_LENGTH,
    HALF_LENGTH,
    HALF_WIDTH,
    MAX_X,
    MAX_Y,
    in_penalty_area,
    nearest_in_world,
    out_of_circle,
)
from rcss_hat.simulation.state import (
    BACK_PASS_LEFT,
    BACK_PASS_RIGHT,
    FOUL_CHARGE_LEFT,
    FOUL_CHARGE_RIGHT,
    FOUL_PUSH_LEFT,
    FOUL_PUSH_RIGHT,
    ILLEGAL_DEFENSE_LEFT,
    ILLEGAL_DEFENSE_RIGHT,
    INDIRECT_FREE_KICK_LEFT,
    INDIRECT_FREE_KICK_RIGHT,
    KICK_OFF_LEFT,
    KICK_OFF_RIGHT,
    PHYSICS,
    recover,
    side_of,
)
from rcss_hat.simulation.world import World

_CLEAR_ROUNDS = 10
_CLEAR_EXTRA = 1e-5


@inlined
def place_ball(match: NDArray[np.void], x: float, y: float, vx: float, vy: float) -> None:
    """Put the ball somewhere (m) with a velocity (m/cycle)."""
    match["ball_pos"][0, 0], match["ball_pos"][0, 1] = x, y
    match["ball_vel"][0, 0], match["ball_vel"][0, 1] = vx, vy
    match["ball_acc"][0, 0], match["ball_acc"][0, 1] = 0.0, 0.0


@kernel
def place_player(match: NDArray[np.void], i: int, x: float, y: float) -> None:
    """Put a player somewhere (m), at rest; his angles stay."""
    match["pos"][0, i, 0], match["pos"][0, i, 1] = x, y
    for axis in range(2):
        match["vel"][0, i, axis] = 0.0
        match["acc"][0, i, axis] = 0.0


def move_player_to(world: World, i: int, x: float, y: float) -> None:
    """Put a player somewhere as a trainer does: velocity and angles stay, collisions are resolved at once.

    To set the body or the velocity too, write ``body``, ``body_pending`` and ``vel`` of the match first.
    """
    match = world.match
    match["pos"][0, i, 0], match["pos"][0, i, 1] = x, y
    resolve_collisions(world)


@kernel
def recover_all(match: NDArray[np.void], params: NDArray[np.void]) -> None:
    """Restore the stamina and hearing of all enabled players."""
    for k in range(match["n_players"][0]):
        recover(match, params, match["players"][0, k])


@inlined
def keep_in_world(match: NDArray[np.void]) -> None:
    """Bring players who left the pitch and its margin back to its edge; their velocity stays."""
    pos = match["pos"][0]
    for k in range(match["n_players"][0]):
        i = match["players"][0, k]
        if abs(pos[i, 0]) > MAX_X or abs(pos[i, 1]) > MAX_Y:
            pos[i, 0], pos[i, 1] = nearest_in_world(pos[i, 0], pos[i, 1])


def place_in_own_half(world: World) -> None:
    """Send players beyond the half line back, and those of the other side out of the centre circle."""
    match, params, rng = world.match, world.params, world.streams[PHYSICS]
    at_kick_off = params["forbid_kick_off_offside"][0] > 0.0 and (
        match["mode"][0] == KICK_OFF_LEFT or match["mode"][0] == KICK_OFF_RIGHT
    )
    pos = match["pos"][0]
    for k in range(match["n_players"][0]):
        i = match["players"][0, k]
        side = side_of(i)
        sign = 1.0 if side == LEFT else -1.0
        size = match["size"][0, i]
        if pos[i, 0] * sign > 0.0:
            if at_kick_off:
                pos[i, 0] = -size * sign
            else:
                pos[i, 0] = -sign * uniform(rng, 0.0, HALF_LENGTH)
                pos[i, 1] = uniform(rng, -HALF_WIDTH, HALF_WIDTH)
        if side != match["kick_off_side"][0]:
            radius = CLEAR_DISTANCE + size
            if pos[i, 0] * pos[i, 0] + pos[i, 1] * pos[i, 1] <= radius * radius:
                pos[i, 0], pos[i, 1] = out_of_circle(pos[i, 0], pos[i, 1], 0.0, 0.0, radius)


def _clear_distance(mode: int, ball_x: float, ball_y: float, ball_size: float) -> float:
    """Distance (m) that players keep from the ball in a play mode."""
    if mode in (ILLEGAL_DEFENSE_LEFT, ILLEGAL_DEFENSE_RIGHT, BACK_PASS_LEFT, BACK_PASS_RIGHT):
        return GOAL_AREA_LENGTH
    if mode in (FOUL_CHARGE_LEFT, FOUL_PUSH_LEFT) and in_penalty_area(LEFT, ball_x, ball_y, ball_size):
        return GOAL_AREA_LENGTH
    if mode in (FOUL_CHARGE_RIGHT, FOUL_PUSH_RIGHT) and in_penalty_area(RIGHT, ball_x, ball_y, ball_size):
        return GOAL_AREA_LENGTH
    return CLEAR_DISTANCE


def _is_indirect(mode: int) -> bool:
    """Tell whether defenders may stand on the goal line in a play mode."""
    if mode in (BACK_PASS_LEFT, BACK_PASS_RIGHT, INDIRECT_FREE_KICK_LEFT, INDIRECT_FREE_KICK_RIGHT):
        return True
    return FOUL_CHARGE_LEFT <= mode <= FOUL_PUSH_RIGHT


@kernel
def _along_border(
    x: float, y: float, ball_x: float, ball_y: float, border: float, radius: float
) -> tuple[float, float]:
    """Where the circle round the ball meets a border x = const that a point (x, y) is beyond, on the point's side."""
    beyond = (border - abs(ball_x)) / radius
    away = radius * math.sqrt(max(0.0, 1.0 - beyond * beyond)) + _CLEAR_EXTRA
    return math.copysign(border, x), ball_y - away if y < ball_y else ball_y + away


@kernel
def _cleared(
    x: float, y: float, ball_x: float, ball_y: float, radius: float, at_corner: bool, indirect: bool
) -> tuple[float, float]:
    """New place of a player who stands too near to the ball."""
    x, y = out_of_circle(x, y, ball_x, ball_y, radius + _CLEAR_EXTRA)
    if at_corner and abs(x) > HALF_LENGTH and abs(y) > HALF_WIDTH:
        x, y = 2.0 * ball_x - x, 2.0 * ball_y - y
    if indirect and abs(x) > HALF_LENGTH:
        slope = (y - ball_y) / (x - ball_x)
        x = math.copysign(HALF_LENGTH, x)
        y = ball_y + slope * (x - ball_x)
    if abs(x) > MAX_X:
        x, y = _along_border(x, y, ball_x, ball_y, MAX_X, radius)
    if abs(y) > MAX_Y:
        y, x = _along_border(y, x, ball_y, ball_x, MAX_Y, radius)
    if abs(x) > MAX_X or abs(y) > MAX_Y:
        x, y = 2.0 * ball_x - x, 2.0 * ball_y - y
    return x, y


def clear_players_from_ball(world: World, side: int) -> None:
    """Move the players of a side (NO_SIDE: both) out of the circle round the ball, and stop them.

    Repeated with collisions resolved in between until nobody is inside, at most ten times. Near the border the
    player goes along it instead of across.
    """
    match, params = world.match, world.params
    ball_x, ball_y = match["ball_pos"][0, 0], match["ball_pos"][0, 1]
    mode = match["mode"][0]
    clear = _clear_distance(mode, ball_x, ball_y, params["ball_size"][0])
    indirect = _is_indirect(mode)
    at_corner = abs(ball_x) > MAX_X - clear and abs(ball_y) > MAX_Y - clear
    pos = match["pos"][0]
    for _ in range(_CLEAR_ROUNDS):
        found = False
        for k in range(match["n_players"][0]):
            i = match["players"][0, k]
            if side != NO_SIDE and side_of(i) != side:
                continue
            if indirect and abs(pos[i, 0]) >= HALF_LENGTH:
                continue
            radius = clear + match["size"][0, i]
            if np.hypot(pos[i, 0] - ball_x, pos[i, 1] - ball_y) <= radius:
                x, y = _cleared(pos[i, 0], pos[i, 1], ball_x, ball_y, radius, at_corner, indirect)
                place_player(match, i, x, y)
                found = True
        if not found:
            break
        resolve_collisions(world)
