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


@kernel
def tenths_by_logarithm(dist: float, step: float) -> float:
    """Reported distance in tenths of a metre, by the server's formula."""
    return float(np.rint(math.exp(np.rint(math.log(dist + _EPS) / step) * step) / 0.1))


_COARSE, _FINE = 0.1, 0.01
"""The default steps, for which the reported distances are tabulated: logarithm and exponential cost as much as all the
rest of seeing an object."""
_CELLS, _TABULATED = 32, 128
"""Cells per metre, less than a step of the reported distance long each, and metres that are tabulated."""


def _least_with_step(k: int, step: float) -> float:
    """Least distance whose logarithm is rounded to k steps or more: near the middle between two, to the last bit."""
    dist = math.exp((k - 0.5) * step) - _EPS
    while np.rint(math.log(dist + _EPS) / step) >= k:
        dist = math.nextafter(dist, 0.0)
    while np.rint(math.log(dist + _EPS) / step) < k:
        dist = math.nextafter(dist, math.inf)
    return dist


def _tenths_table(step: float) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.uint16]]:
    """Reported distances in rising order, the least distance (m) of each, and what is reported where a cell begins."""
    tenths, least = [0.0], [0.0]
    for k in range(math.floor(math.log(0.04) / step), math.ceil(math.log(_TABULATED) / step) + 2):
        reported = float(np.rint(math.exp(k * step) / 0.1))
        if reported > tenths[-1]:
            tenths.append(reported)
            least.append(_least_with_step(k, step))
    begins = np.searchsorted(least, np.arange(_TABULATED * _CELLS) / _CELLS, side="right") - 1
    return np.array(tenths), np.array(least), begins.astype(np.uint16)


_COARSE_TENTHS, _COARSE_LEAST, _COARSE_CELLS = _tenths_table(_COARSE)
_FINE_TENTHS, _FINE_LEAST, _FINE_CELLS = _tenths_table(_FINE)


@inlined
def quantized_tenths(dist: float, step: float) -> float:
    """Reported distance in tenths of a metre, a whole number."""
    if step < _EPS:
        return float(np.rint(dist / 0.1))
    if dist < _TABULATED and step == _FINE:
        k = int(_FINE_CELLS[int(dist * _CELLS)])
        return float(_FINE_TENTHS[k + 1 if dist >= _FINE_LEAST[k + 1] else k])
    if dist < _TABULATED and step == _COARSE:
        k = int(_COARSE_CELLS[int(dist * _CELLS)])
        return float(_COARSE_TENTHS[k + 1 if dist >= _COARSE_LEAST[k + 1] else k])
    return tenths_by_logarithm(dist, step)


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
    """Probability that a detail is lost at a reported distance (m); may be above 1."""
    return (dist - far) / (too_far - far) if dist > far else 0.0


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
def put_place(out: NDArray[np.void], n: int, code: int, fields: int, distance: float, direction: float) -> None:
    """Write where object n of a message is, and nothing else of it."""
    out["code"][0, n] = code
    out["fields"][0, n] = fields
    out["distance"][0, n] = distance
    out["direction"][0, n] = direction


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
    put_place(out, n, code, fields, distance, direction)
    out["team"][0, n] = 0
    out["unum"][0, n] = 0
    out["goalie"][0, n] = 0
    out["distance_change"][0, n] = radial
    out["direction_change"][0, n] = tangential
    out["body"][0, n] = 0.0
    out["head"][0, n] = 0.0
    out["pointing"][0, n] = 0.0
