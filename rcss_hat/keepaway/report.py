"""What a run of Keepaway produced: episodes, means, speed, and what went wrong."""

from __future__ import annotations

import json
import logging
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from dataclasses import field as default
from pathlib import Path

from rcss_hat.inputs import FileFormatError, excerpt, read_text
from rcss_hat.keepaway.decision import DecisionTimes
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.errors import one_line
from rcss_hat.protocol.keepaway_log import log_head, log_line

OUT, TAKEN, UNKNOWN = "o", "t", "?"
INTERRUPTED = "interrupted"
_NUMBER = re.compile(r"-?[0-9]{1,18}")
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Episode:
    """One finished episode.

    Attributes
    ----------
    number : int
        From 1.
    start, end : int
        Cycles (100 ms) of its begin and end.
    reason : {"o", "t", "?"}
        Ball out, ball taken, or not known to this side of the wire.
    final : tuple of float, optional
        State variables at the end, as the keeper believed them who decided last; where decisions were kept.
    """

    number: int
    start: int
    end: int
    reason: str
    final: tuple[float, ...] | None = default(default=None, compare=False, repr=False)

    @property
    def cycles(self) -> int:
        """Duration in cycles."""
        return self.end - self.start


def shifted(episodes: Iterable[Episode], numbers: int, cycles: int) -> list[Episode]:
    """Return episodes as they count where so many episodes and cycles came before."""
    return [Episode(e.number + numbers, e.start + cycles, e.end + cycles, e.reason, e.final) for e in episodes]


def read_kwy(path: Path) -> list[Episode]:
    """Read a Keepaway log of rcssserver (``.kwy``).

    Parameters
    ----------
    path : Path

    Returns
    -------
    list of Episode

    Raises
    ------
    FileFormatError
        When a line is not ``episode start end duration o|t``, separated by tabs. Only the last one may be cut off; it
        is left out then, and said in one line.
    """
    episodes = []
    lines = read_text(path, "Keepaway log").split("\n")
    for number, line in enumerate(lines, 1):
        if not line or line.startswith("#"):
            continue
        fields = line.split("\t")
        if len(fields) != 5 or fields[4] not in (OUT, TAKEN) or not all(map(_NUMBER.fullmatch, fields[:4])):
            if number == len(lines):  # without an end: its writer was killed
                _LOG.warning("%s is cut off; it is read up to its last whole line", path)
                break
            raise FileFormatError(
                f"{path}, line {number}: expected 'episode start end duration o|t', found {excerpt(line)}"
            )
        episodes.append(Episode(int(fields[0]), int(fields[1]), int(fields[2]), fields[4]))
    return episodes


def kwy_line(episode: Episode) -> str:
    """Write one episode as rcssserver's Keepaway log does."""
    return log_line(episode.number, episode.start, episode.end, episode.reason)


def mean_and_ci95(values: Sequence[float]) -> tuple[float, float]:
    """Mean and half width of its 95 % interval (1.96 standard errors); nan where there are too few values."""
    n = len(values)
    if n == 0:
        return math.nan, math.nan
    mean = math.fsum(values) / n
    if n == 1:
        return mean, math.nan
    variance = math.fsum((v - mean) ** 2 for v in values) / (n - 1)
    return mean, 1.96 * math.sqrt(variance / n)


