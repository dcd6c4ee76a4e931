"""Decision lists as kernels read them: one array of rows, and what finds the answer for a state."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import njit

RULE_ROW = np.dtype(
    [
        ("feature", "i4"),  # variable to compare; -1: an answer
        ("skip", "i4"),  # row to go on with when the comparison fails
        ("action", "i4"),  # answers: the action, else -1
        ("sign", "f8"),  # 1: at most the threshold, -1: at least
        ("threshold", "f8"),
        ("confidence", "f8"),  # answers: Laplace estimate of being right; 1 where there are no training counts
    ]
)
"""A row of a decision list as kernels read it: a comparison, or, after the comparisons of a rule, its answer."""

RuleArrays = NDArray[np.void]
"""Rows of ``RULE_ROW``; one array whatever the length of the list, so that kernels are compiled once."""


@njit
def deciding_row(rules: RuleArrays, state: NDArray[np.float64]) -> int:
    """Find the row of the answer for a state.

    Parameters
    ----------
    rules : ndarray of RULE_ROW
    state : ndarray of float64, shape (n_variables,)

    Returns
    -------
    int
        Index of the row whose fields ``action`` and ``confidence`` hold.
    """
    feature, skip, sign, threshold = rules["feature"], rules["skip"], rules["sign"], rules["threshold"]
    row = 0
    while feature[row] >= 0:
        if sign[row] * state[feature[row]] <= sign[row] * threshold[row]:
            row += 1
        else:
            row = skip[row]
    return row


@njit
def advise(rules: RuleArrays, state: NDArray[np.float64]) -> int:
    """Return the action that a decision list advises in a state; see ``deciding_row``."""
    return rules["action"][deciding_row(rules, state)]
