"""Distances and changes as the server reports them, and what is lost with the distance.

Source: 19.0.0, src/visualsenderplayer.cpp (QuantizeObservation, GaussianObservation). With ``d`` the distance, ``v``
the relative velocity and ``e`` the direction as a unit vector::

    Dist    = Quantize(exp(Quantize(log(d + EPS), step)), 0.1)      step: quantize_step, of landmarks quantize_step_l
    DistChg = Dist * Quantize(v.e / d, 0.02)
    DirChg  = Quantize(degrees((v.y e.x - v.x e.y) / d), 0.1)

Numbers are given as a client reads them from the text: a multiple of 0.1 is the double n / 10, not n * 0.1. Signs of
zeros are those of the server.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import RAD, normalize_radians, quick_atan2
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.numeric.wire import six_digits

FAR, TOO_FAR = 20.0, 40.0
"""Distances (m) from which on velocity and number may be, and are, lost; constants of the server."""
TEAM_FAR, TEAM_TOO_FAR = 40.0, 60.0
_EPS = 1e-10
_TO_UNIT = 2.0**-53
_SIX_DIGITS = 1e6


@inlined
def relative_direction(dx: float, dy: float, body: float, neck: float) -> float:
    """Direction (radians) of a vector relative to the face."""
    return float(normalize_radians(normalize_radians(quick_atan2(dy, dx) - body) - neck))


@inlined
def whole_degrees(angle: float) -> float:
    """Whole degrees of an angle in radians, halves to even; never -0."""
    return float(np.rint(angle * RAD) + 0.0)


def _tenths_table(step: float) -> NDArray[np.float64]:
    """Reported distances in tenths for all steps k of the logarithm from -3 (below it all are 0) to log(250 m)."""
    return np.array([np.rint(math.exp(k * step) / 0.1) for k in range(round(-3.0 / step), round(5.52 / step))])


_COARSE, _FINE = 0.1, 0.01
"""The default steps, for which the reported distances are tabulated: the exponential costs as much as all the rest."""
_COARSE_TENTHS, _FINE_TENTHS = _tenths_table(_COARSE), _tenths_table(_FINE)


@inlined
def quantized_tenths(dist: float, step: float) -> float:
    """Reported distance in tenths of a metre, a whole number."""
    if step < _EPS:
        return float(np.rint(dist / 0.1))
    k = np.rint(math.log(dist + _EPS) / step)
    if step == _FINE and -300.0 <= k < 552.0:
        return float(_FINE_TENTHS[int(k) + 300])
    if step == _COARSE and -30.0 <= k < 55.0:
        return float(_COARSE_TENTHS[int(k) + 30])
    return float(np.rint(math.exp(k * step) / 0.1))


@kernel
def focused_tenths(dist: float, focus_dist: float, step: float) -> float:
    """Reported distance in tenths when the focus point is not the player (version 18): the mean of both errors."""
    if step < _EPS:
        return float(np.rint(dist / 0.1))
    near = math.exp(np.rint(math.log(dist + _EPS) / step) * step)
    focus_near = math.exp(np.rint(math.log(focus_dist + _EPS) / step) * step)
    return float(np.rint(max(0.0, dist - ((focus_dist - focus_near) + (dist - near)) / 2.0) / 0.1))


@inlined
def distance_change(tenths: float, dx: float, dy: float, dist: float, dvx: float, dvy: float) -> float:
    """Change of distance (m/cycle) with the reported distance in tenths."""
    if dist == 0.0:
        return 0.0
    radial = dvx * (dx / dist) + dvy * (dy / dist)
    change = tenths * (2.0 * np.rint(radial / dist / 0.02))
    if abs(change) < _SIX_DIGITS:
        return float(change / 1000.0)
    return float(six_digits(change * 0.001))


@kernel
def gaussian_distance_change(noisy: float, dx: float, dy: float, dist: float, dvx: float, dvy: float) -> float:
    """Change of distance (m/cycle) with a distance that has Gaussian noise (19)."""
    if dist == 0.0:
        return 0.0
    radial = dvx * (dx / dist) + dvy * (dy / dist)
    return float(np.rint(radial * (noisy / dist) / 0.01) / 100.0)


@inlined
def direction_change(dx: float, dy: float, dist: float, dvx: float, dvy: float) -> float:
    """Change of direction (degrees/cycle)."""
    if dist == 0.0:
        return 0.0
    change = (dvy * (dx / dist) - dvx * (dy / dist)) / dist * RAD
    if change == 0.0:
        return 0.0
    tenths = np.rint(change / 0.1)
    if abs(tenths) < _SIX_DIGITS:
        return float(tenths / 10.0)
    return float(six_digits(tenths * 0.1))


@inlined
def lost_with(dist: float, far: float, too_far: float) -> float:
    """Probability that a detail is lost at a reported distance (m); may lie outside [0, 1]."""
    return (dist - far) / (too_far - far)


@inlined
def landmark_uniform(key: np.uint64, k: int) -> float:
    """Number from U[0, 1) that hangs on a random key and a counter alone (the mixing function of splitmix64).

    With one key per see message, what is lost of a landmark is the same whatever other landmarks are looked at.
    """
    z = key + np.uint64(k + 1) * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return float(np.float64(z >> np.uint64(11)) * _TO_UNIT)


@inlined
def put_object(
    out: NDArray[np.void],
    n: int,
    code: int,
    fields: int,
    distance: float,
    direction: float,
    radial: float,
    tangential: float,
) -> None:
    """Write object n of a message; what only players have is set to 0."""
    out["code"][0, n] = code
    out["fields"][0, n] = fields
    out["team"][0, n] = 0
    out["unum"][0, n] = 0
    out["goalie"][0, n] = 0
    out["distance"][0, n] = distance
    out["direction"][0, n] = direction
    out["distance_change"][0, n] = radial
    out["direction_change"][0, n] = tangential
    out["body"][0, n] = 0.0
    out["head"][0, n] = 0.0
    out["pointing"][0, n] = 0.0
