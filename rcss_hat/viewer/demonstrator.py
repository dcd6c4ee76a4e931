"""A person who demonstrates: decides by keys, and keeps or drops the episodes he played. No sockets or clocks."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.recorder import Recorder
from rcss_hat.keepaway.decision import LEARNER, PERSON, Decision, action_name
from rcss_hat.keepaway.report import Episode
from rcss_hat.viewer.controls import HOLD, KeyChannel
from rcss_hat.viewer.frames import Frame
from rcss_hat.viewer.narrator import Insight
from rcss_hat.viewer.protocol import COMMANDS
from rcss_hat.viewer.replay import Film
from rcss_hat.viewer.shelf import Shelf

if TYPE_CHECKING:
    from rcss_hat.hat.demonstration_writer import DemonstrationWriter
    from rcss_hat.viewer.turns import Companion


IDLE_S = 8.0
"""Seconds in which decisions were the person's and no key was pressed, after which he is asked whether he is there."""
_CYCLES_PER_S = 10.0


@dataclass(frozen=True)
class Terms:
    """How a person demonstrates.

    Attributes
    ----------
    episodes : int or None
        Finish when so many are kept; None: go on until stopped.
    start : bool
        The game stands still until the person says that he is ready.
    at_once : bool
        Episodes are written as soon as they have ended, and cannot be dropped.
    speed : float
        Times real time: how long a decision is, for idleness.
    correct : bool
        After each episode the person looks at it again, and says what would have been right.
    commands : tuple of str
        What the person may do beside playing; of `rcss_hat.viewer.protocol.COMMANDS`.
    """

    episodes: int | None = None
    start: bool = False
    at_once: bool = False
    speed: float = 1.0
    correct: bool = False
    commands: tuple[str, ...] = COMMANDS


