"""A match step by step: play goes on to the next decision, or to the end of an episode, and waits there.

That is all that environments know of where a match is played. `open_steps` opens one anywhere: in the arena the
compiled loop comes back at every decision; on a server a thread plays the match, and stands still while it waits.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.envs.spaces import Observations
from rcss_hat.hat.brains import EXTERNAL, fixed_brains
from rcss_hat.hat.policy import TeamPolicy
from rcss_hat.keepaway.decision import OnFrame
from rcss_hat.keepaway.report import Episode
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.messages import Show
from rcss_hat.simulation.world import World
from rcss_hat.stage.place import ARENA, Place

DECISION, REACHED, ENDED, GONE = range(4)
"""Where a match came back: somebody has to decide; a cycle was reached; an episode has ended; there is no match."""
HOLD, NO_CHOICE = 0, -1
NEVER = 2**31 - 1
State = NDArray[np.float64]
TakerPolicy = Callable[[State, dict[str, Any]], int]
"""A policy of the takers: (state variables, info) -> macro-action; see `rcss_hat.keepaway.taker`."""


@dataclass(frozen=True, slots=True)
class Setting:
    """What is played.

    Attributes
    ----------
    place : Place
    task : Task
    observations : Observations
    hold_cycles : int
        Cycles from a keeper's Hold to his next decision.
    max_cycles : int or None
        After so many an episode is cut off.
    every_cycle : bool
        Come back in every cycle, not only at decisions.
    every_view : bool
        With ``every_cycle``: keep what everybody believes in every cycle, see `Steps.views`.
    taker_cycles : int or None
        Takers are asked, too, once in so many cycles. None: they are hand-coded.
    takers : callable, optional
        Answers for the takers, so that `Steps.go_on` comes back for keepers only.
    truth : bool
        Whether somebody wants to know where everybody is, see `Steps.truth`.
    on_frame : callable, optional
        Told what there is to see in every cycle; in the arena only.
    on_show : callable, optional
        Told what a monitor was shown, where play has come back: the frame, number and start of the running episode; on
        servers only.
    """

    place: Place
    task: Task
    observations: Observations
    hold_cycles: int = 1
    max_cycles: int | None = None
    every_cycle: bool = False
    every_view: bool = False
    taker_cycles: int | None = None
    takers: TakerPolicy | None = None
    truth: bool = False
    on_frame: OnFrame | None = None
    on_show: Callable[[Show, int, int], object] | None = None

    @property
    def asks_takers(self) -> bool:
        """Whether somebody decides for the takers."""
        return self.taker_cycles is not None

    def policy(self, function: Callable[..., int]) -> TeamPolicy:
        """Return the keepers' policy that a stage plays with."""
        keepers, takers = self.task.keepers, self.task.takers
        brains = fixed_brains(EXTERNAL, keepers, takers, 0)
        return TeamPolicy("environment", brains, keepers, takers, self.hold_cycles, function)

    def cap(self, start: int) -> int:
        """Return the cycle in which an episode that began in another is cut off."""
        return NEVER if self.max_cycles is None else start + self.max_cycles


class Steps(ABC):
    """One match after the other, step by step; not shared between threads.

    Attributes
    ----------
    cycle, player, status, number, start : int
        Where play stands: the cycle; who has to decide, keepers (from 0) before takers; the kind of decision (see
        `rcss_hat.keepaway.agent.decide`); the running episode's number and the cycle it began in.
    seen : ndarray of float32, shape (variables,)
        With DECISION of a keeper: what it observes. Overwritten by the next step.
    state : ndarray of float64
        With DECISION: state variables of who decides. With REACHED and ENDED: those of the keeper that decided last,
        as it believes them to be in the last cycle of the episode in which anything was perceived; a server puts
        everybody elsewhere in the cycle of the end itself. Overwritten by the next step.
    perceived : bool
        With REACHED and ENDED: whether that keeper, or else another, knew where everybody is, so that ``state`` holds.
    last : int
        The keeper that decided last, from 0.
    views : list of (ndarray of float64 or None)
        With REACHED and ENDED, and always with ``every_view``: state variables of everybody, keepers before takers, as
        they believe them to be at the end of the last cycle they have acted in; None: somebody is unknown.
    episode : Episode
        With ENDED: what has ended.
    missed : int
        Cycles in which some player could not answer in time.
    failure : str
        With GONE: why.
    on_match : callable or None
        Told in every cycle what a monitor would be shown: the match's record (MATCH) as it was when the step was
        done, and its `World`. For matches that begin later; in the arena only.
    """

    on_match: Callable[[NDArray[np.void], World], object] | None = None

    def __init__(self, setting: Setting) -> None:
        self.setting = setting
        self.cycle = self.player = self.status = self.number = self.start = self.last = self.missed = 0
        variables = len(setting.observations.names)
        self.seen: NDArray[np.float32] = np.zeros(variables, dtype=np.float32)
        self.state: State = np.zeros(variables)
        self.perceived = True
        self.views: list[State | None] = [None] * (setting.task.keepers + setting.task.takers)
        self.episode = Episode(0, 0, 0, "?")
        self.failure = ""

    @abstractmethod
    def begin(self, seed: int) -> None:
        """Begin a new match; play starts with `go_on`."""

    @abstractmethod
    def go_on(self, choice: int = NO_CHOICE) -> int:
        """Play on.

        Parameters
        ----------
        choice : int
            What is done, when somebody has to decide.

        Returns
        -------
        int
            DECISION, REACHED (with ``every_cycle`` each cycle, else ``max_cycles``), ENDED or GONE.
        """

    @abstractmethod
    def discard(self) -> int:
        """Play on to the end of the running episode, keepers holding and takers by their own mind: ENDED or GONE."""

    def place(self, positions: Mapping[str, Any]) -> None:
        """Put everybody somewhere else, before the first cycle of an episode.

        Raises
        ------
        ValueError
            For a place that cannot be, and on servers, where only the referee moves players.
        """
        raise ValueError(f"players can be placed in the arena, not on {self.setting.place}")

    @abstractmethod
    def truth(self) -> dict[str, NDArray[np.float64]]:
        """Return where everybody is: ``ball``, ``keepers`` and ``takers``, rows of x, y (m), vx, vy (m per cycle).

        On servers a monitor is shown it, to four decimals; only with `Setting.truth`.
        """
        raise NotImplementedError

    @abstractmethod
    def close(self) -> None:
        """End the match, and whatever plays it."""


def open_steps(setting: Setting) -> Steps:
    """Return matches of this setting.

    Raises
    ------
    ValueError
        When the place has no such matches.
    """
    # Imported here, for the arena's loop takes long to import and servers do without, and the other way round.
    if setting.place.name == ARENA:
        from rcss_hat.envs.stepping_arena import ArenaSteps

        return ArenaSteps(setting)
    from rcss_hat.envs.stepping_server import ServerSteps

    return ServerSteps(setting)
