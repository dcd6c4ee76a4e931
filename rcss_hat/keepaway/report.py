"""What a run of Keepaway produced: episodes, means, speed, and what went wrong."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from dataclasses import field as default
from pathlib import Path

OUT, TAKEN, UNKNOWN = "o", "t", "?"


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
    """

    number: int
    start: int
    end: int
    reason: str

    @property
    def cycles(self) -> int:
        """Duration in cycles."""
        return self.end - self.start


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
    ValueError
        When a line is not ``episode start end duration o|t``, separated by tabs.
    """
    episodes = []
    for number, line in enumerate(path.read_text().splitlines(), 1):
        if not line or line.startswith("#"):
            continue
        fields = line.split("\t")
        if len(fields) != 5 or fields[4] not in (OUT, TAKEN) or not all(f.lstrip("-").isdigit() for f in fields[:4]):
            raise ValueError(f"{path}, line {number}: expected 'episode start end duration o|t', found {line!r}")
        episodes.append(Episode(int(fields[0]), int(fields[1]), int(fields[2]), fields[4]))
    return episodes


def kwy_text(episodes: Iterable[Episode], keepers: int, takers: int, length: float, width: float) -> str:
    """Write episodes as rcssserver's Keepaway log does."""
    header = (
        f"# Keepers: {keepers}\n# Takers:  {takers}\n# Region:  {length:g} x {width:g}\n#\n# Description of Fields:\n"
        "# 1) Episode number\n# 2) Start time in simulator steps (100ms)\n# 3) End time in simulator steps (100ms)\n"
        "# 4) Duration in simulator steps (100ms)\n# 5) (o)ut of bounds / (t)aken away\n#\n"
    )
    return header + "".join(kwy_line(episode) for episode in episodes)


def kwy_line(episode: Episode) -> str:
    """Write one episode as rcssserver's Keepaway log does."""
    e = episode
    return f"{e.number}\t{e.start}\t{e.end}\t{e.cycles}\t{e.reason}\n"


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

    @property
    def durations_s(self) -> list[float]:
        """Episode durations in simulated seconds."""
        return [episode.cycles / 10.0 for episode in self.episodes]

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
        if self.episodes:
            ci95 = f" +/- {s['ci95_s']:.2f}" if s["ci95_s"] is not None else ""
            lines.append(
                f"  {s['episodes']} episodes, mean {s['mean_s']:.2f}{ci95} s; {s['out']} out, {s['taken']} taken away"
            )
        else:
            lines.append("  no episode was finished")
        speed = f", {s['cycles_per_s']:.0f} cycles/s" if s["cycles_per_s"] is not None else ""
        lines.append(f"  {self.cycles} cycles in {self.wall_s:.1f} s{speed}; {self.missed} missed")
        if self.failure:
            lines.append(f"  ended early: {self.failure}")
        return "\n".join(lines)


def _number(value: float) -> float | None:
    return None if math.isnan(value) else round(value, 4)
