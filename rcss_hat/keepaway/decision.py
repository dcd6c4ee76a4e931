"""How a keeper asks its policy, outside of the compiled loop."""

from __future__ import annotations

import math
import operator
from array import array
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rcss_hat.inputs import excerpt

Decide = Callable[[int, int, float, NDArray[np.float64]], int]
"""Policy of a keeper: (cycle, status, reward, state) -> action; see `rcss_hat.keepaway.agent.decide`."""
EpisodeEnd = Callable[[int, bool, float], None]
"""Told of an episode's end: (cycle, this keeper acted in it, cycles since its last decision)."""
KeeperPolicy = Callable[[int], tuple[Decide, EpisodeEnd | None]]
"""Policy of a team: keeper number from 0 -> (decide, episode_ended) of that keeper."""


@dataclass(frozen=True, slots=True)
class Decision:
    """What a keeper with the ball saw and chose.

    Attributes
    ----------
    cycle : int
        Server cycle.
    keeper : int
        Uniform number.
    state : tuple of float
        State variables as the keeper perceived them, metres and degrees.
    action : int
        0 = Hold, 1 = PASS1 and so on.
    by : str
        Who decided, where several take turns: `PERSON` or `LEARNER`; else empty.
    right : int or None
        The action that would have been right, as somebody said afterwards.
    """

    cycle: int
    keeper: int
    state: tuple[float, ...]
    action: int
    by: str = ""
    right: int | None = None


PERSON, LEARNER = "person", "learner"
"""Who decides where a person and a learner take turns."""


def action_name(action: int) -> str:
    """Name of a macro-action: ``Hold``, ``PASS1`` (to the nearer team mate), ``PASS2`` and so on."""
    return f"PASS{action}" if action else "Hold"


class PolicyError(ValueError):
    """A policy that cannot be had, and what could."""


class PolicyFailed(ValueError):
    """A policy in Python that was asked and did not answer with an action; one line that says what it did instead."""


class Believer(Protocol):
    """A player as somebody sees it who may know what it believes; a `rcss_hat.keepaway.session.KeepawayPlayer`."""

    unum: int
    cycle: int

    @property
    def beliefs(self) -> NDArray[np.void] | None:
        """Its record (AGENT, shape (1,)), which is not to be changed; None before it acted for the first time."""


class Onlooker(Protocol):
    """Who looks over the shoulders of a team's players. It is told before they go on, so that it can hold them up."""

    def ended(self, player: Believer, cycle: int, taken: bool) -> None:
        """Take that a player has heard of an episode's end, by the ball's being taken as it believes, or out.

        What it believes of everybody is still what it did before.
        """

    def acted(self, player: Believer) -> None:
        """Take that a player has decided what it does in this cycle; its commands are not sent yet."""


OnDecision = Callable[[Decision], object]
"""Told every decision of a team."""
OnFrame = Callable[[np.void], object]
"""Told what there is to see in a cycle."""


def overheard(policy: KeeperPolicy, on_decision: OnDecision) -> KeeperPolicy:
    """Return the same policy of a team, with every decision told to somebody."""

    def told(number: int) -> tuple[Decide, EpisodeEnd | None]:
        decide, ended = policy(number)

        def tell(cycle: int, status: int, reward: float, state: NDArray[np.float64]) -> int:
            action = decide(cycle, status, reward, state)
            on_decision(Decision(cycle, number + 1, tuple(state.tolist()), int(action)))
            return action

        return tell, ended

    told.hold_cycles = hold_cycles_of(policy)  # type: ignore[attr-defined]
    told.onlooker = onlooker_of(policy)  # type: ignore[attr-defined]
    return told


def hold_cycles_of(policy: KeeperPolicy) -> int:
    """Cycles a Hold of this policy lasts: its attribute ``hold_cycles``, 1 when it has none."""
    return int(getattr(policy, "hold_cycles", 1))


@dataclass(slots=True)
class DecisionTimes:
    """How long a policy in Python took to answer, on a server that does not wait for ever.

    Attributes
    ----------
    seconds : array of float
        Of every answer.
    """

    seconds: array[float] = field(default_factory=lambda: array("d"))

    @property
    def mean_s(self) -> float:
        """Mean of all answers; there must be one."""
        return math.fsum(self.seconds) / len(self.seconds)

    def late(self, patience_s: float) -> int:
        """Count the answers that took longer than a server waits."""
        return sum(seconds > patience_s for seconds in self.seconds)


def onlooker_of(policy: KeeperPolicy) -> Onlooker | None:
    """Who looks over the shoulders of this policy's players: its attribute ``onlooker``, if it has one."""
    return getattr(policy, "onlooker", None)


def legal_action(answer: object, keepers: int) -> int:
    """Return what a policy in Python answered as an action.

    Parameters
    ----------
    answer : object
        A whole number of any type: ``1``, ``2.0``, ``numpy.int64(0)``.
    keepers : int
        Of the task; so many actions there are.

    Raises
    ------
    PolicyFailed
        When it is anything else, a fraction or an array say, or none of the actions.
    """
    action = _whole(answer)
    if action is None or not 0 <= action < keepers:
        raise PolicyFailed(
            f"the policy returned {'action ' if action is not None else ''}{excerpt(answer)}; legal are 0 (Hold) to "
            f"{keepers - 1} (pass to the farthest team mate)"
        )
    return action


def legal_order(answer: object, keepers: int) -> int:
    """Return what a taker's policy in Python answered as a macro-action; see `legal_action`.

    Raises
    ------
    ValueError
        When it is no whole number, or none of the macro-actions.
    """
    order = _whole(answer)
    if order is None or not 0 <= order <= keepers:
        raise ValueError(
            f"the takers' policy returned {excerpt(answer)}; legal are 0 (hand-coded), 1 (go to the ball) and 2 to "
            f"{keepers} (block the keeper K2 to K{keepers})"
        )
    return order


def _whole(answer: object) -> int | None:
    if isinstance(answer, str | bytes) or (
        isinstance(answer, np.ndarray) and (answer.ndim or answer.dtype == np.bool_)
    ):
        return None
    try:
        return operator.index(answer)  # type: ignore[arg-type]
    except TypeError:
        pass
    try:
        number = float(answer)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        return None
    return int(number) if number.is_integer() else None
