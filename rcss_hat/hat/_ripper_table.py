"""The training rows of the rule learner: sorted once, split often."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat._ripper_length import TOLERANCE

Mask = NDArray[np.bool_]
"""Which rows of the table; shape (n_rows,)."""


@dataclass(frozen=True, slots=True)
class Table:
    """Training rows with their weights, and each variable's order.

    Attributes
    ----------
    values : ndarray, shape (n_rows, n_features)
        NaN where missing.
    labels : ndarray of int, shape (n_rows,)
        Index of the class.
    weights : ndarray, shape (n_rows,)
        Positive.
    order : ndarray of int, shape (n_features, n_rows)
        Rows in ascending order of each variable, missing ones last.
    has_missing : bool
    n_possible : int
        Number of conditions the rows offer: two per distinct value of every variable.
    """

    values: NDArray[np.float64]
    labels: NDArray[np.intp]
    weights: NDArray[np.float64]
    order: NDArray[np.intp]
    has_missing: bool
    n_possible: int

    def sorted_rows(self, rows: Mask) -> NDArray[np.intp]:
        """Indices of some rows in ascending order of each variable, shape (n_features, n_chosen)."""
        return keep_rows(self.order, rows)

    def sorted_values(self, order: NDArray[np.intp]) -> NDArray[np.float64]:
        """Values of each variable in a given order, same shape as the order."""
        return np.take_along_axis(self.values.T, order, axis=1)


def keep_rows(order: NDArray[np.intp], rows: Mask) -> NDArray[np.intp]:
    """Reduce an order to some of its rows; every variable keeps equally many."""
    return order[rows[order]].reshape(len(order), -1)


def make_table(
    values: NDArray[np.float64], labels: NDArray[np.intp], weights: NDArray[np.float64], folds: int = 3
) -> Table:
    """Put the rows into one order, deal out the weight of equal ones, and sort each variable.

    The weights of equal rows are added up and dealt out again over copies of the row: as many as the weight has units,
    but no more than there are folds. So neither the order of the rows in the data nor the choice between repeating a
    row and giving it more weight has any influence on what is learned, and heavy rows can be in the grow rows and in
    the prune rows. Rows of weight 0 are left out.
    """
    values, labels, weights = _merge(values, labels, weights)
    copies = np.clip(np.ceil(weights - TOLERANCE), 1, folds).astype(np.intp)
    values, labels, weights = np.repeat(values, copies, axis=0), np.repeat(labels, copies), _deal(weights, copies)
    by_value = np.argsort(values.T, axis=1, kind="stable")
    ascending = np.take_along_axis(values.T, by_value, axis=1)
    missing = np.isnan(ascending)
    distinct = (~missing[:, 0]).sum() + ((ascending[:, 1:] != ascending[:, :-1]) & ~missing[:, 1:]).sum()
    return Table(values, labels, weights, by_value, bool(missing.any()), 2 * int(distinct))


def _merge(
    values: NDArray[np.float64], labels: NDArray[np.intp], weights: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.intp], NDArray[np.float64]]:
    """Sort the rows and add up the weights of equal ones."""
    present = weights > 0.0
    values, labels, weights = values[present], labels[present], weights[present]
    order = np.lexsort((labels, *values.T[::-1]))
    values, labels, weights = values[order], labels[order], weights[order]
    same = (values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))
    first = np.ones(len(labels), dtype=np.bool_)
    first[1:] = ~same.all(axis=1) | (labels[1:] != labels[:-1])
    return values[first], labels[first], np.add.reduceat(weights, np.flatnonzero(first))


def _deal(weights: NDArray[np.float64], copies: NDArray[np.intp]) -> NDArray[np.float64]:
    """Deal each weight out over copies, in whole units so that sums stay exact; the last one gets the fraction."""
    whole = np.floor(weights)
    last = np.cumsum(copies) - 1
    number = np.arange(last[-1] + 1) - np.repeat(last + 1 - copies, copies)
    total, pieces = np.repeat(whole, copies), np.repeat(copies, copies)
    dealt = np.floor((total + pieces - 1 - number) / pieces)
    dealt[last] += weights - whole
    return dealt


def split_rows(labels: NDArray[np.intp], rows: Mask, folds: int, rng: np.random.RandomState) -> tuple[Mask, Mask]:
    """Split rows at random into grow rows, (folds - 1) / folds of them, and prune rows.

    Each class is spread evenly: its rows are shuffled, the classes are laid end to end, and the rows are dealt out.
    """
    chosen = np.flatnonzero(rows)
    chosen = chosen[rng.permutation(len(chosen))]
    chosen = chosen[np.argsort(labels[chosen], kind="stable")]
    dealt = np.concatenate([chosen[offset::folds] for offset in range(folds)])
    n_grow = len(dealt) * (folds - 1) // folds
    grow, prune = np.zeros_like(rows), np.zeros_like(rows)
    grow[dealt[:n_grow]] = True
    prune[dealt[n_grow:]] = True
    return grow, prune
