"""Decisions per second of processor time of the environments that are stepped from Python, against the compiled loop.

    scripts/bench/envs.py [--decisions 16000 --repeats 5]

With the policy that decides most often, always Hold, and with random actions, of which most are passes that last. Each
figure is the best of some repeats that take turns, for the machine may be shared; the ratios compare what one core
does. The vector environment has a benchmark of its own, envs_vector.py.
"""

from __future__ import annotations

import argparse
import random
import time
from collections.abc import Callable

import gymnasium

import rcss_hat.envs
from rcss_hat.arena.match import ArenaMatch
from rcss_hat.envs import keepaway_v0
from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.task import Task

POLICIES = {"hold": (0,), "random": (0, 1, 2)}


def actions(policy: str, n: int) -> list[int]:
    draw = random.Random(1)
    return [draw.choice(POLICIES[policy]) for _ in range(n)]


def loop(policy: str, n: int) -> float:
    """Let the compiled loop decide by itself."""
    match, made = ArenaMatch(Task(), 1, load_policy(policy, 3, 2, 1), log_decisions=True), 0
    cycles = n * (2 if policy == "hold" else 6)
    for _ in match.advance(cycles=100):
        match.take_decisions()
    begun = time.process_time()
    for _ in match.advance(cycles=cycles):
        made += len(match.take_decisions())
    return made / (time.process_time() - begun)


def single(policy: str, n: int, **options: object) -> float:
    """Step the single environment as `gymnasium.make` returns it."""
    env = gymnasium.make("rcss_hat/Keepaway-v0", **options)
    env.reset(seed=1)
    chosen = actions(policy, n)
    begun = time.process_time()
    for action in chosen:
        _, _, terminated, truncated, _ = env.step(action)
        if terminated or truncated:
            env.reset()
    return n / (time.process_time() - begun)


def turns(policy: str, n: int) -> float:
    """Step PettingZoo's environment turn by turn; turns of agents of an episode that is over do not count."""
    env, chosen, made = keepaway_v0.env(per="decision"), actions(policy, n), 0
    env.reset(seed=1)
    begun = time.process_time()
    while made < n - 1000:
        for _ in env.agent_iter():
            _, _, terminated, truncated, _ = env.last()
            if terminated or truncated:
                env.step(None)
            else:
                env.step(chosen[made])
                made += 1
        env.reset()
    return made / (time.process_time() - begun)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--decisions", type=int, default=16_000)
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    n = arguments.decisions
    runs: dict[str, Callable[[str, int], float]] = {
        "compiled loop": loop,
        "single environment": lambda policy, n: single(policy, n, disable_env_checker=True),
        "  as made, with the passive checker": single,
        "PettingZoo, turn by turn": turns,
    }
    for policy in POLICIES:
        best = dict.fromkeys(runs, 0.0)
        for _ in range(arguments.repeats):
            for name, run in runs.items():
                best[name] = max(best[name], run(policy, n))
        print(f"{policy}:")
        for name, speed in best.items():
            print(f"  {name:38} {speed:9,.0f} decisions/s  {speed / best['compiled loop']:.2f} of the loop")


if __name__ == "__main__":
    rcss_hat.envs.register_envs()
    main()
