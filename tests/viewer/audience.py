"""What the viewer's tests share: recorded data, players placed by hand, and an audience that remembers."""

from __future__ import annotations

import asyncio
import gzip
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from rcss_hat.hat.policy import python_policy
from rcss_hat.keepaway.report import Episode
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.place import ARENA, Place
from rcss_hat.stage.stages import Stage as PlayStage
from rcss_hat.stage.stages import open_stage
from rcss_hat.viewer.audience import Audience, WatchError
from rcss_hat.viewer.demonstrator import IDLE_S, Demonstrator
from rcss_hat.viewer.frames import Frame, Player, Setup, Snapshot
from rcss_hat.viewer.narrator import make_frame
from rcss_hat.viewer.room import Room
from rcss_hat.viewer.terminal import Terminal

DATA = Path(__file__).parents[1] / "data" / "viewer"
SETUP = Setup("test")


def datagrams(name: str) -> list[bytes]:
    """What a monitor received."""
    return gzip.decompress((DATA / name).read_bytes()).splitlines()


def player(name: str, x: float, y: float) -> Player:
    """A player such as l1, standing somewhere."""
    return Player(name[0], int(name[1:]), x, y, 0.0, 0.0, 8000.0, False)


def snapshot(time: int, ball: tuple[float, ...], mode: str = "play_on", /, **places: tuple[float, float]) -> Snapshot:
    """A snapshot of players placed by hand: ``l1=(x, y)``."""
    x, y, vx, vy = (*ball, 0.0, 0.0)[:4]
    return Snapshot(time, mode, (x, y, vx, vy), tuple(player(name, *place) for name, place in places.items()))


class Remembering:
    """An audience that keeps everything it was told."""

    def __init__(self) -> None:
        self.setups: list[tuple[Setup, bool]] = []
        self.frames: list[Frame] = []
        self.ended: list[Episode] = []
        self.statuses: list[Mapping[str, Any]] = []
        self.notices: list[str] = []

    def setup(self, setup: Setup, live: bool) -> None:
        self.setups.append((setup, live))

    def frame(self, frame: Frame) -> None:
        self.frames.append(frame)

    def episodes(self, episodes: Sequence[Episode]) -> None:
        self.ended = list(episodes)

    def episode(self, episode: Episode) -> None:
        self.ended.append(episode)

    def playback(self, status: Mapping[str, Any]) -> None:
        self.statuses.append(status)

    def notice(self, text: str, code: str | None = None, **values: Any) -> None:
        self.notices.append(text)


async def until(condition: Callable[[], object], seconds: float = 5.0) -> None:
    """Wait until something is so, or fail."""
    async with asyncio.timeout(seconds):
        while not condition():
            await asyncio.sleep(0.002)


def end(audience: Room | Terminal, episode: Episode) -> None:
    """An episode ends: the stage tells the demonstrator, and the source who watches."""
    assert audience.controls is not None
    audience.controls.ended([episode], episode.end)
    audience.episode(episode)


STATE = np.array([0.0, 5.0, 6.0, 5.0, 6.0, 5.0, 6.0, 5.0, 6.0, 10.0, 7.8, 180.0, 90.0])
"""Of keeper 1 in `FIELD`."""
PATIENCE = round(10 * IDLE_S)
"""Decisions without a key until the person is asked."""


def nobody_decides(demonstrator: Demonstrator, decisions: int = PATIENCE) -> None:
    """Keepers ask, and no key is pressed."""
    for cycle in range(decisions):
        demonstrator.answer(STATE, {"keeper": 1, "cycle": cycle})


def played_by(demonstrator: Demonstrator, seed: int, task: Task | None = None) -> PlayStage:
    """A match in the arena that a person plays."""
    task = task or Task()
    policy = python_policy(demonstrator.answer, task.keepers, task.takers, "person")
    return open_stage(Place(ARENA), task, seed, policy)


FIELD = {"l1": (0.0, 0.0), "l2": (5.0, 0.0), "l3": (0.0, 6.0), "r1": (-5.0, 0.0), "r2": (-6.0, 0.0)}


class Stage:
    """A source that shows what a test tells it to."""

    def __init__(self) -> None:
        self.audience: Audience | None = None
        self.commands: list[tuple[str, float]] = []
        self.failure: WatchError | None = None
        self.over = asyncio.Event()

    async def run(self, audience: Audience) -> None:
        self.audience = audience
        audience.setup(SETUP, live=True)
        await self.over.wait()
        if self.failure is not None:
            raise self.failure

    def command(self, name: str, value: float) -> bool:
        self.commands.append((name, value))
        return name == "play"

    def show(self, time: int) -> None:
        """Show keeper 1 with the ball, keeper 2 to the right and keeper 3 below."""
        assert self.audience is not None
        self.audience.frame(make_frame(snapshot(time, (0.5, 0.0), **FIELD), SETUP, 1, 0))
