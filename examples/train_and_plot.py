"""Learn alone and with a demonstration, and plot both: ``python examples/train_and_plot.py --hours 10``.

One run of each; a study (docs/how-to/experiments.md) makes many, with statistics.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import rcss_hat


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hours", type=float, default=10.0, help="simulated")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--demonstrations", default="A", help="a file of yours, or a set of the package")
    parser.add_argument("--out", type=Path, default=Path("out/train-and-plot"))
    o = parser.parse_args()
    mine = Path(o.demonstrations)
    load = rcss_hat.DemonstrationSet.load if mine.suffix in (".csv", ".json") else rcss_hat.package_demonstrations
    rules = rcss_hat.summarize(load(o.demonstrations), seed=o.seed).decision_list
    print(rules)

    figure, axes = plt.subplots(figsize=(6.0, 3.6), layout="constrained")
    hours = np.linspace(0.0, o.hours, 200)[1:]
    for label, method, advice in (
        ("alone", "no-prior", None),
        ("value bonus", "value-bonus", rules),
        ("ppr", "ppr", rules),
    ):
        run = rcss_hat.learn(o.out / method, method, rules=advice, hours=o.hours, seed=o.seed)
        log = rcss_hat.read_episode_log(run.folder / "episodes.csv")
        axes.plot(hours, rcss_hat.learning_curve(log, hours), label=label)
        print(f"{label}: {run.episodes} episodes, the last 1,000 of them {run.windowed_mean:.2f} s")
    axes.set(xlabel="simulated hours", ylabel="mean of the last 1,000 episodes (s)")
    axes.legend()
    figure.savefig(o.out / "curves.png", dpi=120)
    print(o.out / "curves.png")


if __name__ == "__main__":
    main()
