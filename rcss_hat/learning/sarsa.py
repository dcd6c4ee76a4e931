"""SMDP Sarsa(lambda) with linear features, as the UT Austin players 0.6 learn (LinearSarsaAgent.cc).

One keeper is one learner. Between decisions it remembers its last action, the active features of the state in which it
took it, and the value Q(s, a) it had. The reward of a decision is the number of cycles until this keeper's next
decision or the end of the episode; with gamma = 1 time enters nowhere else. At a decision in state s':

1. `observe` computes Q(s', .) with the weights as they are;
2. someone selects a' from these values (`epsilon_greedy` here, a transfer method in `rcss_hat.hat.transfer`);
3. `advance` moves the weights of (s, a) by ``step * (r + gamma Q(s', a') - Q(s, a))`` times the feature values, and
   remembers (s', a') with the value it has under the *new* weights.

So selection precedes the update. Weights belong to what was selected. The kernels take, always in this order, the
learner's record, its random stream, the approximator's record and table, and the learner's weights and traces; with
lambda = 0 there are no traces (an array of shape (0, 0)) and they cost nothing.
"""

from __future__ import annotations

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


@kernel
def observe(
    learner: NDArray[np.void],
    features: NDArray[np.void],
    table: NDArray[np.float64],
    weights: NDArray[np.float64],
    state: NDArray[np.float64],
) -> None:
    """Look at a state: find its features and compute the value of every action, into ``learner["q"]``.

    Parameters
    ----------
    learner : LEARNER, shape (1,)
    features : FEATURES, shape (1,)
    table : ndarray of float64, shape (rows + 1, active)
    weights : ndarray of float64, shape (actions, n_features)
    state : ndarray of float64, shape (n_variables,)
    """
    start, row, q = learner["start"][0], learner["row"][0], learner["q"][0]
    n = int(features["n_variables"][0])
    for v in range(n):
        start[v], row[v] = locate(features, v, state[v])
    for a in range(weights.shape[0]):
        q[a] = weighted_sum(table, weights[a], start, row, n)


@kernel
def has_acted(learner: NDArray[np.void]) -> bool:
    """Tell whether this keeper has taken a decision in this episode."""
    return learner["last_action"][0] != NO_ACTION


@kernel
def begin(
    learner: NDArray[np.void],
    features: NDArray[np.void],
    table: NDArray[np.float64],
    traces: NDArray[np.float64],
    action: int,
    bonus: float,
) -> None:
    """Take the first action of an episode in the state just observed.

    Parameters
    ----------
    learner, features, table
        As in `observe`.
    traces : ndarray of float64, shape (actions, n_features), or (0, 0) when lambda is 0
    action : int
        Row of the weights that gets the credit.
    bonus : float
        What a transfer method adds to the value of this action, 0 otherwise.
    """
    learner["episode_decisions"][0] = 0
    _remember(learner, int(features["n_variables"][0]), action, learner["q"][0, action] + bonus)
    if traces.shape[0] > 0 and learner["learning"][0]:
        n, low, high = int(features["n_variables"][0]), learner["trace_low"][0], learner["trace_high"][0]
        clear_traces(traces, low, high, n)
        replace_traces(table, traces, low, high, learner["start"][0], learner["row"][0], n, action)


@kernel
def advance(
    learner: NDArray[np.void],
    features: NDArray[np.void],
    table: NDArray[np.float64],
    weights: NDArray[np.float64],
    traces: NDArray[np.float64],
    reward: float,
    action: int,
    bonus: float,
) -> None:
    """Learn from the reward of the last action, and take the next one in the state just observed.

    Parameters
    ----------
    learner, features, table, weights, traces, action, bonus
        As in `observe` and `begin`.
    reward : float
        Cycles since the last decision.
    """
    value = learner["q"][0, action] + bonus
    n = int(features["n_variables"][0])
    if not learner["learning"][0]:
        _remember(learner, n, action, value)
        return
    last_action = learner["last_action"][0]
    gamma = learner["gamma"][0]
    _update(learner, features, table, weights, traces, reward + gamma * value - learner["last_value"][0])
    start, row = learner["start"][0], learner["row"][0]
    if action == last_action or traces.shape[0] > 0:  # else the update did not touch the weights of this action
        value = weighted_sum(table, weights[action], start, row, n) + bonus
    _remember(learner, n, action, value)
    if traces.shape[0] > 0:
        low, high = learner["trace_low"][0], learner["trace_high"][0]
        decay_traces(traces, low, high, n, gamma * learner["lambda"][0], learner["trace_minimum"][0])
        replace_traces(table, traces, low, high, start, row, n, action)


