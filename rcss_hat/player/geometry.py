"""Small geometry of the players: whole degrees, intervals of angles, cones."""

from __future__ import annotations

import math

import numpy as np

from rcss_hat.numeric.angles import DEG, RAD
from rcss_hat.numeric.jit import inlined, kernel

_WHOLE = np.arange(-360, 361) * DEG
_COS, _SIN = np.cos(_WHOLE), np.sin(_WHOLE)


@inlined
def whole_cos(degrees: float) -> float:
    """Cosine of whole degrees in [-360, 360]."""
    return _COS[int(degrees) + 360]


@inlined
def whole_sin(degrees: float) -> float:
    """Sine of whole degrees in [-360, 360]."""
    return _SIN[int(degrees) + 360]


@inlined
def sign(value: float) -> float:
    """Return +1 for positive values, otherwise -1: also for 0, as the UT Austin players do."""
    return 1.0 if value > 0.0 else -1.0


@kernel
def direction_to(dx: float, dy: float) -> float:
    """Direction of a vector in degrees; 0 for vectors shorter than 0.1 mm in both components."""
    if abs(dx) < 1e-4 and abs(dy) < 1e-4:
        return 0.0
    return math.atan2(dy, dx) * RAD


@kernel
def in_interval(angle: float, low: float, high: float) -> bool:
    """Tell whether a direction lies between two others, going clockwise from low to high."""
    angle %= 360.0
    low %= 360.0
    high %= 360.0
    if low < high:
        return low < angle < high
    return not high < angle < low


@inlined
def in_cone(x: float, y: float, from_x: float, from_y: float, to_x: float, to_y: float, width: float) -> bool:
    """Tell whether a point lies in a cone that opens from one point towards another.

    The cone is ``width`` metres wide to each side per metre of its axis and ends at the far point; the point must also
    be nearer to the apex than the far point is (getNrInSetInCone of the UT Austin players).
    """
    axis_x, axis_y = to_x - from_x, to_y - from_y
    dx, dy = x - from_x, y - from_y
    length2 = axis_x * axis_x + axis_y * axis_y
    if dx * dx + dy * dy >= length2:
        return False
    along = dx * axis_x + dy * axis_y
    if along < 0.0:
        return False
    across = abs(dx * axis_y - dy * axis_x)
    return across < width * along
