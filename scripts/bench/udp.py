"""Cycles per second over UDP: our five players on the fake server and, where they are found, the originals.

    scripts/bench/udp.py [--executable RCSSSERVER] [--players KEEPAWAY_PLAYER] [--episodes N]

Everything is measured in one run on one machine: read the ratios. With ``--players`` (the UT Austin keepaway_player)
and a real server, the C++ players are timed too. At the end: where the time of our players goes (cProfile).
"""

from __future__ import annotations

import argparse
import asyncio
import cProfile
import pstats
import subprocess
import tempfile
import time
from pathlib import Path

from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.report import RunReport
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.match import Match, play_match
from rcss_hat.stage.servers import ServerProcess, find_executable

TASK = Task()


def ours(executable: str | None, episodes: int) -> RunReport:
    policy = load_policy("hand", 3, 2, 1)
    policy.warm_up()
    report = RunReport("real" if executable else "fake", "hand", "hand", TASK.size, TASK.field, TASK.vision, 1)
    server = ServerProcess(TASK, 1, executable)
    asyncio.run(play_match(report, Match(TASK, (server.host, server.port), 1, policy, True, episodes), server))
    server.clean()
    if report.failure:
        raise SystemExit(report.failure)
    return report


async def _theirs(executable: str | None, player: str, seconds: float) -> tuple[int, float, float]:
    async with ServerProcess(TASK, 1, executable, keepaway_start=4) as server:
        await server.answers(300.0)
        options = ["-p", str(server.port), "-k", "3", "-j", "2", "-x", "-1", "-y", "-1", "-e", "0"]
        with tempfile.TemporaryDirectory() as folder:
            clients = []
            for team, policy, n in (("keepers", "hand", 3), ("takers", "hand", 2)):
                for _ in range(n):
                    command = [player, *options, "-t", team, "-q", policy]
                    clients.append(subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL))
                    await asyncio.sleep(0.3)
            while not server.episodes():
                server.check()
                await asyncio.sleep(0.1)
            first, begun = server.episodes()[-1].end, time.monotonic()
            await asyncio.sleep(seconds)
            last, wall = server.episodes()[-1].end, time.monotonic() - begun
            for client in clients:
                client.kill()
                client.wait()
        durations = [e.cycles / 10.0 for e in server.episodes()]
    server.clean()
    return last - first, wall, sum(durations) / len(durations)


def profile(episodes: int) -> None:
    profiler = cProfile.Profile()
    profiler.enable()
    ours(None, episodes)
    profiler.disable()
    print("\nWhere the time of our players goes (fake server; seconds inside each function):")
    stats = pstats.Stats(profiler)
    rows = sorted(((t, n, f) for f, (_, n, t, _, _) in stats.stats.items()), reverse=True)[:16]  # type: ignore[attr-defined]
    for seconds, calls, (file, line, name) in rows:
        print(f"  {seconds:7.2f} s {calls:9d} calls  {Path(file).name}:{line} {name}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--executable", default=None, help="an rcssserver [default: the one on PATH]")
    parser.add_argument("--players", default=None, help="the UT Austin keepaway_player")
    parser.add_argument("--episodes", type=int, default=60)
    parser.add_argument("--seconds", type=float, default=15.0, help="how long the C++ players are timed")
    arguments = parser.parse_args()
    found = find_executable(arguments.executable)
    rows = []
    for stage, executable in (("fake", None), ("real", found)):
        if stage == "real" and found is None:
            print("no rcssserver found: measured on the fake server only")
            continue
        report = ours(executable, arguments.episodes)
        rows.append((f"our players, {stage} server", report.cycles / report.wall_s, report.summary()["mean_s"]))
        if arguments.players:
            cycles, wall, mean = asyncio.run(_theirs(executable, arguments.players, arguments.seconds))
            rows.append((f"C++ players, {stage} server", cycles / wall, mean))
    base = next((speed for name, speed, _ in rows if name == "C++ players, real server"), rows[0][1])
    print(f"{'3v2, hand-coded, full vision':<30}{'cycles/s':>10}{'ratio':>8}{'mean (s)':>10}")
    for name, speed, mean in rows:
        print(f"{name:<30}{speed:>10.0f}{speed / base:>8.2f}{mean:>10.2f}")
    profile(10)


if __name__ == "__main__":
    main()
