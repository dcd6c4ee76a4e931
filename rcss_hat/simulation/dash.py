"""Dash: stamina into acceleration.

Source: 19.0.0, src/player.cpp (applyDashEffect) and src/leg.cpp. Each leg asks for half of the power; when stamina does
not cover both, the right leg gets too much of what is there, and the player turns while he dashes. In 11.1 there are no
legs and no directions, and a dash acts at once.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import DEG, normalize_radians
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.numeric.rng import uniform
from rcss_hat.protocol.records import LEFT
from rcss_hat.simulation.state import C_DASH, LEG_DASH, PHYSICS, side_of
from rcss_hat.simulation.world import World


@inlined
def clamp(value: float, low: float, high: float) -> float:
    """Bring a value into [low, high]."""
    return min(max(value, low), high)


@inlined
def direction_rate(params: NDArray[np.void], direction: float) -> float:
    """Share of the power that a dash in a direction (degrees from the body) is worth, in [0, 1].

    1 forward, ``side_dash_rate`` at 90 degrees, ``back_dash_rate`` backwards, linear in between.
    """
    away = abs(direction)
    side = params["side_dash_rate"][0]
    if away > 90.0:
        back = params["back_dash_rate"][0]
        rate = back - (back - side) * (1.0 - (away - 90.0) / 90.0)
    else:
        rate = side + (1.0 - side) * (1.0 - away / 90.0)
    return clamp(rate, 0.0, 1.0)


@inlined
def slowness(match: NDArray[np.void], params: NDArray[np.void], i: int) -> float:
    """Factor of the server's slow upper half of the pitch; 1 by default."""
    if match["pos"][0, i, 1] >= 0.0:
        return 1.0
    if side_of(i) == LEFT:
        return float(params["slowness_on_top_for_left_team"][0])
    return float(params["slowness_on_top_for_right_team"][0])


@inlined
def _leg_acceleration(
    match: NDArray[np.void], params: NDArray[np.void], rate: float, i: int, leg: int, consumed: float
) -> tuple[float, float]:
    """Acceleration (m/cycle^2) by one leg that consumes some stamina; rate is dash_power_rate times effort."""
    asked = -consumed if match["leg_power"][0, i, leg] < 0.0 else 2.0 * consumed
    power = clamp(asked, params["min_dash_power"][0], params["max_dash_power"][0])
    direction = match["leg_dir"][0, i, leg]
    size = abs(rate * power * direction_rate(params, direction)) / slowness(match, params, i)
    if power < 0.0:
        size = -size
    angle = match["body"][0, i] + direction * DEG
    return size * math.cos(angle), size * math.sin(angle)


@inlined
def _consumption(power: float) -> float:
    """Stamina that one leg's dash needs: half the power, four times as much backwards."""
    return -power if power < 0.0 else 0.5 * power


@inlined
def apply_dash(world: World, i: int) -> None:
    """Apply the dash that a player's legs have stored in this cycle, at the start of the next step.

    With l and r the legs' consumptions and s = stamina + extra_stamina:

    ``consumed = min(l + r, s)``; ``l' = consumed l/(l + r)``; ``r' = consumed r/(l' + r)``; the acceleration is the
    mean of both legs'; the body turns by the difference of the legs' velocities along it, over twice the size.
    """
    match, params, types = world.match, world.params, world.types
    if match["leg"][0, i, 0] != LEG_DASH and match["leg"][0, i, 1] != LEG_DASH:
        return
    match["counts"][0, i, C_DASH] += 1
    left = _consumption(match["leg_power"][0, i, 0])
    right = _consumption(match["leg_power"][0, i, 1])
    if left + right < 1e-5:
        return
    k = match["type"][0, i]
    consumed = min(left + right, match["stamina"][0, i] + types["extra_stamina"][k])
    left = consumed * left / (left + right)
    right = consumed * right / (left + right)
    rate = match["effort"][0, i] * types["dash_power_rate"][k]
    left_x, left_y = _leg_acceleration(match, params, rate, i, 0, left)
    if left == right and match["leg_dir"][0, i, 0] == match["leg_dir"][0, i, 1]:
        right_x, right_y = left_x, left_y
    else:
        right_x, right_y = _leg_acceleration(match, params, rate, i, 1, right)
        if match["leg"][0, i, 0] == LEG_DASH:
            _turn_by_legs(world, i, left_x - right_x, left_y - right_y)
    match["acc"][0, i, 0] += 0.5 * (left_x + right_x)
    match["acc"][0, i, 1] += 0.5 * (left_y + right_y)
    match["stamina"][0, i] = max(0.0, match["stamina"][0, i] - consumed)


@kernel
def _turn_by_legs(world: World, i: int, x: float, y: float) -> None:
    """Turn the body because the left leg is faster by a vector (x, y) than the right."""
    match, params, rng = world.match, world.params, world.streams[PHYSICS]
    body = match["body"][0, i]
    omega = (x * math.cos(body) + y * math.sin(body)) / (2.0 * match["size"][0, i])
    rand = params["player_rand"][0]
    match["body_pending"][0, i] = normalize_radians(body + (1.0 + uniform(rng, -rand, rand)) * omega)


@kernel
def dash_at_once(world: World, i: int, power: float) -> None:
    """Apply a dash as 11.1 does: along the body, when the command is read."""
    match, params, types = world.match, world.params, world.types
    k = match["type"][0, i]
    power = clamp(power, params["min_dash_power"][0], params["max_dash_power"][0])
    need = power if power >= 0.0 else -2.0 * power
    consumed = min(need, match["stamina"][0, i] + types["extra_stamina"][k])
    match["stamina"][0, i] = max(0.0, match["stamina"][0, i] - consumed)
    effective = consumed if power >= 0.0 else -0.5 * consumed
    size = match["effort"][0, i] * effective * types["dash_power_rate"][k] / slowness(match, params, i)
    match["acc"][0, i, 0] += size * math.cos(match["body"][0, i])
    match["acc"][0, i, 1] += size * math.sin(match["body"][0, i])
    match["counts"][0, i, C_DASH] += 1
