"""Human-Agent Transfer, step by step, with the commands a person would type."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import time
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

OUT = Path("out/demo")
STUDY = """\
title = "Human-Agent Transfer: a demonstration"
description = "No Prior against Probabilistic Policy Reuse from 20 demonstrated episodes."
seed = 1
baseline = "no-prior"

[defaults]
size = "3v2"
learner = "paper"
hours = 6
trials = 4
evaluation_episodes = 1000

[demonstrations.hand]
label = "Hand-coded teacher"
file = "demonstration.csv"

[[condition]]
name = "no-prior"
label = "No Prior"
method = "no-prior"

[[condition]]
name = "ppr"
label = "Prob. Policy Reuse"
method = "ppr"
demonstrations = "hand"

[[table]]
name = "demo"
title = "Learning alone and with a demonstration"
conditions = ["no-prior", "ppr"]

[[figure]]
name = "learning-curves"
title = "3v2 Keepaway, 20 m x 20 m"
conditions = ["no-prior", "ppr"]
"""


def run(*arguments: str, quiet: bool = False) -> str:
    print(f"\n$ rcss-hat {' '.join(arguments)}", flush=True)
    command = [sys.executable, "-m", "rcss_hat", *arguments]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    if not quiet:
        print(done.stdout, end="", flush=True)
    if done.returncode:
        sys.exit(done.returncode)
    return done.stdout


def fresh(*names: str) -> None:
    OUT.mkdir(parents=True, exist_ok=True)
    for name in names:
        (OUT / name).unlink(missing_ok=True)


def play(name: str, keepers: str) -> tuple[dict[str, float], list[float]]:
    kwy = OUT / f"{name}.kwy"
    options = ["--on", "fake", "--keepers", keepers, "--episodes", "100", "--seed", "2", "--kwy", str(kwy), "--json"]
    report = json.loads(run("play", *options, quiet=True))
    print(f"  mean {report['mean_s']:.2f} s, {report['cycles_per_s']:.0f} cycles/s", flush=True)
    lines = [line for line in kwy.read_text().splitlines() if not line.startswith("#")]
    return report, [int(line.split("\t")[3]) / 10.0 for line in lines]


def table(reports: dict[str, dict[str, float]]) -> None:
    print(f"\n{'keepers':<16}{'episodes':>9}{'mean (s)':>10}{'+/-':>7}{'out':>6}{'taken':>7}{'cycles/s':>10}")
    for name, r in reports.items():
        print(
            f"{name:<16}{r['episodes']:>9}{r['mean_s']:>10.2f}{r['ci95_s']:>7.2f}{r['out']:>6}{r['taken']:>7}"
            f"{r['cycles_per_s']:>10.0f}"
        )


def draw(durations: dict[str, list[float]]) -> Path:
    figure, axes = plt.subplots(figsize=(7.2, 3.4), layout="constrained")
    axes.boxplot(list(durations.values()), orientation="horizontal", widths=0.6, showmeans=True)
    axes.set_yticks(range(1, len(durations) + 1), list(durations))
    axes.set_xlabel("episode duration (s)")
    axes.set_title("3v2 Keepaway over UDP on the bundled server, 100 episodes each")
    path = OUT / "durations.png"
    figure.savefig(path, dpi=150)
    return path


def main() -> None:
    begun = time.monotonic()
    fresh("demonstration.csv", "demonstration.json", "rules.json")
    demonstration, rules = str(OUT / "demonstration.csv"), str(OUT / "rules.json")
    print("1. Demonstration: 20 episodes of the hand-coded teacher, over UDP on the bundled server")
    run("demonstrate", "--on", "fake", "--teacher", "hand", "--episodes", "20", "--seed", "1", "--out", demonstration)
    print("\n2. Policy summarisation: a decision list")
    run("summarize", demonstration, "--out", rules)
    print("\n3. The list plays, beside the fixed policies")
    played = {name: play(name.replace(" ", "-"), spec) for name, spec in
              (("random", "random"), ("always hold", "hold"), ("decision list", rules))}  # fmt: skip
    table({name: report for name, (report, _) in played.items()})
    picture = draw({name: durations for name, (_, durations) in played.items()})
    print("\n4. Learning in the arena, alone and with the list: 4 trials of 6 simulated hours each")
    study = OUT / "study.toml"
    study.write_text(STUDY)
    experiment = OUT / "experiment"
    shutil.rmtree(experiment, ignore_errors=True)
    run("experiment", str(study), "--out", str(experiment), "--jobs", "2")
    lines = (experiment / "report" / "report.md").read_text().splitlines()
    tables = lines[: lines.index("## Learning curves")]
    print("\n" + "\n".join(line for line in tables if line.startswith("|")))
    print(f"\nEpisode durations: {picture}\nLearning curves and tables: {experiment}/report")
    print(f"{time.monotonic() - begun:.0f} s in all")


if __name__ == "__main__":
    main()
