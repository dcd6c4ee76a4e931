"""What a learner's record can hold, field by field; see `rcss_hat.numeric.bounds`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.learning.exploration import NO_ACTION
from rcss_hat.learning.features import MAX_VARIABLES, Approximator
from rcss_hat.numeric.bounds import FLAG, SAME, Bounds, BoundsError, check_records

MAX_WEIGHT = 1e100
"""A learner that has got so far has diverged; its square is still a number."""
_COUNT = (0.0, 2.0**53)
_VALUE = (-1e120, 1e120)


def check_learners(found: NDArray[np.void], fresh: NDArray[np.void], approximator: Approximator, n_rows: int) -> None:
    """Check learners that were read.

    Parameters
    ----------
    found, fresh : LEARNER, shape (keepers,)
        What was read, and learners of the same settings that have not learned yet.
    approximator : Approximator
        Of these settings.
    n_rows : int
        Rows of the weights: actions, pseudo-actions included.

    Raises
    ------
    BoundsError
        When a number would let a kernel leave its arrays, or is none that learning makes.
    """
    check_records("learners", found, fresh, learner_bounds(fresh, n_rows))
    features = approximator.record
    n, rows = approximator.n_variables, 1 << int(features["shift"][0])
    first = features["first"][0, :n].astype(np.int64)
    greatest = first + (features["last"][0, :n] >> features["shift"][0])
    end = greatest + approximator.table.shape[1]
    for start, row in (("start", "row"), ("last_start", "last_row")):
        # Before its first decision a learner has zeros there.
        _within(found, start, np.minimum(first, 0), greatest)
        _within(found, row, np.zeros(n), np.full(n, rows - 1))
    _within(found, "trace_low", np.zeros(n), end)
    _within(found, "trace_high", np.zeros(n), end)
    if (found["trace_low"] > found["trace_high"]).any():
        raise BoundsError("learners: 'trace_low' is greater than 'trace_high'")


def learner_bounds(fresh: NDArray[np.void], n_rows: int) -> Bounds:
    """Bounds of learners with the settings of fresh ones, whose weights have so many rows."""
    index = (0.0, 2.0**31)  # more narrowly below, by variable
    return {
        "n_actions": SAME, "learning": FLAG, "exploring": FLAG, "gamma": SAME, "lambda": SAME, "trace_minimum": SAME,
        "step_decay": SAME, "step_final": SAME, "epsilon_decay": SAME, "epsilon_final": SAME,
        "step": (0.0, float(fresh["step"].max())), "epsilon": (0.0, float(fresh["epsilon"].max())),
        "episodes": _COUNT, "decisions": _COUNT, "episode_decisions": _COUNT,
        "last_action": (float(NO_ACTION), n_rows - 1.0), "last_value": _VALUE, "last_start": index, "last_row": index,
        "q": _VALUE, "start": index, "row": index, "trace_low": index, "trace_high": index,
    }  # fmt: skip


def _within(found: NDArray[np.void], field: str, low: NDArray, high: NDArray) -> None:
    """Check a field of one number per variable; what is beyond the task's variables is not used, and 0."""
    n = len(high)
    values = found[field]
    if (values[:, :n] < low).any() or (values[:, :n] > high).any() or values[:, n:MAX_VARIABLES].any():
        raise BoundsError(f"learners: {field!r} points out of the features of its variable")
