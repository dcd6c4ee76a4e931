#!/usr/bin/env python3
"""Compare RipperClassifier with recorded outcomes of Weka's JRip on the same data sets and folds.

The folder holds one CSV file per data set, with the columns ``fold`` (number of the test fold), the features, and
``class``; and ``results.json`` with JRip's outcomes under ``datasets.NAME.jrip_mean``: ``cv_accuracy``, ``cv_rules``
and ``cv_conditions``, means over folds and seeds. Prints a Markdown table.
"""

from __future__ import annotations

import csv
import gzip
import json
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.ripper import RipperClassifier

SMALL = 150
"""Data sets of so many rows or fewer vary so much between seeds that they are run with more of them."""


@dataclass(frozen=True)
class Data:
    """A data set with its folds."""

    rows: NDArray[np.float64]
    classes: NDArray[np.str_]
    folds: NDArray[np.intp]


@dataclass(frozen=True)
class Outcome:
    """Means over the models of all folds and seeds."""

    accuracy: float
    accuracy_error: float  # standard error over seeds
    rules: float
    conditions: float
    milliseconds: float  # processor time of one fit


def read_data(path: Path) -> Data:
    """Read a data set, plain or gzipped."""
    with gzip.open(path, "rt", newline="") if path.suffix == ".gz" else path.open(newline="") as file:
        table = np.array(list(csv.reader(file))[1:])
    return Data(table[:, 1:-1].astype(float), table[:, -1], table[:, 0].astype(int))


def measure(data: Data, seeds: range) -> Outcome:
    """Cross-validate on the given folds, once per seed."""
    accuracies, rules, conditions = [], [], []
    started = time.process_time()
    for seed in seeds:
        correct = 0
        for fold in np.unique(data.folds):
            train, test = data.folds != fold, data.folds == fold
            learner = RipperClassifier(random_state=1000 * seed + int(fold)).fit(data.rows[train], data.classes[train])
            correct += int((learner.predict(data.rows[test]) == data.classes[test]).sum())
            rules.append(len(learner.rules_))
            conditions.append(sum(len(rule.conditions) for rule in learner.rules_))
        accuracies.append(correct / len(data.classes))
    spent = time.process_time() - started
    error = float(np.std(accuracies, ddof=1) / len(accuracies) ** 0.5) if len(accuracies) > 1 else float("nan")
    return Outcome(
        float(np.mean(accuracies)),
        error,
        float(np.mean(rules)),
        float(np.mean(conditions)),
        1000.0 * spent / len(rules),
    )


def row(name: str, n_rows: int, seeds: int, ours: Outcome, jrip: dict[str, Any]) -> str:
    """One line of the table."""
    difference = 100.0 * (ours.accuracy - jrip["cv_accuracy"])
    return (
        f"| {name} | {n_rows} | {seeds} | {100 * ours.accuracy:.1f} ± {100 * ours.accuracy_error:.1f} | "
        f"{100 * jrip['cv_accuracy']:.1f} | {difference:+.1f} | {ours.rules:.2f} | {jrip['cv_rules']:.2f} | "
        f"{ours.conditions:.2f} | {jrip['cv_conditions']:.2f} | {ours.milliseconds:.0f} |"
    )


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--seeds", default=5, show_default=True, type=click.IntRange(1), help="Seeds per data set.")
@click.option("--small-seeds", default=20, show_default=True, type=click.IntRange(1), help="Seeds up to 150 rows.")
def main(folder: Path, seeds: int, small_seeds: int) -> None:
    """Cross-validate RipperClassifier on the data sets of FOLDER and compare with JRip."""
    recorded = json.loads((folder / "results.json").read_text())["datasets"]
    click.echo(
        "| data set | rows | seeds | accuracy % | JRip | difference | rules | JRip | conditions | JRip | ms/fit |"
    )
    click.echo("|---|---|---|---|---|---|---|---|---|---|---|")
    ours, theirs = [], []
    for name, entry in recorded.items():
        path = folder / f"{name}.csv"
        data = read_data(path if path.exists() else path.with_suffix(".csv.gz"))
        n_seeds = small_seeds if len(data.classes) <= SMALL else seeds
        outcome = measure(data, range(n_seeds))
        jrip = entry["jrip_mean"]
        ours.append((outcome.accuracy, outcome.rules, outcome.conditions))
        theirs.append((jrip["cv_accuracy"], jrip["cv_rules"], jrip["cv_conditions"]))
        click.echo(row(name, len(data.classes), n_seeds, outcome, jrip))
    (accuracy, rules, conditions), (their_accuracy, their_rules, their_conditions) = (
        np.mean(ours, 0),
        np.mean(theirs, 0),
    )
    click.echo(
        f"| mean | | | {100 * accuracy:.2f} | {100 * their_accuracy:.2f} | {100 * (accuracy - their_accuracy):+.2f} | "
        f"{rules:.2f} | {their_rules:.2f} | {conditions:.2f} | {their_conditions:.2f} | |"
    )


if __name__ == "__main__":
    main()
