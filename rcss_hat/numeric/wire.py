"""Numbers as the server's text carries them.

rcssserver prints reals with six significant digits (C++ streams, ``%g``). Kernels that stand in for the text, in the
arena, must hand over the very numbers a client would have read from it. A number m / 10**k with integer m is the
double nearest to its decimal text, so rounding to such a quotient and reading the text give the same bits.
"""

from __future__ import annotations

import math

import numpy as np

from rcss_hat.numeric.jit import inlined, kernel

_POWERS = np.array([1.0, 1e1, 1e2, 1e3, 1e4, 1e5])


@inlined
def quantize(value: float, step: float) -> float:
    """Round to a multiple of ``step``, halves to even, -0 kept; unchanged when the step is below 1e-10 (19.0.0)."""
    if step < 1e-10:
        return value
    return float(np.rint(value / step)) * step


@kernel
def six_digits(value: float) -> float:
    """Return the double that reading ``"%g" % value`` gives."""
    magnitude = abs(value)
    if magnitude < 1e6 and magnitude == math.floor(magnitude):
        return value
    if 1.0 <= magnitude < 1e6:
        places = 0
        while magnitude < _POWERS[5 - places]:
            places += 1
        return float(math.copysign(np.rint(magnitude * _POWERS[places]) / _POWERS[places], value))
    if not math.isfinite(value):
        return value
    exponent = int(math.floor(math.log10(magnitude)))
    if magnitude >= 10.0 ** (exponent + 1):
        exponent += 1
    places = 5 - exponent
    if places >= 0:
        scale = 10.0**places
        return math.copysign(float(round(magnitude * scale)) / scale, value)
    scale = 10.0**-places
    return math.copysign(float(round(magnitude / scale)) * scale, value)
