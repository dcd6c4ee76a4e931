"""Demonstrations for tests: decisions recorded from the UT Austin players' hand-coded policy, and made-up ones."""

from __future__ import annotations

import csv
import gzip
from functools import cache
from pathlib import Path

import numpy as np

from rcss_hat.hat.demonstrations import Demonstration, DemonstrationInfo, DemonstrationSet
from rcss_hat.keepaway.report import OUT, TAKEN, UNKNOWN, Episode
from rcss_hat.keepaway.state import n_state_variables
from rcss_hat.keepaway.task import Task

RECORDED = Path(__file__).parent.parent / "data" / "hat" / "handcoded-decisions.csv.gz"


@cache
def hand_coded() -> DemonstrationSet:
    """20 episodes of the hand-coded policy in 3v2 on the real server (834 decisions)."""
    with gzip.open(RECORDED, "rt", newline="") as file:
        rows = list(csv.DictReader(file))
    episodes = []
    for number in range(20):
        own = sorted((row for row in rows if int(row["episode"]) == number), key=lambda row: int(row["cycle"]))
        cycles = [int(row["cycle"]) for row in own]
        episodes.append(
            Demonstration(
                Episode(number + 1, cycles[0], cycles[-1] + 15, UNKNOWN),
                "hand",
                np.array(cycles),
                np.array([int(row["keeper"]) for row in own]),
                np.array([[float(row[f"s{k}"]) for k in range(13)] for row in own]),
                np.array([int(row["action"]) for row in own]),
            )
        )
    return DemonstrationSet(DemonstrationInfo("hand", "real", server={"ball_speed_max": 3.0}), tuple(episodes))


def made_up(
    seed: int = 0,
    episodes: int = 6,
    task: Task | None = None,
    teacher: str = "A",
    per_episode: int = 8,
) -> DemonstrationSet:
    """Random states and actions; all durations differ."""
    task = task or Task()
    rng = np.random.default_rng(seed)
    n_variables = n_state_variables(task.keepers, task.takers)
    durations = rng.permutation(np.arange(30, 30 + 10 * episodes, 10))
    made = []
    start = 5
    for number in range(1, episodes + 1):
        n = int(rng.integers(0, per_episode + 1))
        end = start + int(durations[number - 1])
        made.append(
            Demonstration(
                Episode(number, start, end, (OUT, TAKEN)[number % 2]),
                teacher,
                np.sort(rng.integers(start, end + 1, n)),
                rng.integers(1, task.keepers + 1, n),
                rng.normal(8.0, 4.0, (n, n_variables)),
                rng.integers(0, task.keepers, n),
            )
        )
        start = end
    info = DemonstrationInfo(teacher, "arena", task, {"keepaway": True}, seed, "2026-01-02", f"of {teacher}")
    return DemonstrationSet(info, tuple(made))
