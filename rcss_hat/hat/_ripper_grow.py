"""Growing a rule condition by condition, and cutting it back.

Growth takes the condition with the largest information gain until no negative row is left; pruning drops a final
sequence of conditions judged by rows that growth has not seen (Cohen 1995, sections 2.2 and 3).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat._ripper_length import TOLERANCE
from rcss_hat.hat._ripper_table import Mask, Table, keep_rows
from rcss_hat.hat.conditions import AT_LEAST, AT_MOST, Condition

Conditions = tuple[Condition, ...]


class Step(NamedTuple):
    """The best next condition: rows it covers, their weight and the weight of the positive ones."""

    condition: Condition
    rows: NDArray[np.intp]
    positive: float
    total: float


def best_step(table: Table, order: NDArray[np.intp], positive: NDArray[np.float64], rate: float) -> Step | None:
    """Find the condition of largest gain among all variables, values and operators.

    Parameters
    ----------
    table : Table
    order : ndarray of int, shape (n_features, n_rows)
        The rows still covered, in ascending order of each variable.
    positive : ndarray, shape (rows of the table,)
        Weight of each row if it is positive, else 0.
    rate : float
        Smoothed share of positives among the rows still covered.

    Returns
    -------
    Step or None
        None when no condition has a gain above 0. The first of equals in the order of the variables, then of
        ascending values, then ">=" before "<=".
    """
    values = table.sorted_values(order)
    weights, positives = table.weights[order], positive[order]
    known = np.ones(values.shape, dtype=np.bool_)
    if table.has_missing:
        known = ~np.isnan(values)
        weights, positives = weights * known, positives * known
    totals, hits = weights.cumsum(axis=1), positives.cumsum(axis=1)

    changes = values[:, 1:] != values[:, :-1]
    # last axis: ">=" at the first row of each value, "<=" at its last row
    candidate = np.empty((*values.shape, 2), dtype=np.bool_)
    candidate[:, 0, 0] = candidate[:, -1, 1] = True
    candidate[:, 1:, 0] = candidate[:, :-1, 1] = changes
    candidate &= known[:, :, np.newaxis]
    where = np.flatnonzero(candidate)
    if not len(where):
        return None

    t = np.stack((totals[:, -1:] - totals + weights, totals), axis=2).ravel()[where]
    p = np.stack((hits[:, -1:] - hits + positives, hits), axis=2).ravel()[where]
    # Not NumPy's logarithm, whose last digit depends on the processor: of equal gains another might then win.
    logarithms = np.array([math.log2(share) for share in ((p + 1.0) / (t + 1.0)).tolist()])
    gain = p * (logarithms - math.log2(rate))
    best = int(gain.argmax())
    if not gain[best] > 0.0:
        return None
    feature, rest = divmod(int(where[best]), 2 * order.shape[1])
    at, at_most = divmod(rest, 2)
    n_known = int(known[feature].sum())
    rows = order[feature, : at + 1] if at_most else order[feature, at:n_known]
    condition = Condition(feature, AT_MOST if at_most else AT_LEAST, float(values[feature, at]))
    return Step(condition, rows, float(p[best]), float(t[best]))


def grow(table: Table, rows: Mask, positive: NDArray[np.float64], start: Conditions, min_weight: float) -> Conditions:
    """Add conditions to a rule until it covers no negative row or nothing is gained.

    Parameters
    ----------
    table : Table
    rows : ndarray of bool
        The grow rows that fulfil the conditions to start from.
    positive : ndarray
        Weight of each row of the table if it is positive, else 0.
    start : tuple of Condition
        Conditions to keep and continue from.
    min_weight : float
        Growth ends at a condition that would leave less positive weight than this.
    """
    conditions = list(start)
    order = table.sorted_rows(rows)
    rate = (positive[rows].sum() + 1.0) / (table.weights[rows].sum() + 1.0)
    while order.shape[1] and rate < 1.0 - TOLERANCE:
        step = best_step(table, order, positive, rate)
        if step is None or step.positive < min_weight - TOLERANCE:
            break
        conditions.append(step.condition)
        covered = np.zeros(len(table.labels), dtype=np.bool_)
        covered[step.rows] = True
        order = keep_rows(order, covered)
        rate = (step.positive + 1.0) / (step.total + 1.0)
    return tuple(conditions)


def prune(
    table: Table, rows: Mask, positive: NDArray[np.float64], conditions: Conditions, whole_set: bool
) -> Conditions:
    """Drop the final conditions that do not help on the prune rows.

    Parameters
    ----------
    table : Table
    rows : ndarray of bool
        Prune rows.
    positive : ndarray
        Weight of each row of the table if it is positive, else 0.
    conditions : tuple of Condition
    whole_set : bool
        Judge by the accuracy on all prune rows (optimisation) instead of the precision on the covered ones.

    Returns
    -------
    tuple of Condition
        The shortest of the best prefixes; all conditions when there are no prune rows.
    """
    if not rows.any():
        return conditions
    values, weights, hits = table.values[rows], table.weights[rows], positive[rows]
    all_rows, all_positive = float(weights.sum()), float(hits.sum())
    covered = np.ones(len(values), dtype=np.bool_)
    best_length, best_worth = 0, (all_positive + 1.0) / (all_rows + 2.0)
    for length, condition in enumerate(conditions, start=1):
        covered &= condition.covers(values)
        t, p = float(weights[covered].sum()), float(hits[covered].sum())
        if whole_set:
            true_negative = all_rows - all_positive - (t - p)
            worth = (p + true_negative) / all_rows
        else:
            worth = (p + 1.0) / (t + 2.0)
        if worth > best_worth:
            best_length, best_worth = length, worth
    return conditions[:best_length]
