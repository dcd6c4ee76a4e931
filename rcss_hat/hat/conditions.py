"""One comparison of a state variable with a threshold, the atom of every rule."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Operator = Literal["<=", ">="]
AT_MOST: Operator = "<="
AT_LEAST: Operator = ">="


@dataclass(frozen=True, slots=True)
class Condition:
    """A bound on one variable; both operators include the threshold, and a missing value never fulfils it.

    Attributes
    ----------
    feature : int
        Zero-based index of the variable.
    operator : {"<=", ">="}
    threshold : float
        Finite; in the unit of the variable.
    """

    feature: int
    operator: Operator
    threshold: float

    def __post_init__(self) -> None:
        if self.operator not in (AT_MOST, AT_LEAST):
            raise ValueError(f"the operator of a condition must be '<=' or '>=', not {self.operator!r}")
        if not math.isfinite(self.threshold):
            raise ValueError(f"the threshold of a condition must be finite, not {self.threshold!r}")
        if self.feature < 0:
            raise ValueError(f"the index of a variable must be 0 or more, not {self.feature!r}")

    def holds(self, value: float) -> bool:
        """Whether a value of the variable fulfils the condition."""
        return value <= self.threshold if self.operator == AT_MOST else value >= self.threshold

    def covers(self, rows: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which rows fulfil the condition.

        Parameters
        ----------
        rows : ndarray, shape (n_rows, n_variables)

        Returns
        -------
        ndarray of bool, shape (n_rows,)
        """
        column = rows[:, self.feature]
        return column <= self.threshold if self.operator == AT_MOST else column >= self.threshold


def each_bound_once(conditions: tuple[Condition, ...]) -> tuple[Condition, ...]:
    """Leave out what follows from another bound of the same kind: of several on a variable the tightest decides.

    Returns
    -------
    tuple of Condition
        In the order in which variables and operators come first.
    """
    tightest: dict[tuple[int, str], Condition] = {}
    for condition in conditions:
        bound = (condition.feature, condition.operator)
        known = tightest.get(bound)
        if known is None or known.holds(condition.threshold):
            tightest[bound] = condition
    return tuple(tightest.values())


def covered_by_all(conditions: tuple[Condition, ...], rows: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which rows fulfil all conditions; every row does when there are none."""
    covered = np.ones(len(rows), dtype=np.bool_)
    for condition in conditions:
        covered &= condition.covers(rows)
    return covered
