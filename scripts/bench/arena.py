"""Cycles per second in the arena, against the same game over UDP.

    scripts/bench/arena.py [--executable RCSSSERVER --players KEEPAWAY_PLAYER]

Times the C++ stack where it is given, and otherwise compares with our players on the fake server. Also: flat memory
over ten million cycles (``--long``), start-up time, and what the policies cost.
"""

from __future__ import annotations

import argparse
import asyncio
import resource
import time

import udp

from rcss_hat.arena.match import ArenaMatch
from rcss_hat.hat.policy import TeamPolicy, learners_policy, load_policy
from rcss_hat.hat.transfer.learners import Learners
from rcss_hat.hat.transfer.making import make_method
from rcss_hat.keepaway.task import Task
from rcss_hat.learning.config import load_config


def speed(policy: TeamPolicy, cycles: int, task: Task | None = None, repeats: int = 3) -> float:
    """Best of some repeats: the machine is shared."""
    best = 0.0
    for _ in range(repeats):
        match = ArenaMatch(task or Task(), 1, policy)
        for _ in match.advance(cycles=2_000):
            pass
        begun = time.perf_counter()
        for _ in match.advance(cycles=2_000 + cycles):
            pass
        best = max(best, cycles / (time.perf_counter() - begun))
    return best


def learner(preset: str) -> TeamPolicy:
    return learners_policy(Learners.create(load_config(preset), make_method("no-prior"), seed=1), None)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--executable", default=None)
    parser.add_argument("--players", default=None)
    parser.add_argument("--long", action="store_true", help="run ten million cycles and watch the memory")
    arguments = parser.parse_args()
    begun = time.perf_counter()
    for _ in ArenaMatch(Task(), 1, load_policy("hand", 3, 2, 1)).advance(cycles=1):
        pass
    print(f"first cycle after {time.perf_counter() - begun:.1f} s")
    if arguments.players and arguments.executable:
        cycles, wall, _ = asyncio.run(udp._theirs(arguments.executable, arguments.players, 15.0))
        base, name = cycles / wall, "C++ players on the real server"
    else:
        report = udp.ours(None, 30)
        base, name = report.cycles / report.wall_s, "our players on the fake server, over UDP"
    rows = [(name, base)]
    for policy in ("hand", "random", "hold"):
        rows.append((f"arena, 3v2, {policy}", speed(load_policy(policy, 3, 2, 1), 100_000)))
    for preset in ("cmac", "paper"):
        rows.append((f"arena, 3v2, learning ({preset})", speed(learner(preset), 100_000)))
    rows.append(("arena, 3v2, hand, vision 90", speed(load_policy("hand", 3, 2, 1), 50_000, Task(vision=90))))
    rows.append(("arena, 4v3, hand", speed(load_policy("hand", 4, 3, 1), 50_000, Task.parse("4v3"))))
    print(f"{'':<46}{'cycles/s':>10}{'ratio':>8}")
    for label, value in rows:
        print(f"{label:<46}{value:>10.0f}{value / base:>8.1f}")
    if arguments.long:
        match = ArenaMatch(Task(), 1, load_policy("hand", 3, 2, 1))
        for number, _ in enumerate(match.advance(cycles=10_000_000)):
            if number % 50 == 1:
                peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
                print(f"  {match.cycle:>9} cycles: {peak:.0f} MiB at most")


if __name__ == "__main__":
    main()
