"""SMDP Sarsa(lambda) with linear features, as the UT Austin players 0.6 learn (LinearSarsaAgent.cc).

One keeper is one learner. Between decisions it remembers its last action, the active features of the state in which it
took it, and the value Q(s, a) it had. The reward of a decision is the number of cycles until this keeper's next
decision or the end of the episode; with gamma = 1 time enters nowhere else. At a decision in state s':

1. `observe` computes Q(s', .) with the weights as they are;
2. someone selects a' from these values (`epsilon_greedy` here, a transfer method in `rcss_hat.hat.transfer`);
3. `advance` moves the weights of (s, a) by ``step * (r + gamma Q(s', a') - Q(s, a))`` times the feature values, and
   remembers (s', a') with the value it has under the *new* weights.

So selection precedes the update. Weights belong to what was selected. The kernels take a `Learner`; with lambda = 0 it
has no traces (an array of shape (0, 0)) and they cost nothing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcss_hat.learning.exploration import NO_ACTION, epsilon_greedy
from rcss_hat.learning.features import MAX_VARIABLES, add_features, locate, weighted_sum
from rcss_hat.learning.traces import add_traces, clear_traces, decay_traces, replace_traces
from rcss_hat.numeric.jit import kernel

MAX_ACTIONS = 12
"""Hold, ten passes and one pseudo-action of a transfer method."""

LEARNER = np.dtype(
    [
        # settings
        ("n_actions", "i4"),  # that can be executed; weights may have rows for more (pseudo-actions)
        ("learning", "u1"),  # weights move and episodes count
        ("exploring", "u1"),  # epsilon applies
        ("gamma", "f8"),
        ("lambda", "f8"),
        ("trace_minimum", "f8"),
        ("step_decay", "f8"),  # factor of ``step`` per episode
        ("step_final", "f8"),  # below which it does not fall
        ("epsilon_decay", "f8"),
        ("epsilon_final", "f8"),
        # schedules
        ("step", "f8"),  # alpha over its divisor
        ("epsilon", "f8"),
        ("episodes", "i8"),  # finished while learning, whether this keeper acted in them or not
        ("decisions", "i8"),  # taken while learning
        ("episode_decisions", "i8"),  # taken in this episode
        # memory of the last decision
        ("last_action", "i4"),  # NO_ACTION: none in this episode
        ("last_value", "f8"),
        ("last_start", "i4", (MAX_VARIABLES,)),  # features, see rcss_hat.learning.features.locate
        ("last_row", "i4", (MAX_VARIABLES,)),
        # the decision at hand
        ("q", "f8", (MAX_ACTIONS,)),  # Q(s, .) as it was selected from, without any bonus
        ("start", "i4", (MAX_VARIABLES,)),
        ("row", "i4", (MAX_VARIABLES,)),
        # lambda > 0: where traces are, see rcss_hat.learning.traces
        ("trace_low", "i4", (MAX_VARIABLES,)),
        ("trace_high", "i4", (MAX_VARIABLES,)),
    ]
)
"""One learner's settings and memory."""


class Learner(NamedTuple):
    """One keeper's learner, as kernels take it: its own record, stream, weights and traces, and what a team shares.

    Attributes
    ----------
    record : LEARNER, shape (1,)
    rng : ndarray of uint64, shape (4,)
        Random stream.
    features : FEATURES, shape (1,)
    table : ndarray of float64, shape (rows + 1, active)
        The approximator's, see `rcss_hat.learning.features`.
    weights : ndarray of float64, shape (actions, n_features)
        Actions include pseudo-actions.
    traces : ndarray of float64, the shape of the weights, or (0, 0) when lambda is 0
    """

    record: NDArray[np.void]
    rng: NDArray[np.uint64]
    features: NDArray[np.void]
    table: NDArray[np.float64]
    weights: NDArray[np.float64]
    traces: NDArray[np.float64]


@kernel
def observe(learner: Learner, state: NDArray[np.float64]) -> None:
    """Look at a state, shape (n_variables,): find its features and compute Q of every action, into ``record["q"]``."""
    record = learner.record
    start, row, q = record["start"][0], record["row"][0], record["q"][0]
    n = int(learner.features["n_variables"][0])
    for v in range(n):
        start[v], row[v] = locate(learner.features, v, state[v])
    for a in range(learner.weights.shape[0]):
        q[a] = weighted_sum(learner.table, learner.weights[a], start, row, n)


