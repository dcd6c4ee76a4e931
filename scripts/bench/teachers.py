#!/usr/bin/env python3
"""Measure the scripted teachers: mean durations over many matches, and seeds of sessions most like the paper's.

A session is one match of 20 episodes. Sessions differ: by chance, and because the phase of every player's see messages
is drawn once per match. So the means are taken over many sessions, and a study that wants the paper's figures for a
single session of each teacher chooses its seeds, as the sets that ship with the package were chosen.
"""

from __future__ import annotations

from dataclasses import dataclass

import click
import numpy as np
from numpy.typing import NDArray

from rcss_hat.experiments.demonstrating import demonstrate
from rcss_hat.hat.demonstrations import DemonstrationSet
from rcss_hat.hat.teachers import STYLES
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.params import PROFILES

EPISODES, HALF = 20, 10


@dataclass(frozen=True)
class Figures:
    """Mean durations of the paper (s): all 20 episodes, the ten longest and the ten shortest where it gives them."""

    mean: float
    best: float | None = None
    worst: float | None = None


PAPER = {
    "A": Figures(10.4, 17.2, 4.6),
    "B": Figures(10.5),
    "C": Figures(11.3, 18.0, 4.6),
    "B-fast": Figures(4.3),
    "B-limited": Figures(5.2),
}
A_TEN = 7.5
"""Mean duration of the paper's ten random episodes of A (s)."""


def halves(durations: NDArray[np.float64]) -> tuple[float, float, float]:
    """Means of all episodes of a session, of the longer half and of the shorter half."""
    ordered = np.sort(durations)
    return float(ordered.mean()), float(ordered[HALF:].mean()), float(ordered[:HALF].mean())


def farness(session: tuple[float, float, float], paper: Figures) -> float:
    """Largest relative deviation of a session from the figures the paper gives."""
    wanted = (paper.mean, paper.best, paper.worst)
    return max(abs(found / want - 1.0) for found, want in zip(session, wanted, strict=True) if want is not None)


def tens(session: DemonstrationSet, seeds: range) -> list[tuple[int, float]]:
    """Seeds of random halves of a session and their means, nearest to the paper's ten of A first."""
    means = [(seed, float(session.random(HALF, seed).durations.mean())) for seed in seeds]
    return sorted(means, key=lambda found: abs(found[1] - A_TEN))


@click.command()
@click.option("--sessions", default=100, show_default=True, type=click.IntRange(2), help="Per teacher; seeds from 1.")
@click.option("--profile", type=click.Choice(PROFILES), default="11.1", show_default=True, help="Physics of.")
@click.option("--show", default=3, show_default=True, type=click.IntRange(0), help="Seeds to name per teacher.")
def main(sessions: int, profile: str, show: int) -> None:
    """Play sessions of 20 episodes in 3v2 and compare with the paper's teachers."""
    seeds, task = range(1, sessions + 1), Task(profile=profile)
    likest: dict[str, int] = {}
    click.echo(
        "| teacher | mean s | paper | best ten | paper | worst ten | paper | sd of a session | seeds like the paper's |"
    )
    click.echo("|---|---|---|---|---|---|---|---|---|")
    for name in STYLES:
        found = {seed: halves(demonstrate(task, name, EPISODES, seed).durations) for seed in seeds}
        table = np.array(list(found.values()))
        mean, best, worst = table.mean(axis=0)
        spread = table[:, 0].std(ddof=1)
        paper = PAPER[name]
        nearest = sorted(found, key=lambda seed: farness(found[seed], paper))[: max(show, 1)]
        like = ", ".join(
            f"{seed} ({found[seed][0]:.1f}; {100 * farness(found[seed], paper):.0f} %)" for seed in nearest[:show]
        )
        click.echo(
            f"| {name} | {mean:.2f} ± {spread / sessions**0.5:.2f} | {paper.mean} | {best:.1f} | {paper.best or ''} | "
            f"{worst:.1f} | {paper.worst or ''} | {spread:.2f} | {like} |"
        )
        likest[name] = nearest[0]
    few = tens(demonstrate(task, "A", EPISODES, likest["A"]), seeds)[:show]
    listed = ", ".join(f"{seed} ({mean:.2f} s)" for seed, mean in few)
    click.echo(f"\nRandom tens of session {likest['A']} of A most like the paper's ({A_TEN} s), by seed: {listed}")


if __name__ == "__main__":
    main()
