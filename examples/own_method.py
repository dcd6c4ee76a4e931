"""A transfer method in one file: ``python examples/own_method.py``. How to give it a name: docs/how-to/method.md.

*Trust by distance*: the advice is followed with a probability that fades with the episodes, as in Probabilistic Policy
Reuse, but never while the learner's own values are far apart: there it knows better.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

import rcss_hat
from rcss_hat.hat.transfer.method import NO_ADVICE, TransferMethod, check_number
from rcss_hat.learning.sarsa import select_epsilon_greedily
from rcss_hat.numeric.rng import bernoulli

DECAY, MARGIN = range(2)
"""Places of the settings in the kernel's record."""


def select_trust(
    method: NDArray[np.void], learner: NDArray[np.void], rng: NDArray[np.uint64], advice: int, confidence: float
) -> int:
    """The kernel: compiled when a learner with this method is made."""
    if advice == NO_ADVICE:
        return select_epsilon_greedily(learner, rng)
    q, n = learner["q"][0], learner["n_actions"][0]
    best, second = -np.inf, -np.inf
    for action in range(n):
        best, second = max(best, q[action]), max(second, min(best, q[action]))
    fades = method["settings"][0, DECAY] ** learner["episodes"][0]
    if best - second < method["settings"][0, MARGIN] and bernoulli(rng, fades):
        return advice
    return select_epsilon_greedily(learner, rng)


@dataclass(frozen=True, slots=True)
class Trust(TransferMethod):
    """Follow the advice while the learner's own values hardly differ."""

    decay: float = 0.999
    """Factor per episode of the probability to follow the advice."""
    margin: float = 5.0
    """Cycles by which the best action must be ahead for the learner to decide by itself."""

    name: ClassVar[str] = "trust"
    select = staticmethod(select_trust)

    def __post_init__(self) -> None:
        check_number("decay", self.decay, 0.0, 1.0)
        check_number("margin", self.margin, 0.0, 1000.0)

    def describe(self) -> str:
        return f"Trust: D with {self.decay:g} ** episodes while values differ by less than {self.margin:g} cycles"

    def settings(self) -> tuple[float, ...]:
        return (self.decay, self.margin)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hours", type=float, default=5.0, help="simulated")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("out/own-method"))
    o = parser.parse_args()
    rules = rcss_hat.summarize(rcss_hat.package_demonstrations("A"), seed=0).decision_list
    for name, method in (("ppr", rcss_hat.METHODS["ppr"]()), ("trust", Trust())):
        run = rcss_hat.learn(o.out / name, method, rules=rules, hours=o.hours, seed=o.seed)
        print(f"{method.describe()}\n  last 1,000 of {run.episodes} episodes: {run.windowed_mean:.2f} s")


if __name__ == "__main__":
    main()
