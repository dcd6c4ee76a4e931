"""What is kept of games beside their decisions: keys, and the times of pictures. CSV files that grow, row by row.

For a step ``play`` these are, beside ``play.csv`` and ``play.json`` (`rcss_hat.hat.demonstrations`):

``play.keys.csv``
    Every key, and what became of it; on the disk before the game it belongs to counts as played.
``play.frames.csv``
    When every picture was made.
``play.pace.csv``
    How long the page waited for every picture, by its own clock.

Rows belong to a game when they are of its match and its cycles; others are of games that did not count: interrupted by
a crash of the server, or paused.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from rcss_hat.system.files import append, named, write_text

KEYS = {
    "match": "Number of the match in this step.",
    "cycle": "Newest cycle of the match that the person could see when the key was pressed.",
    "ms": "When it was pressed: milliseconds since the participant began.",
    "page_ms": "The same by the page's own clock: milliseconds since the page was loaded; empty where it did not tell.",
    "action": "What the key asked for: 0 Hold, 1 PASS1 and so on.",
    "mate": "Team mate that was meant (`l2`: keeper 2), when it was an arrow, click or tap; empty for a number.",
    "holder": "Who had the ball then; empty: nobody.",
    "held_ms": "For how long he had had it, in milliseconds of real time; empty when nobody had it.",
    "fate": "What became of it: `played`; `lapsed`: nobody took it up in time; `repeated`: pressed again for "
    "a pass already "
    "on its way; `replaced` by another key; `taken back` by Hold; `hold`: it was Hold itself; `refused`: no such pass.",
    "fate_cycle": "Cycle in which that was known: of a key that was played, the cycle of its decision.",
}
FRAMES = {
    "match": "Number of the match in this step.",
    "cycle": "Cycle of the match.",
    "ms": "When its picture was made and sent: milliseconds since the participant began.",
}
PACE = {
    "match": "Number of the match in this step.",
    "cycle": "Newest cycle when the page told.",
    "ms": "When it told: milliseconds since the participant began.",
    "interval_ms": "Time from one picture to the next as the page got them; one row per picture, in order.",
    "standing": "1: the game stood still since the page told last, so that the interval says nothing of the network.",
}
TABLES: dict[str, dict[str, str]] = {"keys": KEYS, "frames": FRAMES, "pace": PACE}
MOST_ROWS = 2_000_000
"""Rows of one file; what a page sends on top is not kept."""


class GrowingTable:
    """A CSV file that grows.

    Parameters
    ----------
    path : Path
        Begun when it is missing; a last line that was cut off is removed.
    columns : sequence of str
    """

    def __init__(self, path: Path, columns: Sequence[str]) -> None:
        self.path = path
        self._columns = len(columns)
        self._waiting: list[str] = []
        self._rows = 0
        if path.exists():
            remove_unended_line(path)
        if not path.exists() or not path.stat().st_size:
            write_text(path, ",".join(columns) + "\n")

    def add(self, *values: Any) -> None:
        """Add a row, to be written with the next `flush`; None is an empty field."""
        assert len(values) == self._columns
        if self._rows < MOST_ROWS:
            line = io.StringIO()
            csv.writer(line, lineterminator="\n").writerow(["" if value is None else value for value in values])
            self._waiting.append(line.getvalue())
            self._rows += 1

    def flush(self) -> None:
        """Write what was added, and see that the disk has it.

        Raises
        ------
        NotWritten
            When the disk is full, for example; the rows are still here.
        """
        if self._waiting:
            append(self.path, "".join(self._waiting).encode())
            self._waiting = []


def table_path(folder: Path, step: str, kind: str) -> Path:
    """File of one of `TABLES`."""
    return folder / f"{step}.{kind}.csv"


def read_rows(path: Path) -> Iterator[dict[str, str]]:
    """Yield the rows of a file that grows; a last line that was cut off is none."""
    with path.open(encoding="utf-8", newline="") as file:
        text = file.read()
    yield from csv.DictReader(io.StringIO(text[: text.rfind("\n") + 1]))


def remove_unended_line(path: Path) -> None:
    """Remove a last line without an end: whoever wrote it was stopped."""
    with named(path), path.open("rb+") as file:
        whole = file.read().rfind(b"\n") + 1
        file.truncate(whole)
