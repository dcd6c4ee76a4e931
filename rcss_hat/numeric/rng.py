"""Random streams as plain arrays, so that kernels, checkpoints and resumed runs share them.

A stream is a ``uint64`` array of four words, the state of xoshiro256++ (Blackman and Vigna 2019). It can be a row of a
larger array, is saved as it stands, and costs a kernel nothing to be passed. Seeds are spread by NumPy's
``SeedSequence``, so that streams with different keys are independent.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import inlined, kernel

STREAM_WORDS = 4
SERVER, PLAYER, POLICY, LEARNER, TEACHER = range(5)
"""First word of a stream's key: whose randomness it is."""

_TO_UNIT = 2.0**-53


def stream(seed: int, *key: int) -> NDArray[np.uint64]:
    """Make the random stream of a seed and a key.

    Parameters
    ----------
    seed : int
        The seed a person chose, not negative.
    *key : int
        Whose stream it is, for example ``PLAYER, side, unum``.

    Returns
    -------
    ndarray of uint64, shape (4,)
    """
    return np.random.SeedSequence(seed, spawn_key=key).generate_state(STREAM_WORDS, np.uint64).astype(np.uint64)


@inlined
def next_uint64(rng: NDArray[np.uint64]) -> np.uint64:
    """Draw 64 random bits and advance the stream."""
    s0, s1, s2, s3 = rng[0], rng[1], rng[2], rng[3]
    t = s0 + s3
    result = ((t << np.uint64(23)) | (t >> np.uint64(41))) + s0
    shifted = s1 << np.uint64(17)
    s2 ^= s0
    s3 ^= s1
    s1 ^= s2
    s0 ^= s3
    s2 ^= shifted
    s3 = (s3 << np.uint64(45)) | (s3 >> np.uint64(19))
    rng[0], rng[1], rng[2], rng[3] = s0, s1, s2, s3
    return result


@inlined
def uniform(rng: NDArray[np.uint64], low: float, high: float) -> float:
    """Draw from U[low, high); the middle, without a draw, when the interval is shorter than 1e-10 (as rcssserver)."""
    if high - low < 1e-10:
        return 0.5 * (low + high)
    return low + (high - low) * (np.float64(next_uint64(rng) >> np.uint64(11)) * _TO_UNIT)


@inlined
def integer(rng: NDArray[np.uint64], n: int) -> int:
    """Draw uniformly from 0 .. n-1."""
    return int(math.floor(uniform(rng, 0.0, 1.0) * n))


@inlined
def bernoulli(rng: NDArray[np.uint64], p: float) -> bool:
    """Draw true with probability p; certain cases (p <= 0, p >= 1) take no draw."""
    if p <= 0.0:
        return False
    if p >= 1.0:
        return True
    return uniform(rng, 0.0, 1.0) < p


@kernel
def normal(rng: NDArray[np.uint64]) -> float:
    """Draw from the standard normal distribution (Box and Muller; two uniform draws)."""
    u = 1.0 - uniform(rng, 0.0, 1.0)
    return math.sqrt(-2.0 * math.log(u)) * math.cos(2.0 * math.pi * uniform(rng, 0.0, 1.0))
