"""Kick: acceleration of the ball, and its noise.

Source: 19.0.0, src/player.cpp (kick); the noise of 11.1 is that of 11.1.2, src/player.C.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import normalize_radians
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.simulation.noise import polar_noise, square_noise
from rcss_hat.simulation.state import PHYSICS
from rcss_hat.simulation.world import World


@inlined
def ball_kickable(world: World, i: int) -> bool:
    """Tell whether a player reaches the ball: distance <= player_size + ball_size + kickable_margin."""
    match, params, types = world.match, world.params, world.types
    dx = match["ball_pos"][0, 0] - match["pos"][0, i, 0]
    dy = match["ball_pos"][0, 1] - match["pos"][0, i, 1]
    k = match["type"][0, i]
    reach = types["player_size"][k] + params["ball_size"][0] + types["kickable_margin"][k]
    return bool(dx * dx + dy * dy <= reach * reach)


@inlined
def ball_speed_rate(match: NDArray[np.void], params: NDArray[np.void]) -> float:
    """Part of the kick noise that grows with the ball's speed: 0.5 + 0.5 |v| / (ball_speed_max ball_decay)."""
    vx, vy = match["ball_vel"][0, 0], match["ball_vel"][0, 1]
    return float(0.5 + 0.5 * (math.sqrt(vx * vx + vy * vy) / (params["ball_speed_max"][0] * params["ball_decay"][0])))


@kernel
def kick_acceleration(world: World, i: int, power: float, angle: float) -> tuple[float, float]:
    """Acceleration (m/cycle^2) that a kick gives to the ball.

    ``eff = power kick_power_rate (1 - 0.25 dir_diff/pi - 0.25 dist/kickable_margin)`` in direction body + angle, plus
    ``polar(U(0, m), U(-pi, pi))`` with
    ``m = kick_rand power/maxpower (0.5 + 0.25 (dir_diff/pi + dist/kickable_margin) + ball_speed_rate)``.

    Parameters
    ----------
    world : World
    i : int
        Index of the player.
    power : float
        Already clamped.
    angle : float
        Radians relative to the body, already clamped.
    """
    match, params, types, rng = world.match, world.params, world.types, world.streams[PHYSICS]
    k = match["type"][0, i]
    dx = match["ball_pos"][0, 0] - match["pos"][0, i, 0]
    dy = match["ball_pos"][0, 1] - match["pos"][0, i, 1]
    body = match["body"][0, i]
    where = 0.0 if dx == 0.0 and dy == 0.0 else math.atan2(dy, dx)
    dir_part = abs(normalize_radians(where - body)) / math.pi
    dist = math.sqrt(dx * dx + dy * dy) - types["player_size"][k] - params["ball_size"][0]
    dist_part = dist / types["kickable_margin"][k]
    eff = power * types["kick_power_rate"][k] * (1.0 - 0.25 * dir_part - 0.25 * dist_part)
    rand = types["kick_rand"][k] * (power / params["maxpower"][0])
    if params["version_11"][0]:
        noise_x, noise_y = square_noise(rng, rand)
    else:
        rand *= 0.5 + 0.25 * (dir_part + dist_part) + ball_speed_rate(match, params)
        noise_x, noise_y = polar_noise(rng, rand)
    return eff * math.cos(angle + body) + noise_x, eff * math.sin(angle + body) + noise_y
