"""What decides for a team of keepers: one kernel for every kind of policy, over UDP and in the arena.

Keeper k has its own weights, traces, learner record and random stream (row k of each); rules, features and the
transfer method are shared.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.rule_rows import RULE_ROW, deciding_row
from rcss_hat.hat.transfer.kernels import decide_first, decide_step, finish_episode
from rcss_hat.hat.transfer.learners import Learners
from rcss_hat.hat.transfer.method import METHOD, NO_ADVICE
from rcss_hat.keepaway.policies import hand, random_action
from rcss_hat.learning.features import FEATURES
from rcss_hat.learning.sarsa import LEARNER, Learner
from rcss_hat.numeric import rng
from rcss_hat.numeric.jit import inlined, kernel

HOLD, RANDOM, HAND, RULES, LEARNED, EXTERNAL = range(6)
"""Kinds of policies; EXTERNAL: decided by someone outside, in Python."""
KIND_NAMES = {"hold": HOLD, "random": RANDOM, "hand": HAND}


class Brains(NamedTuple):
    """The records of a team's policy, as kernels take them.

    Attributes
    ----------
    kind : int
    keepers, takers : int
    rules : ndarray of RULE_ROW
        Decision list; one row that answers Hold where there is none.
    has_rules : ndarray of uint8, shape (1,)
        Whether ``rules`` is advice for a learner.
    method : METHOD, shape (1,)
    records : LEARNER, shape (keepers,)
    streams : ndarray of uint64, shape (keepers, 4)
    features, table
        Approximator.
    weights, traces : ndarray of float64, shapes (keepers, rows, n_features), (keepers, rows or 0, n_features or 0)
    """

    kind: int
    keepers: int
    takers: int
    rules: NDArray[np.void]
    has_rules: NDArray[np.uint8]
    method: NDArray[np.void]
    records: NDArray[np.void]
    streams: NDArray[np.uint64]
    features: NDArray[np.void]
    table: NDArray[np.float64]
    weights: NDArray[np.float64]
    traces: NDArray[np.float64]


def fixed_brains(kind: int, keepers: int, takers: int, seed: int, rules: NDArray[np.void] | None = None) -> Brains:
    """Make the records of a policy that does not learn.

    Parameters
    ----------
    kind : int
        HOLD, RANDOM, HAND, RULES or EXTERNAL.
    keepers, takers, seed : int
    rules : ndarray of RULE_ROW, optional
        For RULES.
    """
    holds = np.zeros(1, dtype=RULE_ROW)
    holds["feature"], holds["skip"], holds["confidence"] = -1, -1, 1.0
    return Brains(
        kind,
        keepers,
        takers,
        holds if rules is None else rules,
        np.array([rules is not None], dtype=np.uint8),
        np.zeros(1, dtype=METHOD),
        np.zeros(keepers, dtype=LEARNER),
        policy_streams(seed, keepers),
        np.zeros(1, dtype=FEATURES),
        np.zeros((1, 1)),
        np.zeros((keepers, 1, 1)),
        np.zeros((keepers, 0, 0)),
    )


def learned_brains(learners: Learners, rules: NDArray[np.void] | None = None) -> Brains:
    """Let learners decide; the records are theirs, so that they learn by playing.

    Parameters
    ----------
    learners : Learners
    rules : ndarray of RULE_ROW, optional
        The advice D of a transfer method.
    """
    return fixed_brains(LEARNED, learners.n_keepers, learners.n_takers, learners.seed, rules)._replace(
        method=learners.method_record,
        records=learners.records,
        streams=learners.streams,
        features=learners.approximator.record,
        table=learners.approximator.table,
        weights=learners.weights,
        traces=learners.traces,
    )


def policy_streams(seed: int, keepers: int) -> NDArray[np.uint64]:
    """Random streams of the keepers' policies, shape (keepers, 4)."""
    return np.stack([rng.stream(seed, rng.POLICY, k) for k in range(keepers)])


@inlined
def learner_of(brains: Brains, k: int) -> Learner:
    """Return keeper k (from 0) as the kernels of learning take it.

    For kernels only: nobody counts references to the arrays that are returned.
    """
    return Learner(
        brains.records[k : k + 1],
        brains.streams[k],
        brains.features,
        brains.table,
        brains.weights[k],
        brains.traces[k],
    )


@kernel
def choose(brains: Brains, k: int, first: bool, reward: float, state: NDArray[np.float64]) -> int:
    """Take one keeper's decision; a learner also learns from the reward of its last one.

    Parameters
    ----------
    brains : Brains
        Not of kind EXTERNAL.
    k : int
        The keeper, from 0.
    first : bool
        First decision of this keeper in the episode: there is no reward yet.
    reward : float
        Cycles since this keeper's last decision.
    state : ndarray of float64, shape (n_variables,)

    Returns
    -------
    int
        0: Hold, a: pass to the a-th nearest team mate.
    """
    kind, rules = brains.kind, brains.rules
    if kind == HAND:
        return hand(state, brains.keepers, brains.takers)
    if kind == RANDOM:
        return random_action(brains.streams[k], brains.keepers)
    if kind == RULES:
        return rules["action"][deciding_row(rules, state)]
    if kind == LEARNED:
        advice, confidence = NO_ADVICE, 0.0
        if brains.has_rules[0]:
            row = deciding_row(rules, state)
            advice, confidence = rules["action"][row], rules["confidence"][row]
        if first:
            return decide_first(learner_of(brains, k), brains.method, state, advice, confidence)
        return decide_step(learner_of(brains, k), brains.method, reward, state, advice, confidence)
    return 0


@kernel
def finish(brains: Brains, k: int, reward: float) -> None:
    """Tell one keeper's policy that an episode ended; ``reward``: cycles since its last decision."""
    if brains.kind == LEARNED:
        finish_episode(learner_of(brains, k), reward)
