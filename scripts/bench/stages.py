#!/usr/bin/env python3
"""Train here, play there: play a training run on every stage and compare mean durations.

rcss-hat train --learner best --hours 30 --seed 1 --out runs/best
python scripts/bench/stages.py runs/best --matches 10 --episodes 100

The arena and the fake server play the same matches. The real server (where an executable is found) draws its own random
numbers; several matches because who sees when is decided once per match.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import click
import numpy as np

STAGES = ("arena", "fake", "real")


def mean_duration(run: Path, stage: str, seed: int, episodes: int, executable: str | None) -> float:
    """Play one match; mean duration of its episodes in seconds."""
    command = [sys.executable, "-m", "rcss_hat", "play", "--on", stage, "--keepers", str(run), "--json"]
    command += ["--episodes", str(episodes), "--seed", str(seed)]
    if stage == "real" and executable is not None:
        command += ["--executable", executable]
    answer = subprocess.run(command, check=True, capture_output=True, text=True)
    return float(json.loads(answer.stdout)["mean_s"])


@click.command()
@click.argument("run", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--matches", default=10, show_default=True, type=click.IntRange(2))
@click.option("--episodes", default=100, show_default=True, help="Per match.")
@click.option("--executable", help="The real server's, when it is not on PATH.")
@click.option("--on", "stages", multiple=True, type=click.Choice(STAGES), help="By default all that can be had.")
def main(run: Path, matches: int, episodes: int, executable: str | None, stages: tuple[str, ...]) -> None:
    """Play RUN on every stage."""
    real = executable or shutil.which("rcssserver")
    click.echo("| stage | episodes | mean s | 95 % |\n|---|---|---|---|")
    for stage in stages or STAGES[: 3 if real else 2]:
        means = np.array([mean_duration(run, stage, seed, episodes, real) for seed in range(1, matches + 1)])
        half = 1.96 * means.std(ddof=1) / np.sqrt(matches)
        click.echo(f"| {stage} | {matches * episodes} | {means.mean():.2f} | ± {half:.2f} |")


if __name__ == "__main__":
    main()
