"""Recording a demonstration episode by episode, so that one that is stopped keeps what was recorded."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat._demonstration_file import (
    DemonstrationInfo,
    Entry,
    check_decision,
    check_episode,
    check_final,
    file_pair,
    header_text,
    read_header,
)
from rcss_hat.hat._demonstration_table import read_table, table_head, table_rows
from rcss_hat.inputs import FileFormatError
from rcss_hat.keepaway.decision import Decision
from rcss_hat.keepaway.report import Episode
from rcss_hat.system.files import append, write_text
from rcss_hat.system.locks import SoleWriter


class DemonstrationWriter:
    """Appends demonstrated episodes to a file.

    Decisions are held back until their episode has ended; then they are on the disk, and the header lists the
    episode, before ``end_episode`` returns. A stopped or crashed recording loses the running episode and no more.

    Parameters
    ----------
    path : str or Path
        The table, ``x.csv``; its header is ``x.json``. No other process can write to it until the end of a ``with``.
    info : DemonstrationInfo
    resume : bool, default=False
        Go on with an existing file that was made in the same way; otherwise there must be none with an episode in it.

    Attributes
    ----------
    info : DemonstrationInfo
        Of a resumed file: what it said before.
    entries : list of Entry
        Episodes recorded, earlier ones of a resumed file included.

    Raises
    ------
    FileFormatError
        When the file exists and is not to be resumed, or was made in another way: by another teacher, for example.
    InUse
        When another process writes to it.
    """

    def __init__(self, path: str | Path, info: DemonstrationInfo, resume: bool = False) -> None:
        self.table, self.header = file_pair(path)
        self.info = info
        self.entries: list[Entry] = []
        self._decisions: list[Decision] = []
        self._right = SoleWriter(self.table, folder=False)
        if not self._begun():
            self._write_header(self.entries)  # first: a table of which no header tells is not ours to write over
            write_text(self.table, table_head(info))
        elif resume:
            self._take_over()
        else:
            raise FileFormatError(f"{self.table} exists already; go on with it (resume), or choose another name")

    def add(
        self,
        cycle: int,
        keeper: int,
        state: Sequence[float] | NDArray[np.float64],
        action: int,
        by: str = "",
        right: int | None = None,
    ) -> None:
        """Record a decision of the running episode.

        Parameters
        ----------
        cycle : int
            Server cycle.
        keeper : int
            Uniform number of the keeper with the ball.
        state : sequence of float
            The state variables, metres and degrees.
        action : int
            0 = Hold, 1 = PASS1 and so on.
        by : str
            Who decided, and
        right : int, optional
            what would have been right; only where the demonstration is marked.

        Raises
        ------
        ValueError
            When it does not fit the task, or comes before the last decision.
        """
        decision = Decision(int(cycle), int(keeper), tuple(map(float, state)), int(action), by, right)
        check_decision(self.info, decision)
        if self._decisions and cycle < self._decisions[-1].cycle:
            raise ValueError(f"cycle {cycle} comes before the last decision's, {self._decisions[-1].cycle}")
        self._decisions.append(decision)

    def end_episode(
        self, start: int, end: int, reason: str, idle: bool = False, final: Sequence[float] | None = None
    ) -> Episode:
        """Keep the running episode.

        Parameters
        ----------
        start, end : int
            Cycles of its begin and end.
        reason : {"o", "t", "?"}
            Ball out, taken, or not known.
        idle : bool
            The person pressed no key in it.
        final : sequence of float, optional
            State variables at its end.

        Returns
        -------
        Episode
            With its number in the file.

        Raises
        ------
        ValueError
            When the decisions do not lie within these cycles; the running episode stays as it is.
        NotWritten
            When the disk is full, for example; the running episode and the file stay as they are.
        """
        number = self.entries[-1].episode.number + 1 if self.entries else 1
        seen = None if final is None else tuple(map(float, final))
        episode = Episode(number, int(start), int(end), reason, seen)
        check_final(self.info, episode)
        check_episode(episode, [decision.cycle for decision in self._decisions])
        entries = [*self.entries, Entry(episode, self.info.teacher, len(self._decisions), idle)]
        size = self.table.stat().st_size
        append(self.table, table_rows(self.info, number, self._decisions).encode())
        try:
            self._write_header(entries)
        except BaseException:
            os.truncate(self.table, size)
            raise
        self.entries = entries
        self._decisions = []
        return episode

    def drop_episode(self) -> None:
        """Forget the running episode."""
        self._decisions = []

    @property
    def n_decisions(self) -> int:
        """Number of decisions kept, those of the running episode left out."""
        return sum(entry.decisions for entry in self.entries)

    @property
    def mean_duration(self) -> float:
        """Mean duration of the episodes kept, in seconds; nan without any."""
        return float(np.mean([e.episode.cycles for e in self.entries])) / 10.0 if self.entries else float("nan")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.drop_episode()
        self._right.release()

    def remove_if_empty(self) -> None:
        """Leave no files of a recording without an episode."""
        if not self.entries:
            self.table.unlink(missing_ok=True)
            self.header.unlink(missing_ok=True)

    def _write_header(self, entries: Sequence[Entry]) -> None:
        write_text(self.header, header_text(self.info, entries, self.table.name))

    def _begun(self) -> bool:
        """Whether there is something to lose: an episode, or a table that is not known to be empty."""
        return bool(read_header(self.header)[1]) if self.header.exists() else self.table.exists()

    def _take_over(self) -> None:
        info, self.entries = read_header(self.header)
        for what, (old, new) in _differences(info, self.info):
            raise FileFormatError(f"{self.header}: cannot go on with it: its {what} is {old!r}, not {new!r}")
        self.info = info
        read_table(self.table, info, self.entries)
        n_lines = 1 + self.n_decisions
        with self.table.open("rb+") as file:
            size = sum(len(file.readline()) for _ in range(n_lines))
            file.truncate(size)


def _differences(old: DemonstrationInfo, new: DemonstrationInfo) -> Iterator[tuple[str, tuple[object, object]]]:
    """Name what makes episodes of two recordings different in kind, with both values."""
    for what in ("teacher", "stage", "task", "notes", "marked"):
        if getattr(old, what) != getattr(new, what):
            yield what, (getattr(old, what), getattr(new, what))
    for name in sorted(old.server.keys() & new.server.keys()):
        if old.server[name] != new.server[name]:
            yield f"server::{name}", (old.server[name], new.server[name])
