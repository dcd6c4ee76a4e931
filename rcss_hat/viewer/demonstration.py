"""A demonstration in the making: decisions of a person, sorted into episodes, kept or dropped. No sockets or clocks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.keepaway.report import Episode
from rcss_hat.viewer.controls import HOLD, KeyChannel
from rcss_hat.viewer.frames import Frame, action_name
from rcss_hat.viewer.narrator import Insight

if TYPE_CHECKING:
    from rcss_hat.hat.demonstration_writer import DemonstrationWriter
    from rcss_hat.keepaway.decision import Decide


@dataclass(frozen=True, slots=True)
class _Decision:
    cycle: int
    keeper: int
    state: NDArray[np.float64]
    action: int


@dataclass(slots=True)
class _Finished:
    """An episode that has ended and can still be dropped, until the next one ends."""

    episode: Episode
    dropped: bool = False


class Demonstration:
    """Lets a person play the keepers, and records what he does.

    An episode that has ended is written when the next one ends, or at `close`; until then it can be dropped.

    Parameters
    ----------
    keys : KeyChannel
    recorder : DemonstrationWriter, optional
        Where episodes go; without one the person only practises.
    episodes : int or None
        Finish when the file holds so many; None: go on until stopped.

    Attributes
    ----------
    insight : Insight
        What keepers saw and chose; for the source of the frames.
    finished : bool
        No more is recorded.
    on_finished : callable or None
        Called once when the last episode was recorded, or the person stopped.
    away : bool
        The person is not there: keepers hold, and an episode in which they had to decide is not kept.
    on_arrival : callable or None
        Called whenever the person comes.
    """

    def __init__(
        self, keys: KeyChannel, recorder: DemonstrationWriter | None = None, episodes: int | None = None
    ) -> None:
        self.keys, self.recorder, self.episodes = keys, recorder, episodes
        self.insight = Insight()
        self.finished = False
        self.on_finished: Callable[[], None] | None = None
        self.away = False
        self.on_arrival: Callable[[], None] | None = None
        self.paused = False
        self.dropped = 0
        self._closed = False
        self._practised = 0
        self._decisions: list[_Decision] = []
        self._last: _Finished | None = None
        self._drop_running = False
        self._spoiled = False  # the running episode was paused, or played with nobody there

    # -- towards the players ------------------------------------------------------------------------------------------
    def __call__(self, number: int) -> tuple[Decide, None]:
        """Return the policy of one keeper (from 0): this is a `rcss_hat.keepaway.decision.KeeperPolicy`."""

        def decide(cycle: int, status: int, reward: float, state: NDArray[np.float64]) -> int:
            return self.decide(number + 1, cycle, status, reward, state)

        return decide, None

    def decide(self, keeper: int, cycle: int, status: int, reward: float, state: NDArray[np.float64]) -> int:
        """Decide for a keeper (uniform number) who has the ball, and keep it in mind."""
        seen: list[float] = state.tolist()
        self._spoiled |= self.away
        action = HOLD if self.paused or self.away else self.keys.take(keeper, cycle, seen)
        self.insight.decided(keeper, cycle, seen, action)
        if not self._closed:
            self._decisions.append(_Decision(cycle, keeper, np.array(state, dtype=np.float64), action))
        return action

    # -- towards the picture ------------------------------------------------------------------------------------------
    def observe(self, frame: Frame) -> None:
        """Take the newest frame, and write into it what the person can do."""
        self.keys.observe(frame)

    def episode_over(self, episode: Episode) -> None:
        """Take an episode that ended."""
        if self.finished:
            return
        self._settle()
        if self._spoiled or self._drop_running:
            self.dropped += self._drop_running
            self._forget_before(episode.end)
        else:
            self._last = _Finished(episode)
        self._drop_running, self._spoiled = False, self.paused
        if self.episodes is not None and self.kept >= self.episodes:
            self.stop()

    # -- towards the person -------------------------------------------------------------------------------------------
    def person(self, there: bool) -> None:
        """Take note that the person has come, or gone."""
        self.away = not there
        if there and self.on_arrival is not None:
            self.on_arrival()

    def command(self, name: str) -> bool:
        """Do what the person asked for.

        Parameters
        ----------
        name : {"drop", "drop_last", "pause", "resume", "stop"}
            ``drop`` drops the running episode, ``drop_last`` the one before; both take it back when repeated.

        Returns
        -------
        bool
            False for a name that is none of these, or when there is nothing to drop.
        """
        if self.finished:
            return False
        if name == "drop":
            self._drop_running = not self._drop_running
        elif name == "drop_last":
            if self._last is None:
                return False
            self._last.dropped = not self._last.dropped
        elif name == "pause":
            self.paused = self._spoiled = True
            self.keys.press(HOLD)
        elif name == "resume":
            self.paused = False
        elif name == "stop":
            self.stop()
        else:
            return False
        return True

    def stop(self) -> None:
        """Record no more."""
        if self.finished:
            return
        self.finished = True
        if self.on_finished is not None:
            self.on_finished()

    def close(self) -> None:
        """Write what is still to be written."""
        self.finished = self._closed = True
        self._settle()
        self._decisions = []

    @property
    def kept(self) -> int:
        """Episodes recorded so far, those of a resumed file included."""
        written = self._practised if self.recorder is None else len(self.recorder.entries)
        return written + (self._last is not None and not self._last.dropped)

    def status(self) -> dict[str, Any]:
        """Return what a page shows of the recording."""
        return {
            "recording": self.recorder is not None,
            "actions": [{"action": a, "name": action_name(a)} for a in self.keys.actions],
            "episodes": self.episodes,
            "kept": self.kept,
            "dropped": self.dropped + (self._last is not None and self._last.dropped),
            "paused": self.paused,
            "spoiled": self._spoiled,
            "dropping": self._drop_running,
            "last": None if self._last is None else self._last.episode.number,
            "last_dropped": self._last is not None and self._last.dropped,
            "finished": self.finished,
        }

    # -- inside -------------------------------------------------------------------------------------------------------
    def _settle(self) -> None:
        """Write the episode before, or drop it for good."""
        last, self._last = self._last, None
        if last is None:
            return
        episode = last.episode
        if last.dropped:
            self.dropped += 1
        elif self.recorder is None:
            self._practised += 1
        else:
            mine = [d for d in self._decisions if episode.start <= d.cycle < episode.end]
            for d in sorted(mine, key=lambda d: (d.cycle, d.keeper)):
                self.recorder.add(d.cycle, d.keeper, d.state, d.action)
            self.recorder.end_episode(episode.start, episode.end, episode.reason)
        self._forget_before(episode.end)

    def _forget_before(self, cycle: int) -> None:
        self._decisions = [d for d in self._decisions if d.cycle >= cycle]
