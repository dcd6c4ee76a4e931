"""Demonstrations: what a teacher decided, episode by episode."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat._demonstration_file import (
    DemonstrationInfo,
    Entry,
    check_decision,
    check_final,
    check_there,
    columns,
    file_pair,
    header_text,
    read_header,
)
from rcss_hat.hat._demonstration_table import read_table, table_head, table_rows
from rcss_hat.hat.demonstration import Demonstration
from rcss_hat.hat.demonstration_writer import DemonstrationWriter
from rcss_hat.hat.description import Description, coverage
from rcss_hat.inputs import FileFormatError
from rcss_hat.keepaway.decision import LEARNER
from rcss_hat.keepaway.report import OUT, UNKNOWN
from rcss_hat.system.files import write_text

if TYPE_CHECKING:
    from pandas import DataFrame

__all__ = [
    "Demonstration",
    "DemonstrationInfo",
    "DemonstrationSet",
    "DemonstrationWriter",
    "Description",
    "PICKS",
    "combine",
]

PICKS = ("first", "best", "worst", "random")
"""Ways to pick episodes of a set."""
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class DemonstrationSet:
    """Demonstrated episodes of one task, of one teacher or several.

    Attributes
    ----------
    info : DemonstrationInfo
    episodes : tuple of Demonstration

    Raises
    ------
    ValueError
        When a decision does not fit the task.

    Examples
    --------
    >>> import rcss_hat
    >>> best = rcss_hat.package_demonstrations("A").best(5)
    >>> len(best), best.X.shape == (best.n_decisions, 13), best.y.shape == (best.n_decisions,)
    (5, True, True)
    """

    info: DemonstrationInfo
    episodes: tuple[Demonstration, ...]

    def __post_init__(self) -> None:
        for demonstration in self.episodes:
            check_final(self.info, demonstration.episode)
            for index, decision in enumerate(demonstration.decisions, start=1):
                try:
                    check_decision(self.info, decision)
                except ValueError as error:
                    raise ValueError(f"episode {demonstration.episode.number}, decision {index}: {error}") from error

    def __len__(self) -> int:
        """Number of episodes."""
        return len(self.episodes)

    def __iter__(self) -> Iterator[Demonstration]:
        return iter(self.episodes)

    # --- rows ---------------------------------------------------------------------------------------------------

    @property
    def n_decisions(self) -> int:
        """Number of decisions in all episodes."""
        return sum(map(len, self.episodes))

    @property
    def X(self) -> NDArray[np.float64]:
        """States of all decisions, shape (n_decisions, n_variables)."""
        return np.concatenate([np.empty((0, self.info.n_variables)), *(d.states for d in self.episodes)])

    @property
    def y(self) -> NDArray[np.int64]:
        """Actions of all decisions, shape (n_decisions,)."""
        return np.concatenate([np.empty(0, dtype=np.int64), *(d.actions for d in self.episodes)])

    @property
    def groups(self) -> NDArray[np.int64]:
        """Position of each decision's episode in the set, shape (n_decisions,)."""
        return np.repeat(np.arange(len(self.episodes)), [len(d) for d in self.episodes])

    @property
    def durations(self) -> NDArray[np.float64]:
        """Durations of the episodes in seconds."""
        return np.array([d.duration for d in self.episodes])

    def sequences(
        self,
    ) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64], NDArray[np.bool_]]:
        """Decisions as their keepers lived them, for learners: each keeper's episode in one piece.

        Returns
        -------
        states, actions : ndarray, shapes (n, n_variables) and (n,)
        rewards : ndarray of float64, shape (n,)
            Cycles to the same keeper's next decision, or to the end of the episode.
        last : ndarray of bool, shape (n,)
            Last decision of a keeper in an episode.
        """
        order, rewards, last = [], [], []
        offset = 0
        for demonstration in self.episodes:
            for keeper in np.unique(demonstration.keepers):
                own = np.flatnonzero(demonstration.keepers == keeper)
                times = np.append(demonstration.cycles[own], demonstration.episode.end)
                order.append(offset + own)
                rewards.append(np.diff(times).astype(np.float64))
                last.append(np.arange(len(own)) == len(own) - 1)
            offset += len(demonstration)
        if not order:
            return self.X, self.y, np.empty(0), np.empty(0, dtype=np.bool_)
        rows = np.concatenate(order)
        return self.X[rows], self.y[rows], np.concatenate(rewards), np.concatenate(last)

    def to_frame(self) -> DataFrame:
        """Return the table as a pandas ``DataFrame``, columns as in the file."""
        import pandas as pd  # heavy, and needed nowhere else here

        data: dict[str, object] = {
            "episode": np.repeat([d.episode.number for d in self.episodes], [len(d) for d in self.episodes]),
            "cycle": _joined([d.cycles for d in self.episodes]),
            "keeper": _joined([d.keepers for d in self.episodes]),
        }
        rows = self.X
        data |= {f"s{k}": rows[:, k] for k in range(self.info.n_variables)}
        data["action"] = self.y
        if self.info.marked:
            data["by"] = [by for d in self.episodes for by in d.by]
            data["right"] = pd.array([right for d in self.episodes for right in d.right], dtype="Int64")
        return pd.DataFrame(data, columns=columns(self.info))

    @property
    def lessons(self) -> DemonstrationSet:
        """What of it teaches, see `Demonstration.lessons`; the set itself where nothing is marked."""
        if not self.info.marked:
            return self
        return DemonstrationSet(replace(self.info, marked=False), tuple(d.lessons for d in self.episodes))

    # --- choosing episodes --------------------------------------------------------------------------------------

    def best(self, n: int) -> DemonstrationSet:
        """Return the n longest episodes, in the order they were recorded."""
        return self.split(n, "best")[0]

    def worst(self, n: int) -> DemonstrationSet:
        """Return the n shortest episodes, in the order they were recorded."""
        return self.split(n, "worst")[0]

    def random(self, n: int, seed: int) -> DemonstrationSet:
        """Return n episodes drawn at random, in the order they were recorded."""
        return self.split(n, "random", seed)[0]

    def split(self, n: int, pick: str = "first", seed: int = 0) -> tuple[DemonstrationSet, DemonstrationSet]:
        """Return n episodes and the others, both in the order they were recorded.

        Parameters
        ----------
        n : int
        pick : {"first", "best", "worst", "random"}
            Which n; best: the longest.
        seed : int
            Of random picks.

        Raises
        ------
        ValueError
            When there are fewer than n, or no such way to pick.
        """
        if pick not in PICKS:
            raise ValueError(f"episodes are picked by {', '.join(PICKS)}, not {pick!r}")
        if not 0 <= n <= len(self):
            raise ValueError(f"the demonstration has {len(self)} episodes; cannot take {n} of them")
        if pick == "random":
            order = np.random.default_rng(seed).permutation(len(self))
        else:
            sign = {"first": 0.0, "best": -1.0, "worst": 1.0}[pick]
            order = np.argsort(sign * self.durations, kind="stable")
        return self._chosen(order[:n]), self._chosen(order[n:])

    def _chosen(self, positions: NDArray[np.intp]) -> DemonstrationSet:
        return replace(self, episodes=tuple(self.episodes[k] for k in np.sort(positions)))

    # --- figures ------------------------------------------------------------------------------------------------

    def describe(self) -> Description:
        """Return durations, shares of the actions, and how far the states reach."""
        n_actions = self.info.task.keepers
        rows = self.X
        ends = [d.episode.reason for d in self.episodes if d.episode.reason != UNKNOWN]
        return Description(
            self.info,
            self.durations,
            ends.count(OUT) / len(ends) if ends else float("nan"),
            np.bincount(self.y, minlength=n_actions),
            np.stack([rows.min(0), rows.mean(0), rows.max(0)]) if len(rows) else np.full((3, rows.shape[1]), np.nan),
            coverage(rows, self.info),
            sum(d.idle for d in self.episodes),
            sum(by == LEARNER for d in self.episodes for by in d.by),
            sum(right is not None for d in self.episodes for right in d.right),
        )

    # --- files --------------------------------------------------------------------------------------------------

    def save(self, path: str | Path) -> None:
        """Write the table (``x.csv``) and its header (``x.json``)."""
        table, header = file_pair(path)
        rows = (table_rows(self.info, d.episode.number, d.decisions) for d in self.episodes)
        write_text(table, table_head(self.info) + "".join(rows))
        entries = [Entry(d.episode, d.teacher, len(d), d.idle) for d in self.episodes]
        write_text(header, header_text(self.info, entries, table.name))

    @classmethod
    def load(cls, path: str | Path) -> DemonstrationSet:
        """Read a demonstration; ``path`` is its table or its header.

        Raises
        ------
        FileFormatError
            Naming file, line and what would be right.
        """
        check_there(path)
        table, header = file_pair(path)
        info, entries = read_header(header)
        episodes = []
        for entry, decisions in zip(entries, read_table(table, info, entries), strict=True):
            try:
                episodes.append(Demonstration.of(entry.episode, entry.teacher, decisions, info.n_variables, entry.idle))
            except ValueError as error:
                raise FileFormatError(f"{table}: {error}") from error
        return cls(info, tuple(episodes))

    def to_arff(self, path: str | Path) -> None:
        """Write all lessons as an ARFF file for Weka; attributes ``state_0`` .. and the nominal ``action``."""
        names, taught = self.info.variable_names, self.lessons
        head = [f"% demonstration of {self.info.teacher}, {self.info.task.size}"]
        head += [f"% state_{k} = {name}" for k, name in enumerate(names)]
        head += ["@relation demonstration", *(f"@attribute state_{k} numeric" for k in range(len(names)))]
        head += ["@attribute action {" + ",".join(str(k) for k in range(self.info.task.keepers)) + "}", "@data"]
        rows = [",".join([*map(repr, map(float, x)), str(a)]) for x, a in zip(taught.X, taught.y, strict=True)]
        write_text(Path(path), "\n".join(head + rows) + "\n")


