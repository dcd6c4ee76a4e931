"""What a trial costs beyond its cycles, and how busy batches keep the processors.

    scripts/bench/trials.py [--hours 10] [--trials 8] [--jobs 2]

A trial's fixed cost is what one more trial of hardly any cycles adds to a study: making learners, writing, reading;
and with the two evaluations of 1,000 episodes of the paper's study. Busy is the processor time of all processes by the
time on the clock and the number of jobs, for whole commands, from their start to their last file.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parents[2]
STUDY = """
title = "Fixed costs"
seed = 1

[defaults]
learner = "paper"
hours = {hours}
trials = {trials}
evaluation_episodes = {episodes}

[[condition]]
name = "no-prior"
method = "no-prior"
"""


class Ran(NamedTuple):
    """Seconds of a command."""

    wall: float
    processor: float


def run(*arguments: str, folder: str) -> Ran:
    """Run rcss-hat with the sources of this folder."""
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    environment = {**os.environ, "PYTHONPATH": str(HERE)}
    command = [sys.executable, "-m", "rcss_hat", *arguments]
    subprocess.run(command, cwd=folder, env=environment, check=True, capture_output=True)
    wall, after = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    return Ran(wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def study(trials: int, hours: float, episodes: int, jobs: int, *options: str) -> Ran:
    """Run a study of one condition."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "study.toml"
        file.write_text(STUDY.format(trials=trials, hours=hours, episodes=episodes))
        return run("experiment", str(file), "--jobs", str(jobs), "--out", "out", *options, folder=folder)


def fixed(episodes: int, few: int = 4, many: int = 24) -> float:
    """Seconds that one more trial takes, one at a time."""
    walls = [study(trials, 0.001, episodes, 1, "--no-report").wall for trials in (few, many)]
    return (walls[1] - walls[0]) / (many - few)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hours", type=float, default=10.0, help="simulated hours of the trials that keep busy")
    parser.add_argument("--trials", type=int, default=8, help="and how many of them")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args()
    run("compile", folder=str(HERE))
    alone, evaluated = fixed(0), fixed(1000)
    print(f"a trial beyond its cycles: {alone:.2f} s, with two evaluations of 1,000 episodes {evaluated:.2f} s")
    size = options.trials, options.hours, 1000, options.jobs
    batches = {
        f"experiment, {options.trials} trials of {options.hours:g} h": study(*size, "--no-report"),
        "the same with its report": study(*size),
        "play --matches": run(
            *("play", "--on", "arena", "--matches", str(options.trials), "--jobs", str(options.jobs)),
            *("--episodes", "12000", "--seed", "1"),
            folder=str(HERE),
        ),
    }
    for name, took in batches.items():
        busy = took.processor / (took.wall * options.jobs)
        print(f"{name}: {took.wall:.1f} s, {options.jobs} processors {100 * busy:.0f} % busy")


if __name__ == "__main__":
    main()
