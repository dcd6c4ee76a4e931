"""The side line a player looks at.

Source: 19.0.0, src/visualsenderplayer.cpp (sendLines, sendLine). A line is seen where the line of sight (the direction
of the face) meets it: at most one from inside the pitch, at most two from outside.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import normalize_radians
from rcss_hat.numeric.jit import kernel
from rcss_hat.protocol.records import HAS_DISTANCE, LINE
from rcss_hat.simulation.observation import put_object, quantized_tenths, whole_degrees
from rcss_hat.simulation.pitch import HALF_LENGTH, HALF_WIDTH

_RIGHT_ANGLE = 0.5 * math.pi
_NORMALS = np.array([math.pi, 0.0, -_RIGHT_ANGLE, _RIGHT_ANGLE])
"""Outward normals (radians) of the lines l, r, t, b."""
_PLACES = np.array([-HALF_LENGTH, HALF_LENGTH, -HALF_WIDTH, HALF_WIDTH])
"""Their x (l, r) or y (t, b)."""


@kernel
def see_lines(
    x: float,
    y: float,
    body: float,
    neck: float,
    step: float,
    high: bool,
    n: int,
    out: NDArray[np.void],
) -> int:
    """Add the lines a player sees to a SEE record.

    Parameters
    ----------
    x, y : float
        Position of the player (m).
    body, neck : float
        His angles (radians).
    step : float
        ``quantize_step_l``.
    high : bool
        High quality: with distance.
    n : int
        Objects in the record so far.
    out : ndarray of SEE, shape (1,)

    Returns
    -------
    int
        Objects in the record now.
    """
    most = n + 1 if abs(x) < HALF_LENGTH and abs(y) < HALF_WIDTH else n + 2
    for line in range(4):
        if n >= most:
            break
        mine = x if line < 2 else y
        along = y if line < 2 else x
        away = _PLACES[line] - mine
        normal = _NORMALS[line]
        if (line % 2 == 0) == (away > 0.0) and away != 0.0:
            normal = _NORMALS[line ^ 1]  # the player is beyond the line
        angle = normalize_radians(normal - body - neck)
        if abs(angle) >= _RIGHT_ANGLE:
            continue
        offset = away * math.tan(angle)
        met = along - offset if line < 2 else along + offset
        if abs(met) > (HALF_WIDTH if line < 2 else HALF_LENGTH):
            continue
        direction = whole_degrees(angle - _RIGHT_ANGLE if angle > 0.0 else angle + _RIGHT_ANGLE)
        if high:
            tenths = quantized_tenths(abs(away / math.cos(angle)), step)
            put_object(out, n, LINE + line, HAS_DISTANCE, tenths / 10.0, direction, 0.0, 0.0)
        else:
            put_object(out, n, LINE + line, 0, 0.0, direction, 0.0, 0.0)
        n += 1
    return n
