"""The paper's measures of a learning run, computed from its episode log.

An episode log is a DataFrame with one row per finished episode, in order, and at least the columns ``start`` and
``duration`` (cycles of 100 ms); `read_kwy` and `rcss_hat.experiments.episode_log.read_episode_log` make them. Results
are in seconds of simulated time.

With d_1, d_2, ... the durations in seconds, e_k the end of episode k in simulated hours, n(t) the number of episodes
with e_k <= t, and a window of W = 1000 episodes:

* windowed mean at time t: ``m(t) = mean of d_k for n(t) - min(W, n(t)) < k <= n(t)``;
* final reward after H hours: ``m(H)``;
* total reward: ``m(1) + m(2) + ... + m(H)`` (the paper's sum over every integral hour; t = 0 has no episodes);
* jumpstart: mean duration of 1,000 episodes of the method's initial policy without learning, minus that of No Prior;
* time to threshold: the first e_k with k >= W at which the windowed mean reaches the threshold.

Source: Taylor, Suay and Chernova (AAMAS 2011), section 4.2, where the paper leaves the window of the first hours open.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from rcss_hat.keepaway import report
from rcss_hat.keepaway.report import Episode

WINDOW = 1000
"""Episodes of the sliding mean."""
CYCLES_PER_SECOND = 10
CYCLES_PER_HOUR = 36_000
SLACK_HOURS = 0.1
"""A log may end this much before the hours it is measured over: the episode that was being played then is not in it."""


def episode_frame(episodes: Iterable[Episode]) -> pd.DataFrame:
    """Make an episode log of episodes.

    Returns
    -------
    DataFrame
        Columns ``episode``, ``start``, ``end``, ``duration`` (cycles), ``reason``, ``psi`` (nan), ``hour`` (simulated
        hours at the end) and ``seconds`` (duration).
    """
    known = list(episodes)
    end = np.array([e.end for e in known], dtype=np.int64)
    start = np.array([e.start for e in known], dtype=np.int64)
    return pd.DataFrame(
        {
            "episode": np.array([e.number for e in known], dtype=np.int64),
            "start": start,
            "end": end,
            "duration": end - start,
            "reason": pd.array([e.reason for e in known], dtype="string"),
            "psi": np.full(len(known), math.nan),
            "hour": end / CYCLES_PER_HOUR,
            "seconds": (end - start) / CYCLES_PER_SECOND,
        }
    )


def read_kwy(path: Path | str) -> pd.DataFrame:
    """Read a Keepaway log of rcssserver (``.kwy``) as an episode log, see `episode_frame`.

    Raises
    ------
    ValueError
        When the file is not a Keepaway log.
    FileNotFoundError
    """
    return episode_frame(report.read_kwy(Path(path)))


def durations(log: pd.DataFrame) -> NDArray[np.float64]:
    """Episode durations in seconds, shape (episodes,)."""
    return _column(log, "duration") / CYCLES_PER_SECOND


def end_hours(log: pd.DataFrame) -> NDArray[np.float64]:
    """Simulated hours at the end of each episode, shape (episodes,)."""
    return (_column(log, "start") + _column(log, "duration")) / CYCLES_PER_HOUR


def windowed_means(values: ArrayLike, window: int = WINDOW) -> NDArray[np.float64]:
    """Mean over each value and those before it, at most ``window`` of them.

    Parameters
    ----------
    values : array_like, shape (n,)
    window : int

    Returns
    -------
    ndarray of float64, shape (n,)
    """
    _check_window(window)
    series = pd.Series(np.asarray(values, dtype=np.float64))
    return series.rolling(window, min_periods=1).mean().to_numpy()


def learning_curve(log: pd.DataFrame, hours: ArrayLike, window: int = WINDOW) -> NDArray[np.float64]:
    """Windowed mean at given times.

    Parameters
    ----------
    log : DataFrame
        Episode log.
    hours : array_like, shape (k,)
        Simulated hours.
    window : int

    Returns
    -------
    ndarray of float64, shape (k,)
        Seconds; nan at times before the end of the first episode.

    Examples
    --------
    >>> import pandas as pd
    >>> from rcss_hat import learning_curve
    >>> log = pd.DataFrame({"start": [0, 18_000], "duration": [18_000, 9_000]})  # cycles of 0.1 s
    >>> learning_curve(log, hours=[0.25, 0.5, 1.0]).tolist()
    [nan, 1800.0, 1350.0]
    """
    means = windowed_means(durations(log), window)
    finished = np.searchsorted(end_hours(log), np.asarray(hours, dtype=np.float64), side="right")
    curve = np.full(finished.shape, math.nan)
    curve[finished > 0] = means[finished[finished > 0] - 1]
    return curve


def final_reward(log: pd.DataFrame, hours: float | None = None, window: int = WINDOW) -> float:
    """Mean duration of the last ``window`` episodes finished within ``hours`` (by default within the log).

    Raises
    ------
    ValueError
        When the log is empty, or shorter than ``hours``.
    """
    if hours is not None:
        _check_length(log, hours)
    elif log.empty:
        raise ValueError("the episode log is empty")
    return float(learning_curve(log, [math.inf if hours is None else hours], window)[0])


def total_reward(log: pd.DataFrame, hours: int, window: int = WINDOW) -> float:
    """Sum of the windowed means at hours 1, 2, ..., ``hours``.

    Raises
    ------
    ValueError
        When ``hours`` is not a whole number of at least 1, or the log is shorter.
    """
    if hours != int(hours) or hours < 1:
        raise ValueError(f"total reward is summed over whole hours, at least 1, not {hours!r}")
    _check_length(log, hours)
    return float(learning_curve(log, np.arange(1, int(hours) + 1), window).sum())


def early_reward(log: pd.DataFrame, episodes: int = WINDOW) -> float:
    """Mean duration of the first ``episodes`` episodes of learning (of all, while there are fewer)."""
    if log.empty:
        raise ValueError("the episode log is empty")
    return float(durations(log)[:episodes].mean())


def time_to_threshold(log: pd.DataFrame, threshold: float, window: int = WINDOW) -> float:
    """First hour at which the mean of a full window reaches ``threshold`` seconds; nan when it never does."""
    reached = windowed_means(durations(log), window) >= threshold
    reached[: window - 1] = False
    return float(end_hours(log)[reached.argmax()]) if reached.any() else math.nan


@dataclass(frozen=True, slots=True)
class Curves:
    """Learning curves of several trials of one condition.

    Attributes
    ----------
    hours : ndarray, shape (k,)
    trials : ndarray, shape (n_trials, k)
        Windowed means in seconds.
    """

    hours: NDArray[np.float64]
    trials: NDArray[np.float64]

    @property
    def mean(self) -> NDArray[np.float64]:
        """Mean over trials, shape (k,)."""
        return self.trials.mean(axis=0)

    @property
    def standard_error(self) -> NDArray[np.float64]:
        """Standard error over trials, shape (k,); nan for a single trial."""
        n = len(self.trials)
        if n < 2:
            return np.full(self.hours.shape, math.nan)
        return self.trials.std(axis=0, ddof=1) / math.sqrt(n)


def learning_curves(logs: Sequence[pd.DataFrame], hours: ArrayLike, window: int = WINDOW) -> Curves:
    """Windowed means of several trials at the same times.

    Raises
    ------
    ValueError
        When there is no log.
    """
    if not logs:
        raise ValueError("learning curves need at least one episode log")
    times = np.asarray(hours, dtype=np.float64)
    return Curves(times, np.stack([learning_curve(log, times, window) for log in logs]))


def _column(log: pd.DataFrame, name: str) -> NDArray[np.float64]:
    if name not in log.columns:
        raise ValueError(f"an episode log needs a column {name!r}; there are {', '.join(map(str, log.columns))}")
    return log[name].to_numpy(dtype=np.float64)


def _check_length(log: pd.DataFrame, hours: float) -> None:
    ends = end_hours(log)
    last = float(ends[-1]) if len(ends) else 0.0
    if last < hours - SLACK_HOURS:
        raise ValueError(f"the episode log ends after {last:.2f} of {hours:g} simulated hours")


def _check_window(window: int) -> None:
    if window < 1:
        raise ValueError(f"a window has at least 1 episode, not {window}")
