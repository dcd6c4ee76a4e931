"""Fixed policies for the keeper with the ball: hold, random, hand-coded."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric import rng
from rcss_hat.numeric.jit import kernel

HOLD_ACTION = 0
SAFE_DISTANCE = 5.0
"""The hand-coded policy holds while every taker is farther than this from the ball (m)."""
HOLD_SCORE = 90.0
DISTANCE_WEIGHT = 4.0
"""Degrees of pass angle that 1 m of distance to the receiver's nearest taker is worth."""


@kernel
def hold() -> int:
    """Hold, always."""
    return HOLD_ACTION


@kernel
def random_action(stream: NDArray[np.uint64], n_actions: int) -> int:
    """Draw every action with the same probability, anew at every decision."""
    return rng.integer(stream, n_actions)


@kernel
def hand(state: NDArray[np.float64], n_keepers: int, n_takers: int) -> int:
    """Choose by the hand-coded rule of Stone, Sutton and Kuhlmann (Adaptive Behavior 2005).

    Hold while no taker is near; else pass to whom nobody is near and the lane is open, unless holding scores higher.

    Parameters
    ----------
    state : ndarray of float64
        State variables (m, degrees).
    n_keepers, n_takers : int

    Returns
    -------
    int
        0 hold, i pass to the i-th nearest keeper.
    """
    if state[n_keepers] > SAFE_DISTANCE:
        return HOLD_ACTION
    nearest = 2 * (n_keepers + n_takers) - 2
    angles = nearest + n_keepers - 1
    best, score = HOLD_ACTION, HOLD_SCORE
    for i in range(1, n_keepers):
        value = DISTANCE_WEIGHT * state[nearest + i] + state[angles + i]
        if value > score:
            best, score = i, value
    return best
