"""Making the records, weights and traces of a learner from its settings."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.learning.config import LearnerConfig
from rcss_hat.learning.exploration import NO_ACTION
from rcss_hat.learning.features import Approximator
from rcss_hat.learning.sarsa import LEARNER, MAX_ACTIONS


def learner_record(config: LearnerConfig, approximator: Approximator, n_actions: int) -> NDArray[np.void]:
    """Make the record of a learner that has not learned yet, learning and exploring switched on.

    Parameters
    ----------
    config : LearnerConfig
    approximator : Approximator
    n_actions : int
        Actions that can be executed.

    Returns
    -------
    LEARNER, shape (1,)

    Raises
    ------
    ValueError
        For more actions than fit (11), or fewer than 1.
    """
    if not 1 <= n_actions < MAX_ACTIONS:
        raise ValueError(f"a learner has 1 to {MAX_ACTIONS - 1} actions, not {n_actions}")
    divisor = config.divisor_for(approximator)
    record = np.zeros(1, dtype=LEARNER)
    record["n_actions"][0] = n_actions
    record["learning"][0] = record["exploring"][0] = 1
    record["gamma"][0] = config.gamma
    record["lambda"][0] = config.lambda_
    record["trace_minimum"][0] = config.trace_minimum
    record["step"][0] = config.alpha / divisor
    record["step_decay"][0] = config.alpha_decay
    record["step_final"][0] = config.alpha_final / divisor
    record["epsilon"][0] = config.epsilon
    record["epsilon_decay"][0] = config.epsilon_decay
    record["epsilon_final"][0] = config.epsilon_final
    record["last_action"][0] = NO_ACTION
    return record


def initial_weights(config: LearnerConfig, approximator: Approximator, rows: int) -> NDArray[np.float64]:
    """Make the weights of a learner that has not learned yet.

    Parameters
    ----------
    rows : int
        Actions, pseudo-actions included.

    Returns
    -------
    ndarray of float64, shape (rows, n_features)
        Zero, or such that every action has the value ``config.initial_value``.
    """
    return np.full((rows, approximator.n_features), config.initial_value / approximator.sum)


def initial_traces(config: LearnerConfig, approximator: Approximator, rows: int) -> NDArray[np.float64]:
    """Make the traces: shape (rows, n_features), or (0, 0) when lambda is 0 and there are none."""
    return np.zeros((rows, approximator.n_features) if config.lambda_ > 0.0 else (0, 0))
