"""The pitch: its areas, and points brought into or out of them.

Source: 19.0.0, src/referee.cpp, src/object.cpp and src/stadium.cpp.
"""

from __future__ import annotations

import math

from rcss_hat.numeric.jit import kernel
from rcss_hat.protocol.landmarks import PITCH_LENGTH, PITCH_MARGIN, PITCH_WIDTH
from rcss_hat.protocol.records import LEFT, RIGHT

HALF_LENGTH = 0.5 * PITCH_LENGTH
HALF_WIDTH = 0.5 * PITCH_WIDTH
MAX_X = HALF_LENGTH + PITCH_MARGIN
MAX_Y = HALF_WIDTH + PITCH_MARGIN
PENALTY_AREA_LENGTH, PENALTY_AREA_WIDTH = 16.5, 40.32
GOAL_AREA_LENGTH, GOAL_AREA_WIDTH = 5.5, 18.32
GOAL_DEPTH = 2.44
CLEAR_DISTANCE = 9.15
"""Radius of the centre circle, and what opponents keep from the ball at a restart (m)."""
_EPS = 1e-10


@kernel
def truncate_to_pitch(x: float, y: float) -> tuple[float, float]:
    """Bring a point onto the pitch."""
    return min(max(x, -HALF_LENGTH), HALF_LENGTH), min(max(y, -HALF_WIDTH), HALF_WIDTH)


@kernel
def _out_of_penalty_area(x: float, y: float) -> tuple[float, float]:
    if abs(x) >= HALF_LENGTH - PENALTY_AREA_LENGTH and abs(y) <= 0.5 * PENALTY_AREA_WIDTH:
        x = math.copysign(HALF_LENGTH - PENALTY_AREA_LENGTH - _EPS, x)
        y = 0.5 * PENALTY_AREA_WIDTH + _EPS if y > 0.0 else -0.5 * PENALTY_AREA_WIDTH - _EPS
    return x, y


@kernel
def move_out_of_penalty_area(side: int, x: float, y: float) -> tuple[float, float]:
    """Move a point in the penalty area of a side (NO_SIDE: either) to the area's corner."""
    if (side != RIGHT and x < 0.0) or (side != LEFT and x > 0.0):
        return _out_of_penalty_area(x, y)
    return x, y


@kernel
def in_penalty_area(side: int, x: float, y: float, ball_size: float) -> bool:
    """Tell whether a ball is at least partly in the penalty area of a side (NO_SIDE: either)."""
    if abs(y) > 0.5 * PENALTY_AREA_WIDTH + ball_size:
        return False
    if not HALF_LENGTH - PENALTY_AREA_LENGTH - ball_size <= abs(x) <= HALF_LENGTH + ball_size:
        return False
    return (side != RIGHT and x < 0.0) or (side != LEFT and x > 0.0)


@kernel
def nearest_in_world(x: float, y: float) -> tuple[float, float]:
    """Bring a point into the pitch and its margin, at the edge that is nearest."""
    if abs(x) <= MAX_X and abs(y) <= MAX_Y:
        return x, y
    if abs(abs(x) - MAX_X) < abs(abs(y) - MAX_Y):
        return (-MAX_X if x < 0.0 else MAX_X), min(max(y, -MAX_Y), MAX_Y)
    return min(max(x, -MAX_X), MAX_X), (-MAX_Y if y < 0.0 else MAX_Y)


@kernel
def out_of_circle(x: float, y: float, center_x: float, center_y: float, radius: float) -> tuple[float, float]:
    """Move a point to the edge of a circle."""
    dx, dy = x - center_x, y - center_y
    if dx == 0.0 and dy == 0.0:
        dx, dy = _EPS, _EPS
    scale = radius / max(math.sqrt(dx * dx + dy * dy), _EPS)
    return center_x + dx * scale, center_y + dy * scale
