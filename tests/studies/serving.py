"""A study that is served for the tests, in a process of its own or in the test's."""

from __future__ import annotations

import asyncio
import csv
import os
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path

from rcss_hat.hat.demonstrations import DemonstrationSet
from rcss_hat.keepaway.decision import LEARNER
from rcss_hat.studies.folder import Kept, StudyFolder


async def until(condition: Callable[[], bool], patience: float = 60.0) -> None:
    """Wait until something is so."""
    async with asyncio.timeout(patience):
        while not condition():
            await asyncio.sleep(0.02)


class Served:
    """``rcss-hat study serve`` in a process that can be killed and started again on the same port."""

    def __init__(self, study: Path, out: Path) -> None:
        self.study, self.out, self.port = study, out, 0
        self.process: asyncio.subprocess.Process | None = None
        self.links: list[str] = []

    async def start(self) -> None:
        """Start it, and wait for its links."""
        links = self.out / "keys" / "links.csv"
        links.unlink(missing_ok=True)
        self.process = await asyncio.create_subprocess_exec(
            sys.executable, "-m", "rcss_hat", "study", "serve", str(self.study), "--out", str(self.out),
            "--port", str(self.port), "--jobs", "1",
            env=dict(os.environ), stderr=asyncio.subprocess.DEVNULL,
        )  # fmt: skip
        await until(links.exists, 120.0)
        with links.open() as file:
            self.links = [row["link"] for row in csv.DictReader(file)]
        self.port = int(self.links[0].split("/")[2].split(":")[1])

    async def kill(self) -> None:
        """Kill it with -9."""
        assert self.process is not None
        self.process.kill()
        await self.process.wait()

    async def stop(self) -> None:
        """End it as Ctrl-C does."""
        assert self.process is not None
        if self.process.returncode is None:
            self.process.terminate()
            await self.process.wait()


@asynccontextmanager
async def served(study: Path, out: Path) -> AsyncIterator[Served]:
    """Serve a study."""
    server = Served(study, out)
    await server.start()
    try:
        yield server
    finally:
        await server.stop()


def whole(kept: Kept) -> None:
    """Check that what is kept of a participant who has finished fits together, and that nothing of it is missing."""
    assert kept.progress.finished
    times = [event["ms"] for event in kept.events if event["event"] in ("begun", "done", "answers")]
    assert times == sorted(times)
    for planned in kept.plan:
        if not planned.kept:
            continue
        wanted = kept.progress.wanted(planned.name)
        games = kept.progress.played[planned.name].games
        demonstration = DemonstrationSet.load(kept.folder / f"{planned.name}.csv")
        assert len(games) == len(demonstration) == wanted
        for game, shown in zip(games, demonstration, strict=True):
            assert (game["start"], game["end"]) == (shown.episode.start, shown.episode.end)
            assert game["idle"] == shown.idle
        passes = played_keys(kept.folder / f"{planned.name}.keys.csv")
        for game, shown in zip(games, demonstration, strict=True):
            mine = {cycle for match, cycle in passes if match == game["match"] and game["start"] <= cycle < game["end"]}
            his = [d.cycle for d in shown.decisions if d.action > 0 and d.by != LEARNER]
            assert mine == set(his)


def played_keys(path: Path) -> set[tuple[int, int]]:
    """Match and cycle of the decision of every key that was played."""
    with path.open() as file:
        return {(int(r["match"]), int(r["fate_cycle"])) for r in csv.DictReader(file) if r["fate"] == "played"}


def people_of(out: Path) -> dict[str, Kept]:
    """Everybody of whom something is kept."""
    return {kept.name: kept for kept in StudyFolder(out).participants()}
