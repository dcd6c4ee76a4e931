"""Seeds that are drawn from other seeds: of trials, sessions, matches of a batch and samples."""

from __future__ import annotations

import numpy as np


def derived_seed(seed: int, *key: int) -> int:
    """Return the seed that belongs to a seed and a key, not negative and below 2**31."""
    return int(np.random.SeedSequence(seed, spawn_key=key).generate_state(1, np.uint32)[0] >> 1)
