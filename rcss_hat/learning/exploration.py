"""Choosing among action values: greedy with fair ties, and epsilon-greedy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import kernel
from rcss_hat.numeric.rng import bernoulli, integer

NO_ACTION = -1


@kernel
def greedy(rng: NDArray[np.uint64], q: NDArray[np.float64], n: int, favoured: int, bonus: float) -> int:
    """Choose the best of n actions, uniformly among equals.

    Parameters
    ----------
    rng : ndarray of uint64, shape (4,)
        Drawn from only when there are ties.
    q : ndarray of float64, shape (at least n,)
    n : int
    favoured : int
        Action whose value is taken for ``bonus`` more than it is; `NO_ACTION`: none.
    bonus : float
    """
    best, best_value, ties = 0, -np.inf, 0
    for a in range(n):
        value = q[a] + bonus if a == favoured else q[a]
        if value > best_value:
            best, best_value, ties = a, value, 1
        elif value == best_value:
            ties += 1
            if integer(rng, ties) == 0:
                best = a
    return best


@kernel
def epsilon_greedy(
    rng: NDArray[np.uint64], q: NDArray[np.float64], n: int, epsilon: float, favoured: int, bonus: float
) -> int:
    """Choose uniformly among all n actions with probability ``epsilon``, else `greedy`."""
    if bernoulli(rng, epsilon):
        return integer(rng, n)
    return greedy(rng, q, n, favoured, bonus)
