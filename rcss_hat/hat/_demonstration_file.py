"""The file format of demonstrations: a CSV table of decisions, and a JSON header beside it with everything else.

The header lists the finished episodes with their number of decisions; the table holds these decisions in the same
order. Lines after them belong to an episode whose end was never recorded, and are not read.

Where a person and a learner took turns, or somebody said afterwards what would have been right, the table has two more
columns: ``by`` (``person``, ``learner``, or empty: the teacher) and ``right`` (an action, or empty).
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.inputs import FileFormatError, excerpt, item, parse_json, read_text, whole
from rcss_hat.keepaway.decision import LEARNER, PERSON, Decision, action_name
from rcss_hat.keepaway.report import OUT, TAKEN, UNKNOWN, Episode
from rcss_hat.keepaway.state import n_state_variables, state_names
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.params import Value

FORMAT = "rcss-hat demonstration"
VERSION = 1
REASONS = {OUT: "out", TAKEN: "taken", UNKNOWN: "unknown"}
"""How an episode ended: letter of the Keepaway log, and word in the header."""
MAX_CYCLE = 2**31 - 1
MAX_VALUE = 1e6
"""Metres or degrees, far beyond any state variable; learning adds and squares them."""
MARKS = ("by", "right")
"""Columns of a table that is marked."""
DECIDERS = ("", PERSON, LEARNER)


@dataclass(frozen=True, slots=True)
class DemonstrationInfo:
    """What was demonstrated, by whom and where.

    Attributes
    ----------
    teacher : str
    stage : str
        Where it was played: ``real``, ``fake``, ``arena`` or ``HOST:PORT``.
    task : Task
    server : mapping
        Server parameters in force, as far as known.
    seed : int or None
    date : str or None
        ISO 8601.
    notes : str
    marked : bool
        The table says who took each decision, and what would have been right.
    """

    teacher: str
    stage: str
    task: Task = field(default_factory=Task)
    server: Mapping[str, Value] = field(default_factory=dict)
    seed: int | None = None
    date: str | None = None
    notes: str = ""
    marked: bool = False

    @property
    def n_variables(self) -> int:
        """Number of state variables."""
        return n_state_variables(self.task.keepers, self.task.takers)

    @property
    def variable_names(self) -> tuple[str, ...]:
        """Meaning of the state variables."""
        return tuple(state_names(self.task.keepers, self.task.takers))


@dataclass(frozen=True, slots=True)
class Entry:
    """A finished episode in the header: who demonstrated it, and how many decisions the table holds.

    ``idle``: a person pressed no key in it, so that it may show that nobody was there.
    """

    episode: Episode
    teacher: str
    decisions: int
    idle: bool = False


def file_pair(path: str | Path) -> tuple[Path, Path]:
    """Return table and header, whichever of the two was named.

    Raises
    ------
    FileFormatError
        When the name ends neither in ``.csv`` nor in ``.json``.
    """
    path = Path(path)
    if path.suffix not in (".csv", ".json"):
        raise FileFormatError(f"{path}: the name of a demonstration ends in .csv (its header in .json)")
    return path.with_suffix(".csv"), path.with_suffix(".json")


def check_there(path: str | Path) -> None:
    """Check that both files of a demonstration are there.

    Raises
    ------
    FileFormatError
        Naming the file that was named.
    """
    named, (table, header) = Path(path), file_pair(path)
    there = [file for file in (table, header) if file.exists()]
    if not there:
        raise FileFormatError(f"{named}: there is no such demonstration")
    if len(there) == 1:
        missing, what = (header, "header") if there[0] == table else (table, "table")
        raise FileFormatError(f"{named}: its {what} {missing.name} is not there; a demonstration is two files")


def columns(info: DemonstrationInfo) -> list[str]:
    """Columns of the table."""
    return [
        "episode",
        "cycle",
        "keeper",
        *(f"s{k}" for k in range(info.n_variables)),
        "action",
        *MARKS[: 2 * info.marked],
    ]


def check_decision(info: DemonstrationInfo, decision: Decision) -> None:
    """Check one decision against the task.

    Raises
    ------
    ValueError
        Naming what would be right.
    """
    task, keeper, state = info.task, decision.keeper, decision.state
    if not 1 <= keeper <= task.keepers:
        raise ValueError(f"keeper must be a uniform number 1 to {task.keepers} in {task.size}, not {keeper}")
    if len(state) != info.n_variables:
        raise ValueError(f"a state of {task.size} has {info.n_variables} variables, not {len(state)}")
    for index, value in enumerate(state):
        if not math.isfinite(value):
            raise ValueError(
                f"s{index} must be a finite number, not {value}; states with unknown players are no decisions"
            )
        if abs(value) > MAX_VALUE:
            raise ValueError(f"s{index} must be metres or degrees, not {value}")
    for name, action in (("action", decision.action), ("right", decision.right)):
        if action is not None and not 0 <= action < task.keepers:
            names = ", ".join(f"{k} {action_name(k)}" for k in range(task.keepers))
            raise ValueError(f"{name} must be one of {names} in {task.size}, not {action}")
    if decision.by not in DECIDERS:
        raise ValueError(f"by must be {PERSON}, {LEARNER} or empty, not {excerpt(decision.by)}")
    if not info.marked and (decision.by or decision.right is not None):
        raise ValueError("this demonstration has no columns for who decided and what would have been right")


def check_final(info: DemonstrationInfo, episode: Episode) -> None:
    """Check that the state at the end of an episode, where there is one, is that of the task.

    Raises
    ------
    FileFormatError
    """
    if episode.final is not None and len(episode.final) != info.n_variables:
        raise FileFormatError(
            f"the final state of episode {episode.number} has {len(episode.final)} variables; in {info.task.size} it "
            f"must be {info.n_variables}"
        )


def check_episode(episode: Episode, cycles: Sequence[int] | NDArray[np.int64]) -> None:
    """Check that an episode's times fit together.

    Raises
    ------
    ValueError
        Naming what would be right.
    """
    if episode.reason not in REASONS:
        raise ValueError(
            f"the end of an episode must be one of {', '.join(map(repr, REASONS))}, not {episode.reason!r}"
        )
    if episode.end < episode.start:
        raise ValueError(f"episode {episode.number} must end at cycle {episode.start} or later, not at {episode.end}")
    before = episode.start
    for cycle in cycles:
        if not before <= cycle <= episode.end:
            raise ValueError(
                f"decisions of episode {episode.number} must be in order and within its cycles {episode.start} to "
                f"{episode.end}; found cycle {cycle} after {before}"
            )
        before = int(cycle)


# --- header -----------------------------------------------------------------------------------------------------


def header_text(info: DemonstrationInfo, entries: Iterable[Entry], table: str) -> str:
    """Write the header; ``table`` is the name of the CSV file."""
    task = info.task
    meaning = {
        "episode": "number of the episode",
        "cycle": "server cycle of the decision (100 ms)",
        "keeper": "uniform number of the keeper with the ball",
        **{f"s{k}": name for k, name in enumerate(info.variable_names)},
        "action": ", ".join(f"{k} = {action_name(k)}" for k in range(task.keepers)),
    }
    if info.marked:
        meaning |= {
            "by": f"who decided: {PERSON}, {LEARNER}, or empty: the teacher",
            "right": "the action that would have been right, as the teacher said afterwards; empty: nothing was said",
        }
    content = {
        "format": FORMAT,
        "version": VERSION,
        "table": table,
        "teacher": info.teacher,
        "stage": info.stage,
        "date": info.date,
        "seed": info.seed,
        "notes": info.notes,
        "task": asdict(task),
        "server": dict(info.server),
        "columns": meaning,
    }
    lines = [json.dumps(_episode_entry(entry), ensure_ascii=False) for entry in entries]
    head = json.dumps(content, indent=1, ensure_ascii=False).removesuffix("\n}")
    return head + ',\n "episodes": [' + ",".join(f"\n  {line}" for line in lines) + "\n ]\n}\n"


def _episode_entry(entry: Entry) -> dict[str, Any]:
    episode = entry.episode
    return {
        "episode": episode.number,
        "start": episode.start,
        "end": episode.end,
        "duration_s": episode.cycles / 10,
        "end_reason": REASONS[episode.reason],
        "teacher": entry.teacher,
        "decisions": entry.decisions,
        **({"idle": True} if entry.idle else {}),
        **({"final": list(episode.final)} if episode.final is not None else {}),
    }


def read_header(path: Path) -> tuple[DemonstrationInfo, list[Entry]]:
    """Read a header file.

    Raises
    ------
    FileFormatError
    """
    text = read_text(path, "header of a demonstration")
    try:
        content = parse_json(text, FORMAT, VERSION)
        entries = [
            _entry_from(entry, f"episode entry {k}") for k, entry in enumerate(item(content, "episodes", list), start=1)
        ]
        info = _info_from(content)
        for entry in entries:
            check_final(info, entry.episode)
        return info, entries
    except FileFormatError as error:
        raise FileFormatError(f"{path}: {error}") from error


def _info_from(content: dict[str, Any]) -> DemonstrationInfo:
    return DemonstrationInfo(
        item(content, "teacher", str),
        item(content, "stage", str),
        Task.from_dict(item(content, "task", dict)),
        item(content, "server", dict) if "server" in content else {},
        item(content, "seed", (int, type(None))) if "seed" in content else None,
        item(content, "date", (str, type(None))) if "date" in content else None,
        item(content, "notes", str) if "notes" in content else "",
        "columns" in content and all(name in item(content, "columns", dict) for name in MARKS),
    )


def _entry_from(content: Any, where: str) -> Entry:
    word = item(content, "end_reason", str, where)
    letters = [letter for letter, name in REASONS.items() if name == word]
    if not letters:
        raise FileFormatError(f"{where}: 'end_reason' must be {', '.join(REASONS.values())}, not {excerpt(word)}")
    final = _final_from(content, where) if "final" in content else None
    number, start, end, decisions = (
        whole(content, key, where, high=MAX_CYCLE) for key in ("episode", "start", "end", "decisions")
    )
    idle = item(content, "idle", bool, where) if "idle" in content else False
    return Entry(Episode(number, start, end, letters[0], final), item(content, "teacher", str, where), decisions, idle)


def _final_from(content: Any, where: str) -> tuple[float, ...]:
    """Read the state at the end of an episode."""
    values = item(content, "final", list, where)
    if not all(isinstance(v, int | float) and not isinstance(v, bool) and abs(v) <= MAX_VALUE for v in values):
        raise FileFormatError(f"{where}: 'final' must be numbers, metres or degrees, not {excerpt(values)}")
    return tuple(map(float, values))
