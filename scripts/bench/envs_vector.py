"""Decisions per second of processor time of the vector environment, against the compiled loop.

    scripts/bench/envs_vector.py [--decisions 16000 --repeats 5]

All play random actions. Each figure is the best of some repeats that take turns, for the machine may be shared; the
ratios compare what one core does. Two threads are measured by the wall clock, against one thread in the same run.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np

from rcss_hat.arena.match import ArenaMatch
from rcss_hat.envs.vector import KeepawayVectorEnv
from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.task import Task

Clock = Callable[[], float]
SIZES = (1, 8, 32, 128)


def loop(decisions: int, clock: Clock) -> float:
    """Let the compiled loop decide by itself."""
    match, made = ArenaMatch(Task(), 1, load_policy("random", 3, 2, 1), log_decisions=True), 0
    cycles = 5 * decisions
    for _ in match.advance(cycles=100):
        match.take_decisions()
    begun = clock()
    for _ in match.advance(cycles=cycles):
        made += len(match.take_decisions())
    return made / (clock() - begun)


def vector(n: int, threads: int, decisions: int, clock: Clock) -> float:
    """Step the vector environment."""
    envs = KeepawayVectorEnv(n, threads=threads, autoreset_mode="SameStep")
    envs.reset(seed=1)
    actions = np.random.default_rng(1).integers(0, 3, (decisions // n, n))
    begun = clock()
    for row in actions:
        envs.step(row)
    speed = actions.size / (clock() - begun)
    envs.close()
    return speed


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--decisions", type=int, default=16_000)
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    n = arguments.decisions
    cases: dict[str, Callable[[], float]] = {"compiled loop": lambda: loop(n, time.process_time)}
    for size in SIZES:
        cases[f"vector of {size}"] = lambda size=size: vector(size, 1, n, time.process_time)  # type: ignore[misc]
    walls: dict[str, Callable[[], float]] = {}
    for size in (32, 128):
        for threads in (1, 2):
            walls[f"vector of {size}, {threads} threads, by the wall clock"] = (  # type: ignore[misc]
                lambda size=size, threads=threads: vector(size, threads, n, time.perf_counter)
            )
    best = dict.fromkeys([*cases, *walls], 0.0)
    for _ in range(arguments.repeats):
        for name, run in [*cases.items(), *walls.items()]:
            best[name] = max(best[name], run())
    for name in cases:
        print(f"{name:45} {best[name]:9,.0f} decisions/s  {best[name] / best['compiled loop']:.2f} of the loop")
    for name in walls:
        one = best[name.replace("2 threads", "1 threads")]
        print(f"{name:45} {best[name]:9,.0f} decisions/s  {best[name] / one:.2f} of one thread")


if __name__ == "__main__":
    main()
