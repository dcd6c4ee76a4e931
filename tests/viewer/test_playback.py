from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest

from rcss_hat.keepaway.decision import Decision
from rcss_hat.keepaway.report import OUT, Episode
from rcss_hat.viewer.frames import Setup
from rcss_hat.viewer.narrator import Values
from rcss_hat.viewer.playback import Playback, Scene
from rcss_hat.viewer.recording import read_recording

from .audience import DATA, Remembering, snapshot, until

FIELD = {"l1": (0.0, 0.0), "l2": (5.0, 0.0), "r1": (0.0, 5.0)}


class GrowingReel:
    """Episodes of ten cycles, made five scenes at a time."""

    values: Values | None = None

    def __init__(self, length: int) -> None:
        self.setup = Setup("growing")
        self.scenes: list[Scene] = []
        self.episodes: list[Episode] = []
        self.length = length

    @property
    def complete(self) -> bool:
        return len(self.scenes) >= self.length

    async def grow(self) -> None:
        for _ in range(5):
            time = len(self.scenes)
            episode = time // 10 + 1
            thoughts = {1: Decision(time, 1, (0.0,) * 9, time % 3)}
            self.scenes.append(Scene(snapshot(time, (0.5, 0.0), **FIELD), episode, 10 * episode - 10, thoughts))
            if time and time % 10 == 0:
                self.episodes.append(Episode(episode - 1, time - 10, time, OUT))


@asynccontextmanager
async def shown(playback: Playback) -> AsyncIterator[Remembering]:
    audience = Remembering()
    task = asyncio.create_task(playback.run(audience))
    try:
        await until(lambda: audience.frames)
        yield audience
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


def log(speed: float = 1.0) -> Playback:
    return Playback(read_recording(DATA / "sample-v5.rcg.gz"), speed)


async def test_real_time_is_ten_frames_a_second() -> None:
    async with shown(log()) as audience:
        loop = asyncio.get_running_loop()
        begun, first = loop.time(), audience.frames[-1]["time"]
        await until(lambda: audience.frames[-1]["time"] >= first + 10)
        # A busy machine may leave frames out, but it keeps the pace.
        assert 0.85 < loop.time() - begun < 1.5
        times = [f["time"] for f in audience.frames]
        assert times == sorted(set(times)) and times[0] == 1
        assert audience.setups[0][1] is False


async def test_a_log_tells_all_its_episodes_at_once_and_stops_at_its_end() -> None:
    playback = log(100.0)
    async with shown(playback) as audience:
        assert len(audience.ended) == 8
        await until(lambda: not playback.playing)
        assert audience.frames[-1]["time"] == 200
        assert audience.statuses[-1] == {
            "playing": False, "speed": 100.0, "position": 199, "length": 200, "complete": True,
        }  # fmt: skip
        assert playback.command("play", 0)
        await until(lambda: audience.frames[-1]["time"] < 50)


async def test_stepping_and_seeking_stop_and_show_exactly_that_scene() -> None:
    playback = log()
    async with shown(playback) as audience:

        async def after(name: str, value: float) -> int:
            assert playback.command(name, value)
            n = len(audience.statuses)
            await until(lambda: len(audience.statuses) > n)
            return audience.frames[-1]["time"]

        assert playback.command("pause", 0)
        assert await after("seek", 99) == 100
        assert await after("step", 1) == 101
        assert await after("step", -10) == 91
        assert await after("cycle", 63) == 63
        assert audience.frames[-1]["episode"] == 4
        assert await after("episode", 1) == 103
        assert await after("episode", -1) == 63
        assert await after("step", 5) == 68
        assert await after("episode", -1) == 63
        assert await after("seek", 10**9) == 200
        assert await after("seek", -5) == 1
        shown_frames = len(audience.frames)
        await asyncio.sleep(0.15)
        assert len(audience.frames) == shown_frames


@pytest.mark.parametrize(("wanted", "speed"), [(5.0, 5.0), (0.0, 0.1), (1e9, 100.0)])
def test_speed_stays_in_its_range(wanted: float, speed: float) -> None:
    playback = log()
    assert playback.command("speed", wanted)
    assert playback.speed == speed


@pytest.mark.parametrize(("name", "value"), [("explode", 1.0), ("seek", float("nan")), ("speed", float("inf"))])
def test_what_cannot_be_done_is_refused(name: str, value: float) -> None:
    assert not log().command(name, value)


async def test_a_match_that_is_still_played_grows_ahead_of_the_picture() -> None:
    reel = GrowingReel(60)
    playback = Playback(reel, 20.0)
    async with shown(playback) as audience:
        assert audience.ended == [] and len(reel.scenes) < 60
        await until(lambda: audience.frames[-1]["time"] >= 20)
        now = audience.frames[-1]["time"]
        assert audience.ended == [e for e in reel.episodes if e.end <= now]
        assert len(reel.scenes) - now <= 12
        await until(lambda: not playback.playing)
        assert audience.frames[-1]["time"] == 59 and len(audience.ended) == 5
        assert audience.frames[-1]["seen"] and audience.frames[-1]["action"] == 59 % 3


async def test_a_growing_match_can_be_sought_up_to_its_end_and_stepped_beyond() -> None:
    reel = GrowingReel(500)
    playback = Playback(reel)
    async with shown(playback) as audience:
        playback.command("pause", 0)
        playback.command("seek", 10**9)
        await until(lambda: audience.frames[-1]["time"] >= 5)
        last = audience.frames[-1]["time"]
        playback.command("step", 1)
        await until(lambda: audience.frames[-1]["time"] == last + 1)
        assert audience.statuses[-1]["complete"] is False and len(reel.scenes) < 30
