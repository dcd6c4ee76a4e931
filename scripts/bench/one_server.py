"""Matches one after the other on one server against as many on servers of their own: they must come to the same mean.

Example:
  python scripts/bench/one_server.py --matches 10 --episodes 30
  python scripts/bench/one_server.py --executable rcssserver --matches 10 --episodes 30
"""

from __future__ import annotations

import argparse
import asyncio

import numpy as np

from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.report import RunReport, mean_and_ci95
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.match import Match, play_match
from rcss_hat.stage.servers import ServerProcess

TASK = Task()
COMPILING = 600.0
"""Seconds for a server to start."""


async def match(server: ServerProcess, keepers: str, seed: int, episodes: int) -> list[float]:
    """Play one match on a server that runs; returns the durations of its episodes (s)."""
    policy = load_policy(keepers, TASK.keepers, TASK.takers, seed)
    policy.warm_up()
    report = RunReport.of("server", keepers, TASK, seed)
    await play_match(report, Match(TASK, (server.host, server.port), seed, policy, True, episodes))
    if report.failure is not None:
        raise SystemExit(report.failure)
    logged = {(e.start, e.end) for e in server.episodes()}
    missing = [e for e in report.episodes if (e.start, e.end) not in logged]
    if missing:
        raise SystemExit(f"the server has logged no such episodes: {missing}")
    return report.durations_s


async def matches(executable: str | None, keepers: str, n: int, episodes: int, shared: bool) -> list[list[float]]:
    """Play n matches, on one server or on n."""
    played = []
    for first in range(0, n, n if shared else 1):
        server = ServerProcess(TASK, first + 1, executable)
        async with server:
            await server.answers(COMPILING)
            for seed in range(first, first + (n if shared else 1)):
                played.append(await match(server, keepers, seed + 1, episodes))
        server.clean()
    return played


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--executable", default=None, help="an rcssserver; by default the fake server")
    parser.add_argument("--keepers", default="hand")
    parser.add_argument("--matches", type=int, default=10)
    parser.add_argument("--episodes", type=int, default=30)
    arguments = parser.parse_args()
    for shared in (True, False):
        played = asyncio.run(
            matches(arguments.executable, arguments.keepers, arguments.matches, arguments.episodes, shared)
        )
        mean, ci95 = mean_and_ci95([duration for one in played for duration in one])
        firsts = float(np.mean([one[0] for one in played]))
        name = "one server" if shared else f"{arguments.matches} servers"
        each = " ".join(f"{np.mean(one):.1f}" for one in played)
        print(f"{name}: mean {mean:.2f} +/- {ci95:.2f} s; first episodes {firsts:.2f} s; matches {each}", flush=True)


if __name__ == "__main__":
    main()
