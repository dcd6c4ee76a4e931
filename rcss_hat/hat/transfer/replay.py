"""Replay: start from a value function that the demonstrations have already taught (Smart and Kaelbling 2002).

Sarsa's own update runs over the demonstrated decisions before learning begins, as if the learner had taken them. The
HAT paper names this as the nearest earlier work; it uses the demonstrations themselves instead of a summary.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rcss_hat.hat.transfer.method import TransferMethod, check_count
from rcss_hat.hat.transfer.no_prior import select_no_prior
from rcss_hat.learning.sarsa import Learner, advance, begin, conclude, has_acted, observe
from rcss_hat.numeric.jit import kernel

if TYPE_CHECKING:
    from rcss_hat.hat.transfer.learners import Learners


@kernel
def replay_decisions(
    learner: Learner,
    states: NDArray[np.float64],
    actions: NDArray[np.int64],
    rewards: NDArray[np.float64],
    last: NDArray[np.bool_],
    passes: int,
) -> None:
    """Update a learner with recorded decisions (see `Decisions`), in their order, several times over.

    Neither episodes nor decisions count, and schedules do not move.
    """
    record = learner.record
    decisions, learning = record["decisions"][0], record["learning"][0]
    record["learning"][0] = 1
    for _ in range(passes):
        for i in range(states.shape[0]):
            observe(learner, states[i])
            if has_acted(record):
                advance(learner, rewards[i - 1], actions[i], 0.0)
            else:
                begin(learner, actions[i], 0.0)
            if last[i]:
                conclude(learner, rewards[i])
    record["decisions"][0] = decisions
    record["learning"][0] = learning


@dataclass(frozen=True, eq=False)
class Decisions:
    """Recorded decisions of one or more keepers, each keeper's episode in one piece.

    Attributes
    ----------
    states : ndarray of float64, shape (n, n_variables)
    actions : ndarray of int64, shape (n,)
    rewards : ndarray of float64, shape (n,)
        Cycles from the decision to the same keeper's next one, or to the end of the episode.
    last : ndarray of bool, shape (n,)
        True for the last decision of a keeper in an episode; so also at the very end.
    """

    states: NDArray[np.float64]
    actions: NDArray[np.int64]
    rewards: NDArray[np.float64]
    last: NDArray[np.bool_]

    @classmethod
    def of(cls, states: ArrayLike, actions: ArrayLike, rewards: ArrayLike, last: ArrayLike) -> Decisions:
        """Make decisions from lists or arrays after checking them.

        Raises
        ------
        ValueError
            When lengths differ, numbers are not finite, or the last decision is not marked as the last of its episode.
        """
        table = np.ascontiguousarray(states, dtype=np.float64)
        chosen = np.ascontiguousarray(actions, dtype=np.int64)
        cycles = np.ascontiguousarray(rewards, dtype=np.float64)
        ends = np.ascontiguousarray(last, dtype=np.bool_)
        n = chosen.size
        if table.ndim != 2 or table.shape[0] != n or cycles.shape != (n,) or ends.shape != (n,) or chosen.ndim != 1:
            raise ValueError(
                "decisions need states of shape (n, variables) and n actions, rewards and marks of the last, not "
                f"{table.shape}, {chosen.shape}, {cycles.shape} and {ends.shape}"
            )
        if not (np.isfinite(table).all() and np.isfinite(cycles).all()):
            raise ValueError("states and rewards of decisions must be finite")
        if n and not ends[-1]:
            raise ValueError("the last decision must be marked as the last of its episode")
        if n and chosen.min() < 0:
            raise ValueError(f"actions are numbered from 0, not {chosen.min()}")
        return cls(table, chosen, cycles, ends)


@dataclass(frozen=True, slots=True)
class Replay(TransferMethod):
    """Replay the demonstrated decisions into the value function, then learn without advice."""

    passes: int = 10
    """How often all demonstrations are replayed."""

    name: ClassVar[str] = "replay"
    needs_advice: ClassVar[bool] = False
    needs_decisions: ClassVar[bool] = True
    select = staticmethod(select_no_prior)

    def __post_init__(self) -> None:
        """Check the settings."""
        check_count("passes", self.passes)

    def prepare(self, learners: Learners, decisions: Decisions) -> None:
        """Teach every keeper the recorded decisions of all keepers."""
        learners.replay(decisions, self.passes)

    def describe(self) -> str:
        """Return one line for people."""
        return f"Replay: demonstrations replayed {self.passes} times into Q, then Sarsa alone"
