"""Recording a demonstration episode by episode, so that one that is stopped keeps what was recorded."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat._demonstration_file import (
    Decision,
    DemonstrationInfo,
    Entry,
    check_decision,
    check_episode,
    file_pair,
    header_text,
    read_header,
    read_table,
    table_head,
    table_rows,
)
from rcss_hat.hat.files import FileFormatError, write_text
from rcss_hat.keepaway.report import Episode


class DemonstrationWriter:
    """Appends demonstrated episodes to a file.

    Decisions are held back until their episode has ended; then they are on the disk, and the header lists the
    episode, before ``end_episode`` returns. A stopped or crashed recording loses the running episode and no more.

    Parameters
    ----------
    path : str or Path
        The table, ``x.csv``; its header is ``x.json``.
    info : DemonstrationInfo
    resume : bool, default=False
        Go on with an existing file of the same teacher, task and stage; otherwise there must be none.

    Attributes
    ----------
    entries : list of Entry
        Episodes recorded, earlier ones of a resumed file included.

    Raises
    ------
    FileFormatError
        When the file exists and is not to be resumed, or is of another task, teacher or stage.
    """

    def __init__(self, path: str | Path, info: DemonstrationInfo, resume: bool = False) -> None:
        self.table, self.header = file_pair(path)
        self.info = info
        self.entries: list[Entry] = []
        self._decisions: list[Decision] = []
        if self.table.exists() or self.header.exists():
            if not resume:
                raise FileFormatError(f"{self.table} exists already; go on with it (resume), or choose another name")
            self._take_over()
        else:
            write_text(self.table, table_head(info.n_variables))
            self._write_header()

    def add(self, cycle: int, keeper: int, state: Sequence[float] | NDArray[np.float64], action: int) -> None:
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

        Raises
        ------
        ValueError
            When it does not fit the task, or comes before the last decision.
        """
        numbers = tuple(map(float, state))
        check_decision(self.info, keeper, numbers, action)
        if self._decisions and cycle < self._decisions[-1].cycle:
            raise ValueError(f"cycle {cycle} comes before the last decision's, {self._decisions[-1].cycle}")
        self._decisions.append(Decision(int(cycle), int(keeper), numbers, int(action)))

    def end_episode(self, start: int, end: int, reason: str) -> Episode:
        """Keep the running episode.

        Parameters
        ----------
        start, end : int
            Cycles of its begin and end.
        reason : {"o", "t", "?"}
            Ball out, taken, or not known.

        Returns
        -------
        Episode
            With its number in the file.

        Raises
        ------
        ValueError
            When the decisions do not lie within these cycles; the running episode stays as it is.
        """
        number = self.entries[-1].episode.number + 1 if self.entries else 1
        episode = Episode(number, int(start), int(end), reason)
        check_episode(episode, [decision.cycle for decision in self._decisions])
        with self.table.open("a", encoding="utf-8", newline="") as file:
            file.write(table_rows(number, self._decisions))
            file.flush()
            os.fsync(file.fileno())
        self.entries.append(Entry(episode, self.info.teacher, len(self._decisions)))
        self._write_header()
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

    def _write_header(self) -> None:
        write_text(self.header, header_text(self.info, self.entries, self.table.name))

    def _take_over(self) -> None:
        info, self.entries = read_header(self.header)
        for what in ("teacher", "stage", "task"):
            old, new = getattr(info, what), getattr(self.info, what)
            if old != new:
                raise FileFormatError(f"{self.header}: cannot go on with it: its {what} is {old!r}, not {new!r}")
        read_table(self.table, info, self.entries)
        n_lines = 1 + self.n_decisions
        with self.table.open("rb+") as file:
            size = sum(len(file.readline()) for _ in range(n_lines))
            file.truncate(size)
