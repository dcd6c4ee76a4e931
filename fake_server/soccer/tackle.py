"""Tackle: chance of success and acceleration of the ball.

Source: 19.0.0, src/player.cpp (tackle); the model of 11.1 is that of 11.1.2, src/player.C.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import DEG
from rcss_hat.numeric.rng import bernoulli
from rcss_hat.simulation.commands import occupy_legs
from rcss_hat.simulation.dash import clamp
from rcss_hat.simulation.kick import ball_kickable, ball_speed_rate
from rcss_hat.simulation.noise import polar_noise, square_noise
from rcss_hat.simulation.referee import kick_forbidden
from rcss_hat.simulation.state import (
    C_TACKLE,
    CATCH_FAULT_LEFT,
    CATCH_FAULT_RIGHT,
    F_TACKLE,
    F_TACKLE_FAULT,
    PHYSICS,
    side_of,
)
from rcss_hat.simulation.world import World

CANNOT_FAIL_LESS = 2.0
"""Failure of a tackle whose area is empty on the ball's side (tackle distance 0)."""


def ball_in_body_frame(match: NDArray[np.void], i: int) -> tuple[float, float]:
    """Position (m) of the ball seen from a player's body: x forward, y to the right."""
    dx = match["ball_pos"][0, 0] - match["pos"][0, i, 0]
    dy = match["ball_pos"][0, 1] - match["pos"][0, i, 1]
    c, s = math.cos(-match["body"][0, i]), math.sin(-match["body"][0, i])
    return dx * c - dy * s, dx * s + dy * c


def tackle_failure(params: NDArray[np.void], x: float, y: float, exponent: float) -> float:
    """Failure (|x|/tackle_dist)^e + (|y|/tackle_width)^e of a tackle; from 1 on it never succeeds."""
    reach = params["tackle_dist"][0] if x > 0.0 else params["tackle_back_dist"][0]
    if abs(reach) <= 1e-5:
        return CANNOT_FAIL_LESS
    return float((abs(x) / reach) ** exponent + (abs(y) / params["tackle_width"][0]) ** exponent)


def opponent_at_ball(world: World, i: int) -> bool:
    """Tell whether an opponent of a player can kick the ball (a foul is possible)."""
    match = world.match
    for k in range(match["n_players"][0]):
        j = match["players"][0, k]
        if side_of(j) != side_of(i) and ball_kickable(world, j):
            return True
    return False


def tackle_acceleration(world: World, i: int, argument: float, failure: float) -> tuple[float, float]:
    """Acceleration (m/cycle^2) of the ball by a successful tackle.

    Clients of version 12 and later give a direction, older ones a power along the body. The power is reduced by half
    the ball's angle over pi. Noise: ``polar(U(0, m), U(-pi, pi))``,
    ``m = kick_rand tackle_rand_factor rate (0.5 + 0.5 (1 - failure) + ball_speed_rate)``.

    Parameters
    ----------
    world : World
    i : int
        Index of the player.
    argument : float
        Power, or direction in degrees for clients of version 12 and later.
    failure : float
        As :func:`tackle_failure` gave it.
    """
    match, params, types, rng = world.match, world.params, world.types, world.streams[PHYSICS]
    body = match["body"][0, i]
    kick_rand = types["kick_rand"][match["type"][0, i]]
    back, forward = params["max_back_tackle_power"][0], params["max_tackle_power"][0]
    if params["version_11"][0]:
        power = clamp(argument, -back, forward)
        size = power * params["tackle_power_rate"][0]
        noise_x, noise_y = square_noise(rng, kick_rand * power * (1.0 - failure) / params["maxpower"][0])
        return size * math.cos(body) + noise_x, size * math.sin(body) + noise_y
    rate = 1.0
    angle = 0.0
    if match["version"][0, i] >= 12:
        angle = clamp(argument, params["minmoment"][0], params["maxmoment"][0]) * DEG
        power = back + (forward - back) * (1.0 - abs(angle) / math.pi)
    else:
        power = clamp(argument, -back, forward)
        if power >= 0.0:
            rate = power / forward
        elif abs(back) > 1e-10:
            rate = -power / back
    x, y = ball_in_body_frame(match, i)
    aside = 0.0 if x == 0.0 and y == 0.0 else math.atan2(y, x)
    size = power * params["tackle_power_rate"][0] * (1.0 - 0.5 * (abs(aside) / math.pi))
    spread = 0.5 + 0.5 * (1.0 - failure) + ball_speed_rate(match, params)
    noise_x, noise_y = polar_noise(rng, kick_rand * params["tackle_rand_factor"][0] * rate * spread)
    return size * math.cos(angle + body) + noise_x, size * math.sin(angle + body) + noise_y


def tackle(world: World, i: int, power_or_angle: float, foul: bool) -> bool:
    """Tackle; the player is immobile for ``tackle_cycles``, whatever happens.

    Clients of version 12 and later give a direction (degrees), older ones a power. With ``foul`` (19) and an opponent
    at the ball the area has another shape and a success leaves the player mobile; no foul is ever called.
    """
    match, params, rng = world.match, world.params, world.streams[PHYSICS]
    if match["command_done"][0, i]:
        return False
    occupy_legs(match, i)
    match["command_done"][0, i] = 1
    match["tackle_cycles"][0, i] = int(params["tackle_cycles"][0])
    match["counts"][0, i, C_TACKLE] += 1
    x, y = ball_in_body_frame(match, i)
    foul = foul and opponent_at_ball(world, i)
    exponent = params["foul_exponent"][0] if foul else params["tackle_exponent"][0]
    failure = tackle_failure(params, x, y, exponent)
    if failure >= 1.0:
        match["flags_next"][0, i] |= F_TACKLE_FAULT
        return True
    if not bernoulli(rng, 1.0 - failure):
        match["flags_next"][0, i] |= F_TACKLE | F_TACKLE_FAULT
        return True
    match["flags_next"][0, i] |= F_TACKLE
    mode = match["mode"][0]
    if kick_forbidden(mode) and mode != CATCH_FAULT_LEFT and mode != CATCH_FAULT_RIGHT:
        return True
    if foul:
        match["tackle_cycles"][0, i] = 0
    ax, ay = tackle_acceleration(world, i, power_or_angle, failure)
    match["ball_acc"][0, 0] += ax
    match["ball_acc"][0, 1] += ay
    match["catcher"][0] = -1
    return True
