"""What decides for a team of keepers: one kernel for every kind of policy, over UDP and in the arena."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.rule_rows import RULE_ROW, deciding_row
from rcss_hat.hat.transfer.handle import NOBODY, choose_learned, finish_learned, handle_of
from rcss_hat.hat.transfer.learners import Learners
from rcss_hat.keepaway.policies import hand, random_action
from rcss_hat.numeric import rng
from rcss_hat.numeric.jit import kernel

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
    streams : ndarray of uint64, shape (keepers, 4)
        Random streams of keepers that do not learn.
    learners : ndarray of int64
        Where those are that do, see `rcss_hat.hat.transfer.handle`.
    """

    kind: int
    keepers: int
    takers: int
    rules: NDArray[np.void]
    streams: NDArray[np.uint64]
    learners: NDArray[np.int64]


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
        policy_streams(seed, keepers),
        NOBODY,
    )


def learned_brains(learners: Learners, rules: NDArray[np.void] | None = None) -> Brains:
    """Let learners decide; they learn by playing.

    Parameters
    ----------
    learners : Learners
    rules : ndarray of RULE_ROW, optional
        The advice D of a transfer method.
    """
    fixed = fixed_brains(LEARNED, learners.n_keepers, learners.n_takers, learners.seed)
    return fixed._replace(learners=handle_of(learners, rules))


def policy_streams(seed: int, keepers: int) -> NDArray[np.uint64]:
    """Random streams of the keepers' policies, shape (keepers, 4)."""
    return np.stack([rng.stream(seed, rng.POLICY, k) for k in range(keepers)])


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
        return choose_learned(brains.learners, k, first, reward, state)
    return 0


@kernel
def finish(brains: Brains, k: int, reward: float) -> None:
    """Tell one keeper's policy that an episode ended; ``reward``: cycles since its last decision."""
    if brains.kind == LEARNED:
        finish_learned(brains.learners, k, reward)