def combine(sets: Iterable[DemonstrationSet]) -> DemonstrationSet:
    """Join demonstrations of one task, for example of several teachers; episodes are numbered anew.

    Raises
    ------
    ValueError
        When there is none, or the tasks differ.
    """
    parts = list(sets)
    if not parts:
        raise ValueError("there is no demonstration to combine; give one or more")
    first = parts[0].info
    for part in parts[1:]:
        if part.info.task != first.task:
            raise ValueError(
                f"only demonstrations of one task can be combined: {first.teacher} demonstrated {first.task}, "
                f"{part.info.teacher} {part.info.task}"
            )
    infos = [part.info for part in parts]
    episodes = [
        replace(d, episode=replace(d.episode, number=number))
        for number, d in enumerate((d for part in parts for d in part.episodes), start=1)
    ]
    info = DemonstrationInfo(
        " + ".join(dict.fromkeys(info.teacher for info in infos)),
        _common([info.stage for info in infos], "several"),
        first.task,
        {k: v for k, v in first.server.items() if all(info.server.get(k) == v for info in infos)},
        _common([info.seed for info in infos], None),
        _common([info.date for info in infos], None),
        "; ".join(dict.fromkeys(info.notes for info in infos if info.notes)),
        any(info.marked for info in infos),
    )
    return DemonstrationSet(info, tuple(episodes))


def _joined(arrays: list[NDArray[np.int64]]) -> NDArray[np.int64]:
    return np.concatenate([np.empty(0, dtype=np.int64), *arrays])


def _common(values: list[T], otherwise: T) -> T:
    return values[0] if all(value == values[0] for value in values) else otherwise
