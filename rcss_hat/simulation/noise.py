"""Random vectors of motion and kicks."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import inlined
from rcss_hat.numeric.rng import uniform


@inlined
def polar_noise(rng: NDArray[np.uint64], limit: float) -> tuple[float, float]:
    """Draw polar(U(0, limit), U(-pi, pi)), the noise of 12.0.0 and later; limit may be negative.

    Nothing is drawn, and the vector is zero, when the limit is below 1e-10.
    """
    if abs(limit) < 1e-10:
        return 0.0, 0.0
    r = uniform(rng, min(0.0, limit), max(0.0, limit))
    angle = uniform(rng, -math.pi, math.pi)
    return r * math.cos(angle), r * math.sin(angle)


@inlined
def square_noise(rng: NDArray[np.uint64], limit: float) -> tuple[float, float]:
    """Draw (U(-limit, limit), U(-limit, limit)), the noise of 11.1."""
    if abs(limit) < 1e-10:
        return 0.0, 0.0
    limit = abs(limit)
    x = uniform(rng, -limit, limit)
    return x, uniform(rng, -limit, limit)
