"""Where a participant is on his way: follows from his plan and his journal's events; no files, clocks or sockets."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from rcss_hat.studies.journal import Event
from rcss_hat.studies.parts import EndStep
from rcss_hat.studies.plan import Planned


@dataclass(slots=True)
class Played:
    """What was played in a step: matches begun, and the games that are over."""

    matches: int = 0
    games: list[Event] = field(default_factory=list)
    extra: int = 0

    @property
    def seconds(self) -> list[float]:
        """Durations of the games, seconds of the game."""
        return [(game["end"] - game["start"]) / 10.0 for game in self.games]


class Progress:
    """Where a participant is.

    Parameters
    ----------
    plan : tuple of Planned
    events : iterable of dict
        What happened so far.

    Attributes
    ----------
    position : int
        Of the step that is not done yet; the last one, of kind end, is never done.
    begun : bool
        Whether he has seen that step.
    stopped : str or None
        Who ended his way early.
    language : str or None
        What he chose.
    answers : dict
        By step and question.
    played : dict of str to Played
    """

    def __init__(self, plan: tuple[Planned, ...], events: Iterable[Event] = ()) -> None:
        self.plan = plan
        self.position = 0
        self.begun = False
        self.stopped: str | None = None
        self.language: str | None = None
        self.answers: dict[str, dict[str, Any]] = {}
        self.played = {planned.name: Played() for planned in plan if planned.game is not None}
        for event in events:
            self.take(event)

    @property
    def current(self) -> Planned:
        """The step he is at; the last one when he was stopped."""
        return self.plan[-1] if self.stopped else self.plan[self.position]

    @property
    def finished(self) -> bool:
        """Whether he has come to the end, or was stopped."""
        return isinstance(self.current.step, EndStep)

    def wanted(self, name: str) -> int:
        """Games of a step, with those that were added."""
        planned = next(p for p in self.plan if p.name == name)
        assert planned.game is not None
        return planned.game.episodes + self.played[name].extra

    def take(self, event: Event) -> None:
        """Take an event. One of a step that is not the current one, noted twice for instance, changes nothing."""
        kind, step = event["event"], event.get("step")
        if kind == "begun" and step == self.current.name:
            self.begun = True
        elif kind == "done" and step == self.current.name and not self.finished:
            self.position, self.begun = self.position + 1, False
        elif kind == "answers":
            self.answers[event["step"]] = event["answers"]
        elif kind == "language":
            self.language = event["value"]
        elif kind == "stopped":
            self.stopped = event["by"]
        elif step in self.played:
            self._play(kind, event, self.played[step])

    def _play(self, kind: str, event: Event, played: Played) -> None:
        if kind == "match":
            played.matches = event["match"]
        elif kind == "game" and event["game"] == len(played.games) + 1:
            played.games.append(event)
        elif kind == "extended":
            played.extra += event["games"]