class Demonstrator:
    """A person who plays the keepers on a stage, and what of it is recorded.

    An episode that has ended is written when the next one ends, or at `close`; until then it can be dropped. One in
    which the person did nothing at all is marked as idle. Who presses nothing for `IDLE_S` seconds in which decisions
    were his is asked whether he is there; idle episodes are written only when he goes on.

    Parameters
    ----------
    keys : KeyChannel
    recorder : DemonstrationWriter, optional
        Where episodes go; without one the person only practises.
    terms : Terms or int, optional
        An int is how many episodes are to be kept.
    learner : Companion, optional
        Plays until the person takes over, and when he gives back. With a learner, and where episodes are corrected, a
        recorder's demonstration must be a marked one.

    Attributes
    ----------
    insight : Insight
        What keepers saw and chose; for the source of the frames.
    started : bool
        The person has said that he is ready.
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
    replaying : bool
        An episode is looked at again.
    by : str
        Whose turn it is: `PERSON` or `LEARNER`.
    on_arrival : callable or None
        Called whenever the person comes, if he has started; and when he starts.
    on_kept : callable or None
        Told every episode that counts, when it ends.
    on_replay : callable or None
        Told what is to be looked at again (`rcss_hat.viewer.replay`), and None when that is over.
    """

    def __init__(
        self,
        keys: KeyChannel,
        recorder: DemonstrationWriter | None = None,
        terms: Terms | int | None = None,
        learner: Companion | None = None,
    ) -> None:
        self.keys, self.recorder, self.learner = keys, recorder, learner
        self.terms = terms if isinstance(terms, Terms) else Terms(terms)
        self.insight = Insight()
        self.started = not self.terms.start
        self.finished = False
        self.on_finished: Callable[[], None] | None = None
        self.away, self.looking, self.asking, self.replaying = False, True, False, False
        self.by = PERSON if learner is None else LEARNER
        self.on_arrival: Callable[[], None] | None = None
        self.on_kept: Callable[[Episode], None] | None = None
        self.on_replay: Callable[[Mapping[str, Any] | None], None] | None = None
        self.stops = False
        self.paused = False
        self._dropped = 0
        self._closed = False
        self._before = 0 if recorder is None else len(recorder.entries)
        self._recording = Recorder(recorder)
        self._shelf = Shelf(self._recording, self.terms.at_once and not self.terms.correct)
        self._film: Film | None = Film() if self.terms.correct else None
        self._looked_at: dict[int, dict[str, Any]] = {}  # decisions of the episode looked at again, by cycle
        self._deciders: dict[tuple[int, int], str] = {}  # cycle and keeper -> who decided
        self._drop_running = False
        self._spoiled = False  # the running episode was paused, or played with nobody there
        self._signs_before = 0  # of life, when the running episode began
        self._signs_seen = 0  # when the last decision was taken
        self._idle_decisions = self._own_decisions = 0
        self._commands = 0

    # -- towards the stage --------------------------------------------------------------------------------------------
    def answer(self, state: NDArray[np.float64], info: dict[str, Any]) -> int:
        """Decide: this is a `rcss_hat.hat.policy.Policy`."""
        self._spoiled |= self.standing
        if self.paused or self.standing:
            return HOLD
        if self.learner is not None:
            own = self.learner.answer(state, info)
            self._deciders[info["cycle"], info["keeper"]] = self.by
            if self.by == LEARNER:
                return own
        self._own_decisions += 1
        self._watch_idleness()
        return self.keys.take(info["keeper"], info["cycle"], state.tolist())

    def _watch_idleness(self) -> None:
        """Count decisions without a key; after too many the person is asked."""
        idle = self._signs == self._signs_seen
        self._idle_decisions = self._idle_decisions + 1 if idle else 0
        self._signs_seen = self._signs
        if self._idle_decisions >= IDLE_S * _CYCLES_PER_S * self.terms.speed:
            self.asking = True

    @property
    def _signs(self) -> int:
        """How often the person showed that he is there."""
        return self.keys.presses + self._commands

    def decided(self, decision: Decision) -> None:
        """Take a decision that was taken."""
        self.insight.decided(decision)
        if self.learner is not None or self.terms.correct:
            decision = replace(decision, by=self._deciders.get((decision.cycle, decision.keeper), PERSON))
        if not self._closed:
            self._recording.decided(decision)

    def ended(self, episodes: Sequence[Episode], cycle: int) -> None:
        """Take episodes that have ended."""
        for episode in episodes:
            self._episode_over(episode)

    def _episode_over(self, episode: Episode) -> None:
        if self.finished:
            return
        idle, self._signs_before = self._signs == self._signs_before, self._signs
        idle &= self.learner is None or self._own_decisions > 0
        self._own_decisions = 0
        self._deciders = {key: by for key, by in self._deciders.items() if key[0] >= episode.end}
        if self._spoiled or self._drop_running:
            self._dropped += self._drop_running
            self._shelf.settle(self._shelf.idle)
            self._recording.take(episode)
        else:
            self._look_again(episode)
            self._shelf.put(episode, idle)
            if self.on_kept is not None:
                self.on_kept(episode)
        self._drop_running, self._spoiled = False, self.paused
        # Whoever went away before the end has not come to it.
        self.asking |= self._enough and self._shelf.idle > 1
        self._stop_when_done()

    def _stop_when_done(self) -> None:
        if self._enough and not self.asking and not self.replaying:
            self.stop()

    def _look_again(self, episode: Episode) -> None:
        """Show an episode that has just ended again, where it is to be corrected."""
        if self._film is None or self.on_replay is None:
            return
        shown = self._film.cut(episode, self._recording.of(episode), self.keys.actions)
        self._looked_at = {d["cycle"]: d for d in shown["decisions"]}
        if self._looked_at and shown["frames"]:
            self.replaying = True
            self.on_replay(shown)

    @property
    def _enough(self) -> bool:
        return self.episodes is not None and self.kept >= self.episodes

    # -- towards the picture ------------------------------------------------------------------------------------------
    def observe(self, frame: Frame) -> None:
        """Take the newest frame, and write into it what the person can do."""
        self.keys.observe(frame)
        if self._film is not None and not self.replaying:
            self._film.take(frame)

    # -- towards the person -------------------------------------------------------------------------------------------
    def person(self, there: bool) -> None:
        """Take note that the person has come, or gone."""
        self.away = not there
        self._arrived()

    def _arrived(self) -> None:
        if not self.away and self.started and self.on_arrival is not None:
            self.on_arrival()

    def look(self, looking: bool) -> None:
        """Take note whether the person sees the match, and no dialog covers it."""
        self.looking = looking

    @property
    def standing(self) -> bool:
        """Whether the game is to stand still: the person is not there or ready, looks elsewhere, or has not answered.

        Where it cannot, the keepers hold, and an episode in which they had to decide is not kept.
        """
        return self.away or not self.started or not self.looking or self.asking or self.replaying

    def press(self, action: int, at: float | None = None) -> bool:
        """Take a key for an action, and the turn with it; see `KeyChannel.press`."""
        return self._took_turn(self.keys.press(action, at))

    def press_mate(self, mate: str, at: float | None = None) -> bool:
        """Take a key for a team mate, and the turn with it; see `KeyChannel.press_mate`."""
        return self._took_turn(self.keys.press_mate(mate, at))

    def _took_turn(self, pressed: bool) -> bool:
        if pressed:
            self.by = PERSON
        return pressed

    def correct(self, cycle: int, action: int | None) -> bool:
        """Take what would have been right in the episode looked at again; None: what was played."""
        decision = self._looked_at.get(cycle) if self.replaying else None
        if decision is None or action not in (None, *self.keys.actions):
            return False
        decision["right"] = action
        self._commands += 1
        return self._recording.correct(cycle, decision["keeper"], action)

    def command(self, name: str) -> bool:
        """Do what the person asked for.

        Parameters
        ----------
        name : str
            One of the terms' commands. ``start`` begins, ``here`` answers the question whether anybody is there,
            ``drop`` drops the running episode, ``drop_last`` the one before; both take it back when repeated.

        Returns
        -------
        bool
            False for a name that is none of these, or when it makes no sense now.
        """
        if self.finished or name not in self.terms.commands or not self._obey(name):
            return False
        self._commands += 1
        return True

    def _obey(self, name: str) -> bool:
        if name == "start":
            self.started = True
            self._arrived()
        elif name == "drop":
            if self.terms.at_once:
                return False
            self._drop_running = not self._drop_running
        elif name == "drop_last":
            if self._shelf.last is None:
                return False
            self._shelf.last.dropped = not self._shelf.last.dropped
        elif name == "pause":
            self.paused = self._spoiled = True
            self.keys.press(HOLD)
        elif name == "resume":
            self.paused = False
        elif name == "here":
            self.asking, self._idle_decisions = False, 0
            self._stop_when_done()
        elif name in ("take", "give") and self.learner is not None:
            self.by = PERSON if name == "take" else LEARNER
            self._idle_decisions = 0
            self.keys.release()
        elif name == "seen" and self.replaying:
            self._seen()
        elif name == "stop":
            self.stop()
        else:
            return False
        return True

    def _seen(self) -> None:
        """Go on after an episode was looked at again."""
        self.replaying, self._looked_at = False, {}
        if self.on_replay is not None:
            self.on_replay(None)
        if self.terms.at_once:
            self._shelf.settle(self._shelf.idle)
        self._stop_when_done()

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
        if self.asking:
            self._shelf.leave_idle()
        self._shelf.settle()
        self._recording.forget()

    @property
    def episodes(self) -> int | None:
        """How many are to be kept."""
        return self.terms.episodes

    @property
    def kept(self) -> int:
        """Episodes recorded so far, those of a resumed file included."""
        return self._before + self._shelf.written + self._shelf.waiting

    @property
    def dropped(self) -> int:
        """Episodes that were dropped for good."""
        return self._dropped + self._shelf.dropped

    def status(self) -> dict[str, Any]:
        """Return what a page shows of the recording."""
        last = self._shelf.last
        return {
            "recording": self.recorder is not None,
            "actions": [{"action": a, "name": action_name(a)} for a in self.keys.actions],
            "episodes": self.episodes,
            "kept": self.kept,
            "dropped": self.dropped + (last is not None and last.dropped),
            "commands": list(self.terms.commands),
            "started": self.started,
            "paused": self.paused,
            "spoiled": self._spoiled,
            "dropping": self._drop_running,
            "last": None if last is None else last.episode.number,
            "last_dropped": last is not None and last.dropped,
            "finished": self.finished,
            "asking": self.asking,
            "standing": self.standing,
            "stops": self.stops,
            "replaying": self.replaying,
            "turns": self.learner is not None,
            "by": self.by,
        }

    def farewell(self) -> dict[str, Any]:
        """Return what a page shows at the end: how much was recorded, where it is, and what to do with it."""
        told: dict[str, Any] = {"kept": self.kept, "episodes": self.episodes, "file": None, "next": None}
        if self.recorder is not None and self.kept:
            file = shlex.quote(str(self.recorder.table))
            told |= {"file": str(self.recorder.table), "next": f"rcss-hat summarize {file} --out rules.json"}
        return told
