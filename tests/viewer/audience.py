"""What the viewer's tests share: recorded data, players placed by hand, and an audience that remembers."""

from __future__ import annotations

import asyncio
import gzip
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from rcss_hat.keepaway.report import Episode
from rcss_hat.viewer.frames import Frame, Player, Setup, Snapshot

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

    def notice(self, text: str) -> None:
        self.notices.append(text)


async def until(condition: Callable[[], object], seconds: float = 5.0) -> None:
    """Wait until something is so, or fail."""
    async with asyncio.timeout(seconds):
        while not condition():
            await asyncio.sleep(0.002)
