"""Load test of a study: scripted participants at real speed; frame times, and nothing lost when the server is killed.

python scripts/bench/people.py --participants 20 --games 5 --kill 30
"""

from __future__ import annotations

import argparse
import asyncio
import csv
import json
import os
import sys
import tempfile
from pathlib import Path

import numpy as np

from rcss_hat.hat.demonstrations import DemonstrationSet
from rcss_hat.studies.folder import StudyFolder
from rcss_hat.studies.people_file import load_people
from rcss_hat.studies.rehearsal import crowd

STUDY = """
title = "Load test"
seed = 1
participants = {participants}
[game]
profile = "11.1"
episodes = {games}
[[step]]
kind = "text"
name = "consent"
text = "A load test."
agree = "Yes"
[[step]]
kind = "demonstration"
name = "play"
[[step]]
kind = "questions"
name = "load"
use = "nasa-tlx"
[[step]]
kind = "end"
name = "end"
text = "Thanks"
code = true
"""


class Server:
    def __init__(self, study: Path, out: Path, jobs: int) -> None:
        self.study, self.out, self.jobs, self.port = study, out, jobs, 0
        self.process: asyncio.subprocess.Process | None = None

    async def start(self) -> list[str]:
        links = self.out / "keys" / "links.csv"
        links.unlink(missing_ok=True)
        self.process = await asyncio.create_subprocess_exec(
            sys.executable, "-m", "rcss_hat", "study", "serve", str(self.study), "--out", str(self.out),
            "--port", str(self.port), "--jobs", str(self.jobs), stderr=asyncio.subprocess.DEVNULL,
        )  # fmt: skip
        while not links.exists():
            await asyncio.sleep(0.05)
        with links.open() as file:
            found = [row["link"] for row in csv.DictReader(file)]
        self.port = int(found[0].split("/")[2].split(":")[1])
        return found

    async def end(self, kill: bool) -> None:
        assert self.process is not None
        self.process.kill() if kill else self.process.terminate()
        await self.process.wait()


async def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--participants", type=int, default=20)
    parser.add_argument("--games", type=int, default=5)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--kill", type=float, default=None, help="Seconds after which the server is killed with -9.")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        study, out = Path(place) / "study.toml", Path(place) / "out"
        study.write_text(STUDY.format(participants=options.participants, games=options.games))
        load_people(str(study))
        server = Server(study, out, options.jobs)
        links = await server.start()
        people = [{"link": link, "teacher": "ABC"[k % 3], "seed": k, "hurry": 1.0} for k, link in enumerate(links)]
        way = asyncio.create_task(crowd(people))
        if options.kill is not None:
            await asyncio.sleep(options.kill)
            before = recorded(out)
            await server.end(kill=True)
            await server.start()
            after = recorded(out)
            lost = sum(after.get(name, [])[: len(games)] != games for name, games in before.items())
            print(
                f"killed after {options.kill:g} s with {sum(map(len, before.values()))} games on the disk; lost: {lost}"
            )
        told = await way
        await server.end(kill=False)
        report(told, out, options.games)


def recorded(out: Path) -> dict[str, list[object]]:
    """Games in the headers of all demonstrations."""
    found = {}
    for file in sorted(out.glob("participants/*/play.json")):
        found[file.parent.name] = json.loads(file.read_text())["episodes"]
    return found


def report(told: list[dict[str, object]], out: Path, games: int) -> None:
    intervals = np.concatenate([np.array(t["intervals"], dtype=np.float64) for t in told])
    wanted = np.concatenate([np.array(t["wanted_ms"], dtype=np.float64) for t in told])
    late = intervals - wanted
    print(f"{len(told)} participants, {len(intervals)} pictures, breaks {sum(int(t['breaks']) for t in told)}")
    print(f"between pictures: median {np.median(intervals):.1f} ms, 95 % {np.quantile(intervals, 0.95):.1f} ms, "
          f"99 % {np.quantile(intervals, 0.99):.1f} ms, worst {intervals.max():.0f} ms")  # fmt: skip
    share, close = 100 * np.mean(late < 100.0), 100 * np.mean(late < 20.0)
    print(f"late by less than 100 ms: {share:.2f} %; by less than 20 ms: {close:.2f} %")
    kept = StudyFolder(out).participants()
    whole = sum(len(DemonstrationSet.load(k.folder / "play.csv")) == games and k.progress.finished for k in kept)
    print(f"{whole} of {len(told)} participants have all their games, and came to the end")


asyncio.run(main())
