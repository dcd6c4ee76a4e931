"""What the examples share: playing greedily, and the files of a learning curve."""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from rcss_hat.envs.vector import KeepawayVectorEnv

OUT = Path("docs/results/baselines")
Choose = Callable[[np.ndarray], np.ndarray]
"""Observations of many matches -> actions."""


def mean_duration(choose: Choose, episodes: int = 200, seed: int = 1000, **settings: object) -> float:
    """Play a policy and return the mean duration of its episodes, in seconds.

    Of every match the same number of episodes counts: short ones would be over-represented among the first to end.
    """
    envs = KeepawayVectorEnv(20, autoreset_mode="SameStep", **settings)  # type: ignore[arg-type]
    seen, _ = envs.reset(seed=seed)
    wanted, durations = episodes // 20, [list[int]() for _ in range(20)]
    while min(map(len, durations)) < wanted:
        seen, _, over, _, info = envs.step(np.asarray(choose(seen)))
        for i in np.flatnonzero(over):
            durations[i].append(int(info["final_info"]["duration"][i]))
    envs.close()
    return float(np.mean([duration for match in durations for duration in match[:wanted]])) / 10.0


def is_there(package: str) -> bool:
    """Whether a package is installed; not every example needs all."""
    try:
        return bool(version(package))
    except PackageNotFoundError:
        return False


def write_curve(name: str, rows: Sequence[tuple[int, float]], note: str, x: str = "steps") -> None:
    """Write a learning curve: a table with what made it, and a figure."""
    import matplotlib.pyplot as plt

    OUT.mkdir(parents=True, exist_ok=True)
    known = ("numpy", "torch", "stable-baselines3", "gymnasium", "pettingzoo", "scikit-learn")
    packages = [package for package in known if is_there(package)]
    with (OUT / f"{name}.csv").open("w", newline="") as file:
        file.write(f"# python {' '.join(sys.argv)}\n# {note}\n")
        file.write("# " + ", ".join(f"{package} {version(package)}" for package in packages) + "\n")
        csv.writer(file, lineterminator="\n").writerows([(x, "mean_s"), *((a, round(b, 3)) for a, b in rows)])
    figure, axes = plt.subplots(figsize=(5.0, 3.2))
    axes.plot(*zip(*rows, strict=True), marker=".")
    axes.set(xlabel=x, ylabel="mean episode (s)", title=note)
    axes.title.set_fontsize(8)
    figure.tight_layout()
    figure.savefig(OUT / f"{name}.png", dpi=110)
    print(f"{name}: " + ", ".join(f"{a}: {b:.2f} s" for a, b in rows))
