"""What a learner's decision is made of: observe, select by the transfer method, learn.

These kernels are the whole interface of a learner to whoever plays, the arena or a player over UDP. The advice is
D(s) as an action number, or `NO_ADVICE`; the confidence belongs to it and lies between 0 and 1.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.transfer.method import SELECT
from rcss_hat.learning.sarsa import Learner, advance, begin, conclude, count_episode, observe
from rcss_hat.numeric.jit import kernel

_kernel_at = SELECT.at


@kernel
def select(
    method: NDArray[np.void], learner: NDArray[np.void], rng: NDArray[np.uint64], advice: int, confidence: float
) -> int:
    """Select by the method of the record; the result is the row of the weights that gets the credit."""
    chosen = _kernel_at(method["select"][0])
    return chosen(method, learner, rng, advice, confidence)


@kernel
def target_bonus(method: NDArray[np.void], selected: int, advice: int) -> float:
    """Return what is added to Q of the selected action in the values that learning aims at."""
    return method["bonus"][0] if selected == advice else 0.0


@kernel
def executed_action(learner: NDArray[np.void], selected: int, advice: int) -> int:
    """Return what selecting a row of the weights makes the keeper do: a pseudo-action executes the advice."""
    return selected if selected < learner["n_actions"][0] else advice


@kernel
def decide_first(
    learner: Learner, method: NDArray[np.void], state: NDArray[np.float64], advice: int, confidence: float
) -> int:
    """Take a keeper's first decision in an episode.

    Parameters
    ----------
    learner : Learner
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
    observe(learner, state)
    selected = select(method, learner.record, learner.rng, advice, confidence)
    begin(learner, selected, target_bonus(method, selected, advice))
    return executed_action(learner.record, selected, advice)


@kernel
def decide_step(
    learner: Learner,
    method: NDArray[np.void],
    reward: float,
    state: NDArray[np.float64],
    advice: int,
    confidence: float,
) -> int:
    """Take any later decision and learn from the reward (cycles) of the last one; see `decide_first`."""
    observe(learner, state)
    selected = select(method, learner.record, learner.rng, advice, confidence)
    advance(learner, reward, selected, target_bonus(method, selected, advice))
    return executed_action(learner.record, selected, advice)


@kernel
def finish_episode(learner: Learner, reward: float) -> None:
    """Tell a keeper that the episode is over.

    A keeper that acted learns from the ``reward``, the cycles since its last decision; every keeper counts the episode.
    """
    conclude(learner, reward)
    count_episode(learner.record)
