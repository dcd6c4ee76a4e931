"""The episode log of a training run: a CSV file that grows, and is cut back when a run resumes.

Columns: ``episode`` (from 1), ``start`` and ``duration`` (cycles), ``reason`` (``o``: out, ``t``: taken away, ``?``:
not known), ``psi`` (probability of reusing the advice at the end of the episode; empty where the method has none) and
``hour`` (simulated hours of learning at the end of the episode).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from pathlib import Path

import pandas as pd

from rcss_hat.keepaway.report import Episode

COLUMNS = ("episode", "start", "duration", "reason", "psi", "hour")
HEADER = ",".join(COLUMNS) + "\n"
CYCLES_PER_HOUR = 36_000


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
            path.write_text(HEADER, encoding="utf-8")

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
        """
        text = "".join(_row(episode, psi(episode.number)) for episode in episodes)
        if not text:
            return
        with self.path.open("a", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())

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


def read_episode_log(path: Path) -> pd.DataFrame:
    """Read an episode log.

    Returns
    -------
    DataFrame
        With the columns named above, and ``seconds``, the duration in simulated seconds.

    Raises
    ------
    EpisodeLogError
        When the file is not an episode log.
    FileNotFoundError
    """
    try:
        log = pd.read_csv(path, dtype={"reason": "string"})
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError) as problem:
        raise EpisodeLogError(f"{path} is not an episode log: {problem}") from problem
    if tuple(log.columns) != COLUMNS:
        raise EpisodeLogError(f"{path} is not an episode log: its columns are {', '.join(log.columns)}")
    log["seconds"] = log["duration"] / 10.0
    return log


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
