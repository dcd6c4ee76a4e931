"""Angles: degrees in (-180, 180] outside, radians inside the server; clockwise is positive as on its screen."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import inlined

DEG = math.pi / 180.0
"""Radians of one degree (the server multiplies by this constant)."""
RAD = 180.0 / math.pi
"""Degrees of one radian."""
EPS = 1e-10


@inlined
def normalize_radians(angle: float) -> float:
    """Bring radians into [-pi, pi]; both ends stay as they are (19.0.0, rcss/geom)."""
    if abs(angle) > 2.0 * math.pi:
        angle = np.fmod(angle, 2.0 * math.pi)
    if angle < -math.pi:
        angle += 2.0 * math.pi
    if angle > math.pi:
        angle -= 2.0 * math.pi
    return angle


@inlined
def normalize_degrees(angle: float) -> float:
    """Bring degrees into (-180, 180]."""
    while angle > 180.0:
        angle -= 360.0
    while angle <= -180.0:
        angle += 360.0
    return angle


@inlined
def direction(x: float, y: float) -> float:
    """Direction of a vector in degrees; 0 for the zero vector."""
    if x == 0.0 and y == 0.0:
        return 0.0
    return math.atan2(y, x) * RAD


_CELLS = 256
"""Cells of the table of arctangents in [0, 1]."""


def _arctangents() -> NDArray[np.float64]:
    """Taylor coefficients of the arctangent at the cells' ends, shape (_CELLS + 1, 4)."""
    t = np.arange(_CELLS + 1) / _CELLS
    slope = 1.0 / (1.0 + t * t)
    # Not NumPy's arctangent and power, whose last digits depend on the processor.
    arctangents, cubes = np.array([(math.atan(a), s**3) for a, s in zip(t.tolist(), slope.tolist(), strict=True)]).T
    return np.stack([arctangents, slope, -t * slope**2, (t * t - 1.0 / 3.0) * cubes], axis=1)


_ARCTANGENTS = _arctangents()


@inlined
def quick_atan2(y: float, x: float) -> float:
    """``math.atan2`` in half its time; off by less than 5e-12 radians, exact on axes and diagonals, 0 for (0, 0).

    The sign of a zero y is not looked at: the direction (-1, -0) is pi.
    """
    ax, ay = abs(x), abs(y)
    longer = max(ax, ay)
    if longer == 0.0:
        return 0.0
    t = min(ax, ay) / longer
    k = int(t * _CELLS + 0.5)
    h = t - k / _CELLS
    c = _ARCTANGENTS
    angle = c[k, 0] + h * (c[k, 1] + h * (c[k, 2] + h * c[k, 3]))
    if ay > ax:
        angle = 0.5 * math.pi - angle
    if x < 0.0:
        angle = math.pi - angle
    return -angle if y < 0.0 else angle


SURE = 1e-6
"""Farther than this (degrees) from whole degrees, `quick_atan2` shows which ones they are."""


@inlined
def cut_degrees(x: float, y: float, body: float, neck: float) -> int:
    """Whole degrees, cut towards 0, of the direction of a vector relative to a body and its neck (radians)."""
    angle = normalize_radians(quick_atan2(y, x) - body - neck) * RAD
    if abs(angle - np.rint(angle)) < SURE:
        angle = normalize_radians((math.atan2(y, x) if x != 0.0 or y != 0.0 else 0.0) - body - neck) * RAD
    return int(angle)
