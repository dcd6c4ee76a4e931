"""The decision of a learning keeper, compiled: observe, select by the transfer method, learn.

These kernels are the whole interface of a learner to whoever plays, the arena or a player over UDP. The advice is
D(s) as an action number, or `NO_ADVICE`; the confidence belongs to it and lies between 0 and 1. Arguments come in one
order: the learner's record and random stream, the approximator's record and table, the learner's weights and traces,
the method's record, then what happened.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.transfer.chat import select_chat
from rcss_hat.hat.transfer.extra_action import select_extra_action
from rcss_hat.hat.transfer.no_prior import select_no_prior
from rcss_hat.hat.transfer.ppr import select_ppr
from rcss_hat.hat.transfer.record import KIND_CHAT, KIND_EXTRA_ACTION, KIND_PPR, KIND_VALUE_BONUS
from rcss_hat.hat.transfer.value_bonus import select_value_bonus, target_bonus
from rcss_hat.learning.sarsa import advance, begin, conclude, count_episode, observe
from rcss_hat.numeric.jit import kernel


@kernel
def select(
    method: NDArray[np.void], learner: NDArray[np.void], rng: NDArray[np.uint64], advice: int, confidence: float
) -> int:
    """Select by the method of the record; the result is the row of the weights that gets the credit."""
    kind = method["kind"][0]
    if kind == KIND_PPR:
        return select_ppr(method, learner, rng, advice)
    if kind == KIND_VALUE_BONUS:
        return select_value_bonus(method, learner, rng, advice)
    if kind == KIND_EXTRA_ACTION:
        return select_extra_action(method, learner, rng, advice)
    if kind == KIND_CHAT:
        return select_chat(method, learner, rng, advice, confidence)
    return select_no_prior(learner, rng)


@kernel
def executed_action(learner: NDArray[np.void], selected: int, advice: int) -> int:
    """Return what selecting a row of the weights makes the keeper do: a pseudo-action executes the advice."""
    return selected if selected < learner["n_actions"][0] else advice


@kernel
def decide_first(
    learner: NDArray[np.void],
    rng: NDArray[np.uint64],
    features: NDArray[np.void],
    table: NDArray[np.float64],
    weights: NDArray[np.float64],
    traces: NDArray[np.float64],
    method: NDArray[np.void],
    state: NDArray[np.float64],
    advice: int,
    confidence: float,
) -> int:
    """Take a keeper's first decision in an episode.

    Parameters
    ----------
    learner : LEARNER, shape (1,)
    rng : ndarray of uint64, shape (4,)
    features : FEATURES, shape (1,)
    table : ndarray of float64, shape (rows + 1, active)
    weights : ndarray of float64, shape (actions, n_features)
    traces : ndarray of float64, the shape of the weights or (0, 0)
    method : METHOD, shape (1,)
    state : ndarray of float64, shape (n_variables,)
    advice : int
        D(s), or `NO_ADVICE`.
    confidence : float

    Returns
    -------
    int
        The action to execute.
    """
    observe(learner, features, table, weights, state)
    selected = select(method, learner, rng, advice, confidence)
    begin(learner, features, table, traces, selected, target_bonus(method, selected, advice))
    return executed_action(learner, selected, advice)


@kernel
def decide_step(
    learner: NDArray[np.void],
    rng: NDArray[np.uint64],
    features: NDArray[np.void],
    table: NDArray[np.float64],
    weights: NDArray[np.float64],
    traces: NDArray[np.float64],
    method: NDArray[np.void],
    reward: float,
    state: NDArray[np.float64],
    advice: int,
    confidence: float,
) -> int:
    """Take any later decision and learn from the reward (cycles) of the last one; see `decide_first`."""
    observe(learner, features, table, weights, state)
    selected = select(method, learner, rng, advice, confidence)
    bonus = target_bonus(method, selected, advice)
    advance(learner, features, table, weights, traces, reward, selected, bonus)
    return executed_action(learner, selected, advice)


@kernel
def finish_episode(
    learner: NDArray[np.void],
    features: NDArray[np.void],
    table: NDArray[np.float64],
    weights: NDArray[np.float64],
    traces: NDArray[np.float64],
    reward: float,
) -> None:
    """Tell a keeper that the episode is over.

    A keeper that acted learns from the ``reward``, the cycles since its last decision; every keeper counts the episode.
    """
    conclude(learner, features, table, weights, traces, reward)
    count_episode(learner)
