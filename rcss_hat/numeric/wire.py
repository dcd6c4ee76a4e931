"""Numbers as the server's text carries them.

rcssserver prints reals with six significant digits (C++ streams, ``%g``). Kernels that stand in for the text, in the
arena, must hand over the very numbers a client would have read from it. A number m / 10**k with integer m is the
double nearest to its decimal text, so rounding to such a quotient and reading the text give the same bits.
"""

from __future__ import annotations

import math

import numpy as np

from rcss_hat.numeric.jit import njit


@njit
def quantize(value: float, step: float) -> float:
    """Round to a multiple of ``step``, halves to even, -0 kept; unchanged when the step is below 1e-10 (19.0.0)."""
    if step < 1e-10:
        return value
    return float(np.rint(value / step)) * step


@njit
def six_digits(value: float) -> float:
    """Return the double that reading ``"%g" % value`` gives."""
    magnitude = abs(value)
    if magnitude == 0.0 or not math.isfinite(value):
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
