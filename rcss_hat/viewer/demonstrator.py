"""A person who demonstrates: decides by keys, and keeps or drops the episodes he played. No sockets or clocks."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.recorder import Recorder
from rcss_hat.keepaway.decision import Decision, action_name
from rcss_hat.keepaway.report import Episode
from rcss_hat.viewer.controls import HOLD, KeyChannel
from rcss_hat.viewer.frames import Frame
from rcss_hat.viewer.narrator import Insight

if TYPE_CHECKING:
    from rcss_hat.hat.demonstration_writer import DemonstrationWriter


IDLE_EPISODES = 3
"""After so many episodes in a row without a key, the person is asked whether he is there."""


@dataclass(slots=True)
class _Finished:
    """An episode that has ended and can still be dropped, until the next one ends."""

    episode: Episode
    idle: bool
    dropped: bool = False


class Demonstrator:
    """A person who plays the keepers on a stage, and what of it is recorded.

    An episode that has ended is written when the next one ends, or at `close`; until then it can be dropped. One in
    which the person did nothing at all is marked as idle; after some of them in a row he is asked whether he is there.

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
    away, looking : bool
        Whether nobody has the page open; whether somebody sees it, and no dialog covers it.
    stops : bool
        Whether the game can stand still; set by whoever runs it.
    asking : bool
        The person is asked whether he is there, and has not answered.
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
        self.away, self.looking, self.asking = False, True, False
        self.on_arrival: Callable[[], None] | None = None
        self.stops = False
        self.paused = False
        self.dropped = 0
        self._closed = False
        self._practised = 0
        self._recording = Recorder(recorder)
        self._last: _Finished | None = None
        self._drop_running = False
        self._spoiled = False  # the running episode was paused, or played with nobody there
        self._idle = 0  # episodes in a row
        self._signs = 0  # of life, when the running episode began
        self._commands = 0

    # -- towards the stage --------------------------------------------------------------------------------------------
    def answer(self, state: NDArray[np.float64], info: dict[str, Any]) -> int:
        """Decide: this is a `rcss_hat.hat.policy.Policy`."""
        self._spoiled |= self.standing
        return HOLD if self.paused or self.standing else self.keys.take(info["keeper"], info["cycle"], state.tolist())

    def decided(self, decision: Decision) -> None:
        """Take a decision that was taken."""
        self.insight.decided(decision)
        if not self._closed:
            self._recording.decided(decision)

    def ended(self, episodes: Sequence[Episode], cycle: int) -> None:
        """Take episodes that have ended."""
        for episode in episodes:
            self._episode_over(episode)

    def _episode_over(self, episode: Episode) -> None:
        if self.finished:
            return
        self._settle()
        idle = self._was_idle()
        if self._spoiled or self._drop_running:
            self.dropped += self._drop_running
            self._recording.take(episode)
        else:
            self._last = _Finished(episode, idle)
            self._idle = self._idle + 1 if idle else 0
            self.asking |= self._idle >= IDLE_EPISODES
        self._drop_running, self._spoiled = False, self.paused
        if self.episodes is not None and self.kept >= self.episodes:
            self.stop()

    # -- towards the picture ------------------------------------------------------------------------------------------
    def observe(self, frame: Frame) -> None:
        """Take the newest frame, and write into it what the person can do."""
        self.keys.observe(frame)

    # -- towards the person -------------------------------------------------------------------------------------------
    def person(self, there: bool) -> None:
        """Take note that the person has come, or gone."""
        self.away = not there
        if there and self.on_arrival is not None:
            self.on_arrival()

    def look(self, looking: bool) -> None:
        """Take note whether the person sees the match, and no dialog covers it."""
        self.looking = looking

    @property
    def standing(self) -> bool:
        """Whether the game is to stand still: the person is not there, does not look, or has not answered.

        Where it cannot, the keepers hold, and an episode in which they had to decide is not kept.
        """
        return self.away or not self.looking or self.asking

    def command(self, name: str) -> bool:
        """Do what the person asked for.

        Parameters
        ----------
        name : {"drop", "drop_last", "pause", "resume", "here", "stop"}
            ``drop`` drops the running episode, ``drop_last`` the one before; both take it back when repeated. ``here``
            answers the question whether anybody is there.

        Returns
        -------
        bool
            False for a name that is none of these, or when there is nothing to drop.
        """
        if self.finished:
            return False
        self._commands += 1
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
        elif name == "here":
            self.asking, self._idle = False, 0
        elif name == "stop":
            self.stop()
        else:
            self._commands -= 1
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
        self._recording.forget()

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
            "asking": self.asking,
            "standing": self.standing,
            "stops": self.stops,
        }

    def farewell(self) -> dict[str, Any]:
        """Return what a page shows at the end: how much was recorded, where it is, and what to do with it."""
        told: dict[str, Any] = {"kept": self.kept, "episodes": self.episodes, "file": None, "next": None}
        if self.recorder is not None and self.kept:
            file = shlex.quote(str(self.recorder.table))
            told |= {"file": str(self.recorder.table), "next": f"rcss-hat summarize {file} --out rules.json"}
        return told

    # -- inside -------------------------------------------------------------------------------------------------------
    def _was_idle(self) -> bool:
        """Tell whether the person did nothing since this was asked last."""
        before, self._signs = self._signs, self.keys.presses + self._commands
        return self._signs == before

    def _settle(self) -> None:
        """Write the episode before, or drop it for good."""
        last = self._last
        if last is None:
            return
        episode = last.episode
        if last.dropped:
            self.dropped += 1
            self._recording.take(episode)
        else:
            self._practised += self.recorder is None
            self._recording.keep(episode, last.idle)
        self._last = None  # not before: a full disk may have room again when the demonstration is closed