@dataclass(slots=True)
class RunReport:
    """Outcome of a run; decides the exit code.

    Attributes
    ----------
    stage : str
        Where it was played: ``fake``, ``arena``, ``real`` or ``HOST:PORT``.
    keepers, takers : str
        Policies.
    size, field, vision : str, str, int
        Such as ``3v2``, ``20x20`` and 360.
    seed : int or None
    episodes : list of Episode
    cycles : int
        Simulated cycles, finished episodes or not.
    wall_s : float
    missed : int
        Cycles in which a player could not answer in time.
    failure : str or None
        What ended the run early; None: it ran to its end.
    profile, speed : str
        Whose physics (``19.0``, ``11.1`` or ``other (...)``), and how fast: empty until a server or arena has told.
    referee : {"server", "trainer"}
    taken_over : tuple of str
        Settings that nobody asked for and that are the server's.
    ends_judged_by : {"players", "referee"}
        Who says whether the ball was out or taken when an episode ended. A server does not tell players; they judge by
        where they believe the ball, and are wrong in about one of ten ends.
    decision_ms, slowest_decision_ms : float or None
        What a policy in Python took to answer over UDP, on average and at most; None: no such policy was asked.
    late_decisions, patience_ms : int, float or None
        How many of its answers took longer than the server waits for one: a cycle, in synch mode more.
    interrupted : bool
        Whether somebody stopped it.
    unheard : int
        How many episodes ended without a word to the players; those around are left out.
    server_seed : str or None
        Which seed a server that was started for the run printed.

    Examples
    --------
    >>> import rcss_hat
    >>> report = rcss_hat.play("hold", episodes=20, seed=1)
    >>> report.size, report.stage, len(report.episodes), len(report.durations_s)
    ('3v2', 'arena', 20, 20)
    """

    stage: str
    keepers: str
    takers: str
    size: str
    field: str
    vision: int
    seed: int | None = None
    episodes: list[Episode] = default(default_factory=list)
    cycles: int = 0
    wall_s: float = 0.0
    missed: int = 0
    failure: str | None = None
    profile: str = ""
    speed: str = ""
    referee: str = "server"
    taken_over: tuple[str, ...] = ()
    ends_judged_by: str = "players"
    decision_ms: float | None = None
    slowest_decision_ms: float | None = None
    late_decisions: int = 0
    patience_ms: float | None = None
    interrupted: bool = False
    unheard: int = 0
    server_seed: str | None = None

    @classmethod
    def of(
        cls, stage: str, keepers: str, task: Task, seed: int | None, takers: str = "hand", referee: str = "server"
    ) -> RunReport:
        """Return the empty report of a run that is about to begin."""
        return cls(stage, keepers, takers, task.size, task.field, task.vision, seed, referee=referee)

    def told(self, task: Task, physics: str, speed: str) -> None:
        """Take what is really played: the task, whose physics, and how fast."""
        asked = {"field": self.field, "vision": self.vision}
        self.size, self.field, self.vision = task.size, task.field, task.vision
        self.profile, self.speed = physics, speed
        self.taken_over = tuple(name for name, value in asked.items() if value != getattr(task, name))

    def refereed(self, by_trainer: bool) -> None:
        """Take who ended and started the episodes."""
        self.referee = "trainer" if by_trainer else "server"

    def played(self, episodes: Iterable[Episode], cycles: int, wall_s: float, missed: int = 0) -> None:
        """Take what was played, to its end or not; ``wall_s`` counts play, not what came before it."""
        self.episodes, self.cycles, self.wall_s, self.missed = list(episodes), cycles, wall_s, missed

    def decided(self, times: DecisionTimes, patience_s: float) -> None:
        """Take how long a policy in Python took to decide, and how long the server waited."""
        if times.seconds:
            self.decision_ms = round(1000.0 * times.mean_s, 4)
            self.slowest_decision_ms = round(1000.0 * max(times.seconds), 4)
            self.late_decisions, self.patience_ms = times.late(patience_s), round(1000.0 * patience_s, 4)

    def end_early(self, why: object) -> None:
        """Say what ended the run before its end; the first reason stays."""
        self.failure = self.failure or str(why)
        self.interrupted = self.interrupted or why == INTERRUPTED

    def not_counted(self, ends: int) -> None:
        """Say that so many episodes ended without a word to the players; that they were stopped is no excuse."""
        self.unheard = ends
        what = "1 end of an episode was" if ends == 1 else f"{ends} ends of episodes were"
        why = f"{what} not heard by any player (a bad network?); the episodes around are left out"
        self.failure = why if self.failure in (None, INTERRUPTED) else f"{self.failure}; {why}"

    def stopped_on_purpose(self) -> None:
        """Take it back when all that ended the run was that it was told to stop, and that was its end."""
        self.interrupted = False
        if self.failure == INTERRUPTED:
            self.failure = None

    def kwy_text(self) -> str:
        """Return what rcssserver's Keepaway log would hold of it."""
        keepers, takers = (int(n) for n in self.size.split("v"))
        length, width = (float(side) for side in self.field.split("x"))
        return log_head(keepers, takers, length, width) + "".join(map(kwy_line, self.episodes))

    @property
    def durations_s(self) -> list[float]:
        """Episode durations in simulated seconds."""
        return [episode.cycles / 10.0 for episode in self.episodes]

    @property
    def mean_s(self) -> float:
        """Mean duration of the episodes in simulated seconds; nan without any."""
        return mean_and_ci95(self.durations_s)[0]

    @property
    def exit_code(self) -> int:
        """0 when the run came to its end, else 1."""
        return 0 if self.failure is None else 1

    def summary(self) -> dict[str, object]:
        """Return the figures of the ``--json`` output."""
        mean, ci95 = mean_and_ci95(self.durations_s)
        settings = asdict(self)
        del settings["episodes"]
        return {
            "episodes": len(self.episodes),
            "mean_s": _number(mean),
            "ci95_s": _number(ci95),
            "out": sum(e.reason == OUT for e in self.episodes),
            "taken": sum(e.reason == TAKEN for e in self.episodes),
            "cycles": self.cycles,
            "wall_s": round(self.wall_s, 3),
            "cycles_per_s": round(self.cycles / self.wall_s, 1) if self.wall_s > 0 else None,
            **{k: v for k, v in settings.items() if k not in ("cycles", "wall_s")},
        }

    def to_json(self) -> str:
        """Return one JSON object on one line."""
        return json.dumps(self.summary())

    def to_text(self) -> str:
        """Return the report for people."""
        s = self.summary()
        lines = [
            f"{self.size} on {self.field} m, vision {self.vision}, {self.stage}: "
            f"keepers {self.keepers}, takers {self.takers}" + (f", seed {self.seed}" if self.seed is not None else "")
        ]
        if self.profile:
            lines.append(f"  physics of {self.profile}; {self.speed}; referee: {self.referee}")
        if self.taken_over:
            lines.append(f"  the server's, not asked for: {', '.join(self.taken_over)}")
        if self.episodes:
            ci95 = f" +/- {s['ci95_s']:.2f}" if s["ci95_s"] is not None else ""
            judged = " (as the players saw it)" if self.ends_judged_by == "players" else ""
            ends = f"{s['out']} out, {s['taken']} taken away{judged}"
            lines.append(f"  {s['episodes']} episodes, mean {s['mean_s']:.2f}{ci95} s; {ends}")
        else:
            lines.append("  no episode was finished")
        speed = f", {s['cycles_per_s']:.0f} cycles/s" if s["cycles_per_s"] is not None else ""
        lines.append(f"  {self.cycles} cycles in {self.wall_s:.1f} s{speed}; {self.missed} missed")
        if self.decision_ms is not None:
            lines.append(f"  a decision took {self.decision_ms:.2f} ms, at most {self.slowest_decision_ms:.2f} ms")
        if self.late_decisions:
            decisions = "1 decision" if self.late_decisions == 1 else f"{self.late_decisions} decisions"
            lines.append(
                f"  {decisions} took longer than the {self.patience_ms:.0f} ms that the server "
                "gives them: those cycles were played without; a slower server or a faster policy is needed"
            )
        if self.failure:
            lines.append(f"  ended early: {one_line(self.failure)}")
        return "\n".join(lines)


def _number(value: float) -> float | None:
    return None if math.isnan(value) else round(value, 4)
