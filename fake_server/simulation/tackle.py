"""Tackle: chance of success and acceleration of the ball.

Source: 19.0.0, src/player.cpp (tackle); the model of 11.1 is that of 11.1.2, src/player.C.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fake_server.simulation.dash import clamp
from fake_server.simulation.kick import ball_kickable, ball_speed_rate
from fake_server.simulation.noise import polar_noise, square_noise
from fake_server.simulation.state import side_of
from rcss_hat.numeric.angles import DEG
from rcss_hat.numeric.jit import kernel

CANNOT_FAIL_LESS = 2.0
"""Failure of a tackle whose area is empty on the ball's side (tackle distance 0)."""


@kernel
def ball_in_body_frame(match: NDArray[np.void], i: int) -> tuple[float, float]:
    """Position (m) of the ball seen from a player's body: x forward, y to the right."""
    dx = match["ball_pos"][0, 0] - match["pos"][0, i, 0]
    dy = match["ball_pos"][0, 1] - match["pos"][0, i, 1]
    c, s = math.cos(-match["body"][0, i]), math.sin(-match["body"][0, i])
    return dx * c - dy * s, dx * s + dy * c


@kernel
def tackle_failure(params: NDArray[np.void], x: float, y: float, exponent: float) -> float:
    """Failure (|x|/tackle_dist)^e + (|y|/tackle_width)^e of a tackle; from 1 on it never succeeds."""
    reach = params["tackle_dist"][0] if x > 0.0 else params["tackle_back_dist"][0]
    if abs(reach) <= 1e-5:
        return CANNOT_FAIL_LESS
    return float((abs(x) / reach) ** exponent + (abs(y) / params["tackle_width"][0]) ** exponent)


@kernel
def opponent_at_ball(match: NDArray[np.void], params: NDArray[np.void], types: NDArray[np.void], i: int) -> bool:
    """Tell whether an opponent of a player can kick the ball (a foul is possible)."""
    for k in range(match["n_players"][0]):
        j = match["players"][0, k]
        if side_of(j) != side_of(i) and ball_kickable(match, params, types, j):
            return True
    return False


@kernel
def tackle_acceleration(
    match: NDArray[np.void],
    params: NDArray[np.void],
    types: NDArray[np.void],
    i: int,
    argument: float,
    failure: float,
    x: float,
    y: float,
    rng: NDArray[np.uint64],
) -> tuple[float, float]:
    """Acceleration (m/cycle^2) of the ball by a successful tackle.

    Clients of version 12 and later give a direction, older ones a power along the body. The power is reduced by half
    the ball's angle over pi. Noise: ``polar(U(0, m), U(-pi, pi))``,
    ``m = kick_rand tackle_rand_factor rate (0.5 + 0.5 (1 - failure) + ball_speed_rate)``.

    Parameters
    ----------
    match, params, types : records
    i : int
        Index of the player.
    argument : float
        Power, or direction in degrees for clients of version 12 and later.
    failure : float
        As :func:`tackle_failure` gave it.
    x, y : float
        Ball in the body frame (m).
    rng : ndarray of uint64, shape (4,)
    """
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
    aside = 0.0 if x == 0.0 and y == 0.0 else math.atan2(y, x)
    size = power * params["tackle_power_rate"][0] * (1.0 - 0.5 * (abs(aside) / math.pi))
    spread = 0.5 + 0.5 * (1.0 - failure) + ball_speed_rate(match, params)
    noise_x, noise_y = polar_noise(rng, kick_rand * params["tackle_rand_factor"][0] * rate * spread)
    return size * math.cos(angle + body) + noise_x, size * math.sin(angle + body) + noise_y
