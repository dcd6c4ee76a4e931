"""What a finished trial left in its folder: its result, and the log of all of its episodes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from rcss_hat.experiments.episode_log import EpisodeLogError, read_episode_log
from rcss_hat.experiments.run_folder import TrainingError
from rcss_hat.experiments.training import EPISODES
from rcss_hat.experiments.trial import read_result


@dataclass(frozen=True, slots=True)
class TrialRecord:
    """A finished trial.

    Attributes
    ----------
    result : dict
        Of `rcss_hat.experiments.trial.run_trial`.
    log : DataFrame or None
        Episode log; None when the condition does not learn.
    """

    result: dict[str, Any]
    log: pd.DataFrame | None


def read_trial(folder: Path) -> TrialRecord | None:
    """Read a trial; None when it has not ended.

    Raises
    ------
    TrainingError
        When its files are damaged, or its log lacks episodes.
    """
    result = read_result(folder)
    if result is None:
        return None
    return TrialRecord(result, _whole_log(folder / EPISODES, result) if (folder / EPISODES).exists() else None)


def _whole_log(path: Path, result: dict[str, Any]) -> pd.DataFrame:
    """Read the log of a finished trial, which must have all of its episodes."""
    try:
        log = read_episode_log(path)
    except EpisodeLogError as problem:
        raise TrainingError(str(problem)) from problem
    if len(log) != result.get("episodes", len(log)):
        raise TrainingError(f"{path} has {len(log)} episodes, the result beside it {result['episodes']}")
    return log
