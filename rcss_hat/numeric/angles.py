"""Angles: degrees in (-180, 180] outside, radians inside the server; clockwise is positive as on its screen."""

from __future__ import annotations

import math

import numpy as np

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
