"""Decisions per second of one learner, compiled loop and calls from Python: ``python scripts/bench/learning.py``."""

from __future__ import annotations

import argparse
import time

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.transfer import METHODS, Learners, make_method
from rcss_hat.hat.transfer.kernels import decide_first, decide_step, finish_episode
from rcss_hat.learning import LearnerConfig, load_config
from rcss_hat.learning.sarsa import Learner
from rcss_hat.numeric.jit import njit

DECISIONS_PER_EPISODE = 18
"""What a keeper of the hand-coded policy takes on average."""
DECISIONS_IN_30_HOURS = 500_000
"""Of a team of three, roughly."""


@njit
def run(learner: Learner, method: NDArray[np.void], states: NDArray[np.float64], n: int) -> None:
    """Take n decisions while walking through the states, in episodes."""
    for k in range(n):
        state = states[k % states.shape[0]]
        advice = k % 3
        if k % DECISIONS_PER_EPISODE == 0:
            if k > 0:
                finish_episode(learner, 18.0)
            decide_first(learner, method, state, advice, 1.0)
        else:
            decide_step(learner, method, 3.0, state, advice, 1.0)


def walk(n_variables: int, steps: int) -> NDArray[np.float64]:
    """Make states as a holding keeper meets them: small steps from one to the next."""
    random = np.random.default_rng(0)
    states = np.empty((steps, n_variables))
    state = random.uniform(2.0, 16.0, n_variables)
    for k in range(steps):
        state = np.clip(state + random.normal(0.0, 0.4, n_variables), 0.0, 28.0)
        states[k] = state
    return np.ascontiguousarray(states)


def measure(config: LearnerConfig, method: str, keepers: int, takers: int, n: int) -> tuple[float, float]:
    """Decisions per second: in a compiled loop, and called one by one from Python."""
    team = Learners.create(config, make_method(method), keepers, takers)
    states = walk(team.approximator.n_variables, 2000)
    arrays = team.learner(0), team.method_record, states
    run(*arrays, 10)
    begin = time.perf_counter()
    run(*arrays, n)
    compiled = n / (time.perf_counter() - begin)
    keeper, calls = team.keeper(1), max(1, n // 20)
    keeper.decide(states[0])
    begin = time.perf_counter()
    for k in range(calls):
        keeper.decide(states[k % 2000], 3.0)
    return compiled, calls / (time.perf_counter() - begin)


def main() -> None:
    """Print one line per learner."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--decisions", type=int, default=300_000)
    parser.add_argument("--size", default="3v2")
    parser.add_argument("--method", default="ppr", choices=list(METHODS))
    options = parser.parse_args()
    keepers, takers = map(int, options.size.split("v"))
    print(f"{options.size}, method {options.method}, one core")
    print(f"{'learner':24}{'decisions/s':>14}{'us each':>10}{'30 h (s)':>10}{'from Python/s':>16}")
    for name, config in {
        "cmac": load_config("cmac"),
        "rbf": load_config("paper"),
        "rbf, one tiling": load_config("paper").with_changes(tilings=1),
        "cmac, lambda 0.5": load_config("cmac").with_changes(lambda_=0.5),
        "rbf, lambda 0.5": load_config("paper").with_changes(lambda_=0.5),
    }.items():
        compiled, python = measure(config, options.method, keepers, takers, options.decisions)
        hours = DECISIONS_IN_30_HOURS / compiled
        print(f"{name:24}{compiled:14,.0f}{1e6 / compiled:10.2f}{hours:10.2f}{python:16,.0f}")


if __name__ == "__main__":
    main()
