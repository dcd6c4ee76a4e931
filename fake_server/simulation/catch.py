"""Goalie's catch.

Source: 19.0.0, src/player.cpp (goalieCatch) and src/referee.cpp (CatchRef, ballCaught); not used in Keepaway. Back
passes are not detected.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fake_server.simulation.collision import resolve_collisions
from fake_server.simulation.pitch import in_penalty_area, move_out_of_penalty_area, truncate_to_pitch
from fake_server.simulation.placement import place_ball
from fake_server.simulation.referee import change_play_mode, free_kick, other_side
from fake_server.simulation.state import CATCH_FAULT_LEFT, CATCH_FAULT_RIGHT, E_CAUGHT, side_of
from rcss_hat.numeric.jit import kernel
from rcss_hat.numeric.rng import bernoulli
from rcss_hat.protocol.records import LEFT


@kernel
def catch_probability(
    match: NDArray[np.void], params: NDArray[np.void], types: NDArray[np.void], i: int, angle: float
) -> float:
    """Probability that a catch in a direction (radians, world) succeeds; -1 outside the goalie's area.

    The area is a rectangle before him, ``catchable_area_l * stretch`` long and ``catchable_area_w`` wide; in its
    stretched part the probability falls to 0.
    """
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


@kernel
def _award(match: NDArray[np.void], params: NDArray[np.void], i: int, rng: NDArray[np.uint64]) -> None:
    """Give the free kick for a catch, or for a catch outside the penalty area to the other side."""
    side = side_of(i)
    x, y = match["ball_pos"][0, 0], match["ball_pos"][0, 1]
    match["events"][0] |= E_CAUGHT
    if in_penalty_area(side, x, y, params["ball_size"][0]):
        x, y = truncate_to_pitch(x, y)
        x, y = move_out_of_penalty_area(other_side(side), x, y)
        free_kick(match, params, side, x, y, rng)
        match["catcher"][0] = i
        return
    x, y = truncate_to_pitch(x, y)
    x, y = move_out_of_penalty_area(side, x, y)
    match["catcher"][0] = -1
    place_ball(match, x, y, 0.0, 0.0)
    match["kick_off_side"][0] = other_side(side)
    change_play_mode(match, params, CATCH_FAULT_LEFT if side == LEFT else CATCH_FAULT_RIGHT, rng)


@kernel
def try_catch(
    match: NDArray[np.void],
    params: NDArray[np.void],
    types: NDArray[np.void],
    i: int,
    angle: float,
    rng: NDArray[np.uint64],
) -> tuple[bool, bool]:
    """Try to catch the ball in a direction (radians, world).

    Returns
    -------
    reached : bool
        The ball was in the area.
    caught : bool
        It was caught; when only reached, it bounces off.
    """
    probability = catch_probability(match, params, types, i, angle)
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
    resolve_collisions(match, params, rng)
    _award(match, params, i, rng)
    return True, True
