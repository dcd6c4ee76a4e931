"""What decides for a team of keepers: one kernel for every kind of policy, over UDP and in the arena.

Keeper k has its own weights, traces, learner record and random stream (row k of each); rules, features and the
transfer method are shared.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.decision_list import RULE_ROW, deciding_row
from rcss_hat.hat.transfer.kernels import decide_first, decide_step, finish_episode
from rcss_hat.hat.transfer.learners import Learners
from rcss_hat.hat.transfer.record import METHOD, NO_ADVICE
from rcss_hat.keepaway.policies import hand, random_action
from rcss_hat.learning.features import FEATURES
from rcss_hat.learning.sarsa import LEARNER
from rcss_hat.numeric import rng
from rcss_hat.numeric.jit import njit

HOLD, RANDOM, HAND, RULES, LEARNED, EXTERNAL = range(6)
"""Kinds of policies; EXTERNAL: decided by someone outside, in Python."""
KIND_NAMES = {"hold": HOLD, "random": RANDOM, "hand": HAND}


@dataclass
class Brains:
    """The records of a team's policy.

    Attributes
    ----------
    kind : int
    rules : ndarray of RULE_ROW
        Decision list; one row that answers Hold where there is none.
    features, table
        Approximator.
    weights, traces : ndarray of float64, shapes (keepers, rows, n_features), (keepers, rows or 0, n_features or 0)
    learners : ndarray of LEARNER, shape (keepers,)
    method : METHOD, shape (1,)
    streams : ndarray of uint64, shape (keepers, 4)
    has_rules : ndarray of uint8, shape (1,)
        Whether ``rules`` is advice for a learner.
    """

    kind: int
    rules: NDArray[np.void]
    features: NDArray[np.void]
    table: NDArray[np.float64]
    weights: NDArray[np.float64]
    traces: NDArray[np.float64]
    learners: NDArray[np.void]
    method: NDArray[np.void]
    streams: NDArray[np.uint64]
    has_rules: NDArray[np.uint8]


def fixed_brains(kind: int, keepers: int, seed: int, rules: NDArray[np.void] | None = None) -> Brains:
    """Make the records of a policy that does not learn.

    Parameters
    ----------
    kind : int
        HOLD, RANDOM, HAND, RULES or EXTERNAL.
    keepers, seed : int
    rules : ndarray of RULE_ROW, optional
        For RULES.
    """
    holds = np.zeros(1, dtype=RULE_ROW)
    holds["feature"], holds["skip"], holds["confidence"] = -1, -1, 1.0
    return Brains(
        kind,
        holds if rules is None else rules,
        np.zeros(1, dtype=FEATURES),
        np.zeros((1, 1)),
        np.zeros((keepers, 1, 1)),
        np.zeros((keepers, 0, 0)),
        np.zeros(keepers, dtype=LEARNER),
        np.zeros(1, dtype=METHOD),
        policy_streams(seed, keepers),
        np.array([rules is not None], dtype=np.uint8),
    )


def learned_brains(learners: Learners, rules: NDArray[np.void] | None = None) -> Brains:
    """Let learners decide; the records are theirs, so that they learn by playing.

    Parameters
    ----------
    learners : Learners
    rules : ndarray of RULE_ROW, optional
        The advice D of a transfer method.
    """
    brains = fixed_brains(LEARNED, learners.n_keepers, learners.seed, rules)
    brains.features, brains.table = learners.approximator.record, learners.approximator.table
    brains.weights, brains.traces = learners.weights, learners.traces
    brains.learners, brains.streams, brains.method = learners.records, learners.streams, learners.method_record
    return brains


def policy_streams(seed: int, keepers: int) -> NDArray[np.uint64]:
    """Random streams of the keepers' policies, shape (keepers, 4)."""
    return np.stack([rng.stream(seed, rng.POLICY, k) for k in range(keepers)])


@njit
def choose(
    kind: int,
    n_keepers: int,
    n_takers: int,
    rules: NDArray[np.void],
    has_rules: NDArray[np.uint8],
    features: NDArray[np.void],
    table: NDArray[np.float64],
    weights: NDArray[np.float64],
    traces: NDArray[np.float64],
    learner: NDArray[np.void],
    method: NDArray[np.void],
    stream: NDArray[np.uint64],
    first: bool,
    reward: float,
    state: NDArray[np.float64],
) -> int:
    """Take one keeper's decision; a learner also learns from the reward of its last one.

    Parameters
    ----------
    kind : int
        Not EXTERNAL.
    first : bool
        First decision of this keeper in the episode: there is no reward yet.
    reward : float
        Cycles since this keeper's last decision.
    state : ndarray of float64, shape (n_variables,)

    Returns
    -------
    int
        0: Hold, k: pass to the k-th nearest team mate.
    """
    if kind == HAND:
        return hand(state, n_keepers, n_takers)
    if kind == RANDOM:
        return random_action(stream, n_keepers)
    if kind == RULES:
        return rules["action"][deciding_row(rules, state)]
    if kind == LEARNED:
        advice, confidence = NO_ADVICE, 0.0
        if has_rules[0]:
            row = deciding_row(rules, state)
            advice, confidence = rules["action"][row], rules["confidence"][row]
        if first:
            return decide_first(learner, stream, features, table, weights, traces, method, state, advice, confidence)
        return decide_step(learner, stream, features, table, weights, traces, method, reward, state, advice, confidence)
    return 0


@njit
def finish(
    kind: int,
    features: NDArray[np.void],
    table: NDArray[np.float64],
    weights: NDArray[np.float64],
    traces: NDArray[np.float64],
    learner: NDArray[np.void],
    reward: float,
) -> None:
    """Tell one keeper's policy that an episode ended; ``reward``: cycles since its last decision."""
    if kind == LEARNED:
        finish_episode(learner, features, table, weights, traces, reward)
