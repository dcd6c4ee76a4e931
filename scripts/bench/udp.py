"""Cycles per second over UDP: our five players on the fake server and, where they are found, the originals.

    scripts/bench/udp.py [--executable RCSSSERVER] [--players KEEPAWAY_PLAYER] [--episodes N] [--against CHECKOUT]

Everything is measured in one run on one machine: read the ratios. With ``--players`` (the UT Austin keepaway_player)
and a real server, the C++ players are timed too. At the end: where the time of our players goes (cProfile).

With ``--against`` the same matches are played turn by turn by this checkout and by another one, in processes of their
own, and nothing but their ratios is printed: on a shared machine nothing else means much. Processor time is that of
players and server together, without what a match of one episode takes.
"""

from __future__ import annotations

import argparse
import asyncio
import cProfile
import json
import os
import pstats
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.report import RunReport
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.match import Match, play_match
from rcss_hat.stage.servers import ServerProcess, find_executable

TASK = Task()
HERE = Path(__file__).parents[2]


class Pace(NamedTuple):
    """What a match took per cycle."""

    wall_us: float
    processor_us: float


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


def _played(sources: Path, stage: list[str], episodes: int) -> tuple[float, float, float]:
    """Play a match with the sources in some folder; returns cycles, seconds of play, and all processor time (s)."""
    command = [sys.executable, "-m", "rcss_hat", "play", "--keepers", "hand", "--seed", "1", "--json"]
    environment = {**os.environ, "PYTHONPATH": str(sources)}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    told = subprocess.run(
        [*command, *stage, "--episodes", str(episodes)], env=environment, check=True, capture_output=True, cwd=sources
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    report = json.loads(told.stdout)
    processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return report["cycles"], report["wall_s"], processor


def pace(sources: Path, stage: list[str], episodes: int) -> Pace:
    """Return what a cycle takes with the sources in some folder."""
    few, _, start = _played(sources, stage, 1)
    cycles, wall, processor = _played(sources, stage, episodes)
    if processor <= start or cycles <= few:
        raise SystemExit(f"{sources}: {episodes} episodes took no longer than one; give more --episodes")
    return Pace(wall / cycles * 1e6, (processor - start) / (cycles - few) * 1e6)


def compare(other: Path, found: str | None, stages: list[str], episodes: int, pairs: int) -> None:
    """Print how much faster this checkout plays than another one."""
    print(f"{'median of ' + str(pairs) + ' pairs (least to most)':<36}{'cycles/s':>22}{'processor time':>22}")
    for name, stage in (("fake", ["--on", "fake"]), ("real", ["--on", "real", "--executable", str(found)])):
        if name not in stages or (name == "real" and found is None):
            continue
        ratios = []
        for sources in (HERE, other):
            _played(sources, stage, 1)  # what is not compiled yet is compiled in here
        for k in range(pairs):
            order = (HERE, other) if k % 2 else (other, HERE)  # who begins may find the machine warmer
            took = {sources: pace(sources, stage, episodes) for sources in order}
            ratios.append([took[other][i] / took[HERE][i] for i in range(2)])
            print(f"pair {k + 1} on {name}: {ratios[-1][0]:.2f}, {ratios[-1][1]:.2f}", file=sys.stderr, flush=True)
        cells = [f"{statistics.median(r):.2f} ({min(r):.2f} to {max(r):.2f})" for r in zip(*ratios, strict=True)]
        print(f"{'our players, ' + name + ' server':<36}{cells[0]:>22}{cells[1]:>22}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--executable", default=None, help="an rcssserver [default: the one on PATH]")
    parser.add_argument("--players", default=None, help="the UT Austin keepaway_player")
    parser.add_argument("--episodes", type=int, default=60)
    parser.add_argument("--seconds", type=float, default=15.0, help="how long the C++ players are timed")
    parser.add_argument("--against", type=Path, help="a folder with other sources")
    parser.add_argument("--only", choices=["fake", "real"], action="append", help="this server, with --against")
    parser.add_argument("--pairs", type=int, default=5, help="matches of each, with --against")
    arguments = parser.parse_args()
    found = find_executable(arguments.executable)
    if arguments.against:
        stages = arguments.only or ["fake", "real"]
        return compare(arguments.against.resolve(), found, stages, arguments.episodes, arguments.pairs)
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