@kernel
def has_acted(record: NDArray[np.void]) -> bool:
    """Tell whether this keeper has taken a decision in this episode."""
    return record["last_action"][0] != NO_ACTION


@kernel
def begin(learner: Learner, action: int, bonus: float) -> None:
    """Take the first action of an episode in the state just observed.

    Parameters
    ----------
    learner : Learner
    action : int
        Row of the weights that gets the credit.
    bonus : float
        What a transfer method adds to the value of this action, 0 otherwise.
    """
    record = learner.record
    record["episode_decisions"][0] = 0
    n = int(learner.features["n_variables"][0])
    _remember(record, n, action, record["q"][0, action] + bonus)
    if learner.traces.shape[0] > 0 and record["learning"][0]:
        low, high = record["trace_low"][0], record["trace_high"][0]
        clear_traces(learner.traces, low, high, n)
        replace_traces(learner.table, learner.traces, low, high, record["start"][0], record["row"][0], n, action)


@kernel
def advance(learner: Learner, reward: float, action: int, bonus: float) -> None:
    """Learn from the reward of the last action, and take the next one in the state just observed.

    Parameters
    ----------
    learner, action, bonus
        As in `begin`.
    reward : float
        Cycles since the last decision.
    """
    record, traces = learner.record, learner.traces
    value = record["q"][0, action] + bonus
    n = int(learner.features["n_variables"][0])
    if not record["learning"][0]:
        _remember(record, n, action, value)
        return
    last_action = record["last_action"][0]
    gamma = record["gamma"][0]
    _update(learner, reward + gamma * value - record["last_value"][0])
    start, row = record["start"][0], record["row"][0]
    if action == last_action or traces.shape[0] > 0:  # else the update did not touch the weights of this action
        value = weighted_sum(learner.table, learner.weights[action], start, row, n) + bonus
    _remember(record, n, action, value)
    if traces.shape[0] > 0:
        low, high = record["trace_low"][0], record["trace_high"][0]
        decay_traces(traces, low, high, n, gamma * record["lambda"][0], record["trace_minimum"][0])
        replace_traces(learner.table, traces, low, high, start, row, n, action)


@kernel
def conclude(learner: Learner, reward: float) -> None:
    """Learn from the end of an episode, and forget the last action; a keeper that never acted learns nothing.

    ``reward``: cycles from the last decision to the end of the episode.
    """
    record = learner.record
    if has_acted(record) and record["learning"][0]:
        _update(learner, reward - record["last_value"][0])
    record["last_action"][0] = NO_ACTION
    record["episode_decisions"][0] = 0


@kernel
def count_episode(record: NDArray[np.void]) -> None:
    """Count a finished episode and move the schedules of step size and epsilon; does nothing unless learning."""
    if not record["learning"][0]:
        return
    record["episodes"][0] += 1
    record["step"][0] = max(record["step_final"][0], record["step"][0] * record["step_decay"][0])
    record["epsilon"][0] = max(record["epsilon_final"][0], record["epsilon"][0] * record["epsilon_decay"][0])


@kernel
def exploration(record: NDArray[np.void]) -> float:
    """Return the probability of an exploratory action now: epsilon, or 0 while not exploring."""
    return record["epsilon"][0] if record["exploring"][0] else 0.0


@kernel
def select_epsilon_greedily(record: NDArray[np.void], rng: NDArray[np.uint64]) -> int:
    """Select among the actions by the values of the state just observed."""
    return epsilon_greedy(rng, record["q"][0], record["n_actions"][0], exploration(record), NO_ACTION, 0.0)


@kernel
def _remember(record: NDArray[np.void], n_variables: int, action: int, value: float) -> None:
    start, row = record["start"][0], record["row"][0]
    last_start, last_row = record["last_start"][0], record["last_row"][0]
    for v in range(n_variables):
        last_start[v] = start[v]
        last_row[v] = row[v]
    record["last_action"][0] = action
    record["last_value"][0] = value
    record["episode_decisions"][0] += 1
    if record["learning"][0]:
        record["decisions"][0] += 1


@kernel
def _update(learner: Learner, delta: float) -> None:
    record = learner.record
    amount = record["step"][0] * delta
    n = int(learner.features["n_variables"][0])
    if learner.traces.shape[0] > 0:
        low, high = record["trace_low"][0], record["trace_high"][0]
        add_traces(learner.weights, learner.traces, low, high, n, amount)
        return
    last = learner.weights[record["last_action"][0]]
    add_features(learner.table, last, record["last_start"][0], record["last_row"][0], n, amount)
