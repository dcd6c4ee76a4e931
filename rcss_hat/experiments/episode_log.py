"""The episode log of a training run: a CSV file that grows, and is cut back when a run resumes.

Columns: ``episode`` (from 1), ``start`` and ``duration`` (cycles), ``reason`` (``o``: out, ``t``: taken away, ``?``:
not known), ``psi`` (probability of reusing the advice at the end of the episode; empty where the method has none) and
``hour`` (simulated hours of learning at the end of the episode).
"""

from __future__ import annotations

import csv
import io
import logging
import os
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import pandas as pd

from rcss_hat.inputs import MIB, FileFormatError, decoded, excerpt, read_text
from rcss_hat.keepaway.report import OUT, TAKEN, UNKNOWN, Episode
from rcss_hat.system.files import append, write_bytes, write_text

COLUMNS = ("episode", "start", "duration", "reason", "psi", "hour")
HEADER = ",".join(COLUMNS) + "\n"
CYCLES_PER_HOUR = 36_000
MAX_CYCLES = 2**30
"""Of an episode."""
MAX_LOG = 512 * MIB
"""Bytes: more than 10,000 simulated hours."""
_TAIL = 400
"""Bytes that hold a row of the log, and the one before it."""
_TYPES = dict(zip(COLUMNS, ("int64", "int64", "int64", "string", "float64", "float64"), strict=True))
_LOG = logging.getLogger(__name__)


class EpisodeLogError(ValueError):
    """An episode log that is missing or shorter than the checkpoint beside it says."""


class EpisodeLog:
    """Append-only log of finished episodes.

    Parameters
    ----------
    path : Path
        Made, with its header, when it does not exist.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        if not path.exists():
            write_text(path, HEADER)

    @property
    def size(self) -> int:
        """Length of the file in bytes."""
        return self.path.stat().st_size

    def append(self, episodes: Iterable[Episode], psi: Callable[[int], float | None]) -> None:
        """Write episodes to the end of the file, and see that the disk has them.

        Parameters
        ----------
        episodes : iterable of Episode
            Numbers and cycles as they count in the run.
        psi : callable
            Episode number -> psi at its end, or None.

        Raises
        ------
        OSError
            When they cannot be written; the file is then as it was.
        """
        rows = _rows(episodes, psi)
        if rows:
            append(self.path, rows)

    def replace(self, size: int, episodes: Iterable[Episode], psi: Callable[[int], float | None]) -> None:
        """Put episodes in the place of what was written after the file had ``size`` bytes, in one step.

        Parameters
        ----------
        size : int
        episodes, psi
            See `append`.
        """
        with self.path.open("rb") as file:
            kept = file.read(size)
        write_bytes(self.path, kept + _rows(episodes, psi))

    def check(self, size: int, episodes: int) -> pd.Series:
        """Check that the first ``size`` bytes hold so many whole episodes; returns their durations in cycles.

        Raises
        ------
        EpisodeLogError
            When they do not; nothing is changed.
        """
        found = self.size
        if found < size:
            raise EpisodeLogError(
                f"{self.path} has {found} bytes, fewer than the {size} its checkpoint counts: it was changed"
            )
        with self.path.open("rb") as file:
            data = file.read(size)
        if not data.endswith(b"\n"):
            raise EpisodeLogError(f"{self.path}: the {size} bytes its checkpoint counts end within a line")
        try:
            durations = _table(self.path, decoded(data, self.path, "episode log"))["duration"]
        except FileFormatError as problem:
            raise EpisodeLogError(str(problem)) from problem
        if len(durations) != episodes:
            raise EpisodeLogError(f"{self.path} has {len(durations)} episodes, its checkpoint {episodes}")
        return durations

    def cut(self, size: int) -> None:
        """Drop what was written after the file had ``size`` bytes.

        Raises
        ------
        EpisodeLogError
            When the file is shorter than that.
        """
        found = self.size
        if found < size:
            raise EpisodeLogError(
                f"{self.path} has {found} bytes, fewer than the {size} its checkpoint counts: it was changed"
            )
        os.truncate(self.path, size)


def last_hour(path: Path) -> float | None:
    """Return the simulated hour at which the last episode of a log ended, without reading all of it.

    None when there is none: somebody may be writing.
    """
    try:
        with path.open("rb") as file:
            file.seek(max(0, path.stat().st_size - _TAIL))
            return float(file.read().rpartition(b"\n")[0].rpartition(b",")[2])
    except (OSError, ValueError):
        return None


def read_episode_log(path: Path) -> pd.DataFrame:
    """Read an episode log; a last line that was cut off while it was written is left out, and said in one line.

    Returns
    -------
    DataFrame
        With the columns named above, and ``seconds``, the duration in simulated seconds.

    Raises
    ------
    EpisodeLogError
        When the file is not an episode log.
    FileNotFoundError

    Examples
    --------
    >>> import tempfile
    >>> import rcss_hat
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run = rcss_hat.learn(folder, hours=0.1, seed=1)
    ...     log = rcss_hat.read_episode_log(run.folder / "episodes.csv")
    >>> list(log.columns)
    ['episode', 'start', 'duration', 'reason', 'psi', 'hour', 'seconds']
    """
    if not path.exists():
        raise FileNotFoundError(f"{path}: there is no such episode log")
    try:
        text = read_text(path, "episode log", MAX_LOG)
    except FileFormatError as problem:
        raise EpisodeLogError(str(problem)) from problem
    whole, end, rest = text.rpartition("\n")
    if rest:
        _LOG.warning("%s is cut off; it is read up to its last whole line", path)
    return _table(path, whole + end)


def _shown(name: object) -> str:
    text = str(name)
    return text if text.isprintable() and len(text) < 30 else excerpt(text, 30)


def _table(path: Path, text: str) -> pd.DataFrame:
    try:
        with np.errstate(invalid="raise"):
            log = pd.read_csv(io.StringIO(text), dtype=_TYPES, quoting=csv.QUOTE_NONE)
    except (ValueError, ArithmeticError) as problem:  # of pandas: ParserError, EmptyDataError
        raise EpisodeLogError(f"{path} is not an episode log: {excerpt(str(problem), 150)}") from problem
    if tuple(log.columns) != COLUMNS or not isinstance(log.index, pd.RangeIndex):
        raise EpisodeLogError(
            f"{path} is not an episode log: its columns are {', '.join(map(_shown, log.columns[:8]))}"
        )
    sound = (log["episode"] > 0) & (log["start"] >= 0) & log["duration"].between(0, MAX_CYCLES)
    sound &= log["reason"].isin([OUT, TAKEN, UNKNOWN])
    sound &= log["psi"].isna() | log["psi"].between(0.0, 1.0)
    if not sound.all():
        line = 2 + int(np.flatnonzero(~sound.to_numpy(dtype=bool, na_value=False))[0])
        raise EpisodeLogError(f"{path}, line {line}: is no episode")
    log["seconds"] = log["duration"] / 10.0
    return log


def _rows(episodes: Iterable[Episode], psi: Callable[[int], float | None]) -> bytes:
    return "".join(_row(episode, psi(episode.number)) for episode in episodes).encode()


def _row(episode: Episode, psi: float | None) -> str:
    fields = (
        str(episode.number),
        str(episode.start),
        str(episode.cycles),
        episode.reason,
        "" if psi is None else f"{psi:.6g}",
        f"{episode.end / CYCLES_PER_HOUR:.5f}",
    )
    return ",".join(fields) + "\n"