@kernel
def conclude(
    learner: NDArray[np.void],
    features: NDArray[np.void],
    table: NDArray[np.float64],
    weights: NDArray[np.float64],
    traces: NDArray[np.float64],
    reward: float,
) -> None:
    """Learn from the end of an episode, and forget the last action; a keeper that never acted learns nothing.

    Parameters
    ----------
    learner, features, table, weights, traces
        As in `observe` and `begin`.
    reward : float
        Cycles from the last decision to the end of the episode.
    """
    if has_acted(learner) and learner["learning"][0]:
        _update(learner, features, table, weights, traces, reward - learner["last_value"][0])
    learner["last_action"][0] = NO_ACTION
    learner["episode_decisions"][0] = 0


@kernel
def count_episode(learner: NDArray[np.void]) -> None:
    """Count a finished episode and move the schedules of step size and epsilon; does nothing unless learning."""
    if not learner["learning"][0]:
        return
    learner["episodes"][0] += 1
    learner["step"][0] = max(learner["step_final"][0], learner["step"][0] * learner["step_decay"][0])
    learner["epsilon"][0] = max(learner["epsilon_final"][0], learner["epsilon"][0] * learner["epsilon_decay"][0])


@kernel
def exploration(learner: NDArray[np.void]) -> float:
    """Return the probability of an exploratory action now: epsilon, or 0 while not exploring."""
    return learner["epsilon"][0] if learner["exploring"][0] else 0.0


@kernel
def start(
    learner: NDArray[np.void],
    rng: NDArray[np.uint64],
    features: NDArray[np.void],
    table: NDArray[np.float64],
    weights: NDArray[np.float64],
    traces: NDArray[np.float64],
    state: NDArray[np.float64],
) -> int:
    """Decide for the first time in an episode, epsilon-greedily; returns the action."""
    observe(learner, features, table, weights, state)
    action = epsilon_greedy(rng, learner["q"][0], learner["n_actions"][0], exploration(learner), NO_ACTION, 0.0)
    begin(learner, features, table, traces, action, 0.0)
    return action


@kernel
def step(
    learner: NDArray[np.void],
    rng: NDArray[np.uint64],
    features: NDArray[np.void],
    table: NDArray[np.float64],
    weights: NDArray[np.float64],
    traces: NDArray[np.float64],
    reward: float,
    state: NDArray[np.float64],
) -> int:
    """Decide again, epsilon-greedily, and learn from the ``reward`` (cycles) of the last action; returns the action."""
    observe(learner, features, table, weights, state)
    action = epsilon_greedy(rng, learner["q"][0], learner["n_actions"][0], exploration(learner), NO_ACTION, 0.0)
    advance(learner, features, table, weights, traces, reward, action, 0.0)
    return action


@kernel
def end(
    learner: NDArray[np.void],
    features: NDArray[np.void],
    table: NDArray[np.float64],
    weights: NDArray[np.float64],
    traces: NDArray[np.float64],
    reward: float,
) -> None:
    """End an episode: learn from its last ``reward`` (cycles) when this keeper acted, and count it in any case."""
    conclude(learner, features, table, weights, traces, reward)
    count_episode(learner)


@kernel
def _remember(learner: NDArray[np.void], n_variables: int, action: int, value: float) -> None:
    start, row = learner["start"][0], learner["row"][0]
    last_start, last_row = learner["last_start"][0], learner["last_row"][0]
    for v in range(n_variables):
        last_start[v] = start[v]
        last_row[v] = row[v]
    learner["last_action"][0] = action
    learner["last_value"][0] = value
    learner["episode_decisions"][0] += 1
    if learner["learning"][0]:
        learner["decisions"][0] += 1


@kernel
def _update(
    learner: NDArray[np.void],
    features: NDArray[np.void],
    table: NDArray[np.float64],
    weights: NDArray[np.float64],
    traces: NDArray[np.float64],
    delta: float,
) -> None:
    amount = learner["step"][0] * delta
    n = int(features["n_variables"][0])
    if traces.shape[0] > 0:
        add_traces(weights, traces, learner["trace_low"][0], learner["trace_high"][0], n, amount)
        return
    last = weights[learner["last_action"][0]]
    add_features(table, last, learner["last_start"][0], learner["last_row"][0], n, amount)
