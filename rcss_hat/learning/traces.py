"""Eligibility traces: which weights of earlier decisions a new reward still changes.

Traces are a matrix like the weights. Of every variable only the features between ``trace_low`` and ``trace_high`` can
have one, so that a step touches what the episode has visited and no more. Players' own rules (LinearSarsaAgent.cc):
replacing traces, those below ``trace_minimum`` dropped when they decay, the active features of all other actions
cleared. A feature with a value less than 1 keeps the greater of its decayed trace and its value.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import kernel


@kernel
def clear_traces(
    traces: NDArray[np.float64], low: NDArray[np.int32], high: NDArray[np.int32], n_variables: int
) -> None:
    """Forget all traces.

    Parameters
    ----------
    traces : ndarray of float64, shape (actions, n_features)
    low, high : ndarray of int32, shape (MAX_VARIABLES,)
        Features [low, high) of each variable that may have traces.
    n_variables : int
    """
    for a in range(traces.shape[0]):
        for v in range(n_variables):
            traces[a, low[v] : high[v]] = 0.0
    for v in range(n_variables):
        low[v] = 0
        high[v] = 0


@kernel
def decay_traces(
    traces: NDArray[np.float64],
    low: NDArray[np.int32],
    high: NDArray[np.int32],
    n_variables: int,
    factor: float,
    minimum: float,
) -> None:
    """Multiply all traces by ``factor`` and drop those that fall below ``minimum``."""
    for a in range(traces.shape[0]):
        for v in range(n_variables):
            run = traces[a, low[v] : high[v]]
            for i in range(run.shape[0]):
                decayed = run[i] * factor
                run[i] = decayed if decayed >= minimum else 0.0


@kernel
def replace_traces(
    table: NDArray[np.float64],
    traces: NDArray[np.float64],
    low: NDArray[np.int32],
    high: NDArray[np.int32],
    start: NDArray[np.int32],
    row: NDArray[np.int32],
    n_variables: int,
    action: int,
) -> None:
    """Give the active features of a state traces for ``action``, and take them away for all other actions."""
    active = table.shape[1]
    for v in range(n_variables):
        end = start[v] + active
        values = table[row[v]]
        for a in range(traces.shape[0]):
            run = traces[a, start[v] : end]
            for i in range(active):
                if a == action:
                    run[i] = max(run[i], values[i])
                elif values[i] > 0.0:  # a run may begin or end with a function that is just cut off
                    run[i] = 0.0
        low[v] = start[v] if low[v] == high[v] else min(low[v], start[v])
        high[v] = max(high[v], end)


@kernel
def add_traces(
    weights: NDArray[np.float64],
    traces: NDArray[np.float64],
    low: NDArray[np.int32],
    high: NDArray[np.int32],
    n_variables: int,
    amount: float,
) -> None:
    """Add ``amount`` times its trace to every weight."""
    for a in range(traces.shape[0]):
        for v in range(n_variables):
            run = weights[a, low[v] : high[v]]
            trace = traces[a, low[v] : high[v]]
            for i in range(run.shape[0]):
                run[i] += amount * trace[i]
