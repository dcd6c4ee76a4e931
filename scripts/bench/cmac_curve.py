#!/usr/bin/env python3
"""Compare our CMAC learner with the UT Austin players' own: mean durations over 10 simulated hours in the arena.

python scripts/bench/cmac_curve.py --trials 5 --jobs 2
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import click
import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from rcss_hat.experiments.episode_log import read_episode_log
from rcss_hat.experiments.metrics import learning_curve
from rcss_hat.experiments.run_folder import RunConfig
from rcss_hat.experiments.training import TrainingRun
from rcss_hat.hat.transfer import make_method
from rcss_hat.keepaway.task import Task
from rcss_hat.learning.config import load_config

HOURS = (2, 4, 6, 8, 10)
ORIGINAL = (5.63, 6.89, 7.84, 8.57, 9.33)
"""One run of the C++ learner on rcssserver 19, in seconds, over the last 1,000 episodes."""


def curve(seed: int) -> NDArray[np.float64]:
    """Mean durations of the last 1,000 episodes at `HOURS`."""
    with tempfile.TemporaryDirectory() as folder:
        learner, method = load_config("cmac"), make_method("no-prior")
        config = RunConfig(task=Task(), learner=learner, method=method, seed=seed, hours=float(HOURS[-1]))
        run = TrainingRun.create(Path(folder), config)
        run.train(checkpoint_s=1e9)
        return learning_curve(read_episode_log(run.log.path), HOURS)


@click.command()
@click.option("--trials", default=5, show_default=True, type=click.IntRange(2))
@click.option("--seed", default=1, show_default=True, help="Of the first trial.")
@click.option("--jobs", default=1, show_default=True)
def main(trials: int, seed: int, jobs: int) -> None:
    """Train the players' own learner and print its curve beside the original's."""
    curves = np.array(Parallel(n_jobs=jobs)(delayed(curve)(seed + k) for k in range(trials)))
    mean, error = curves.mean(axis=0), curves.std(axis=0, ddof=1) / np.sqrt(trials)
    click.echo(f"| hour | C++ players, one run | ours, {trials} trials | difference |\n|---|---|---|---|")
    for hour, original, m, e in zip(HOURS, ORIGINAL, mean, error, strict=True):
        click.echo(f"| {hour} | {original:.2f} | {m:.2f} ± {e:.2f} | {100 * (m / original - 1):+.0f} % |")


if __name__ == "__main__":
    main()
