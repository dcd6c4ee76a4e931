"""Playing what can be stopped and sought: game logs, and matches in the arena."""

from __future__ import annotations

import asyncio
import contextlib
import math
from dataclasses import dataclass, field
from typing import Protocol

from rcss_hat.keepaway.decision import Decision
from rcss_hat.keepaway.report import Episode
from rcss_hat.viewer.audience import Audience
from rcss_hat.viewer.frames import Frame, Setup, Snapshot
from rcss_hat.viewer.narrator import Values, make_frame

SLOWEST, FASTEST = 0.1, 100.0
TICK = 1.0 / 60.0
"""Seconds between two pictures at least; faster play leaves frames out."""
STALL = 1.0
"""Seconds after which a stopped machine does not make up for the pictures it missed."""


@dataclass(frozen=True, slots=True)
class Scene:
    """A snapshot with its place in the match.

    Attributes
    ----------
    snapshot : Snapshot
    episode, start : int
        Number and first cycle of the episode it belongs to.
    thoughts : dict
        What keepers (by uniform number) saw and chose, where that is known.
    """

    snapshot: Snapshot
    episode: int
    start: int
    thoughts: dict[int, Decision] = field(default_factory=dict)


class Reel(Protocol):
    """Scenes of a match, in order of time; more may come."""

    setup: Setup
    scenes: list[Scene]
    episodes: list[Episode]
    complete: bool
    values: Values | None

    async def grow(self) -> None:
        """Make more scenes, or become complete."""


class Playback:
    """Plays a reel; a `rcss_hat.viewer.audience.Source`.

    Parameters
    ----------
    reel : Reel
    speed : float
        Times real time.

    Attributes
    ----------
    playing : bool
    position : int
        Index of the scene that is shown.
    """

    def __init__(self, reel: Reel, speed: float = 1.0) -> None:
        self.reel = reel
        self.speed = min(max(speed, SLOWEST), FASTEST)
        self.playing = True
        self.position = 0
        self._told = 0
        self._changed = asyncio.Event()

    def command(self, name: str, value: float) -> bool:
        """Do what a person asked for.

        Parameters
        ----------
        name : {"play", "pause", "step", "seek", "cycle", "episode", "speed"}
        value : float
            Scenes to step, index of a scene, a cycle, episodes to go on or back, times real time.
        """
        if not math.isfinite(value):
            return False
        last = max(len(self.reel.scenes) - 1, 0)
        if name == "play":
            self.playing = True
            if self.position >= last and self.reel.complete:
                self.position = 0
        elif name == "pause":
            self.playing = False
        elif name == "step":
            self.playing = False
            self._go(self.position + int(value))
        elif name == "seek":
            self._go(int(value))
        elif name == "cycle":
            self._go(self._index(int(value)))
        elif name == "episode":
            self._go(self._episode_begin(int(value)))
        elif name == "speed":
            self.speed = min(max(value, SLOWEST), FASTEST)
        else:
            return False
        self._changed.set()
        return True

    def _go(self, position: int) -> None:
        last = len(self.reel.scenes) - 1 if self.reel.complete else len(self.reel.scenes)
        self.position = min(max(position, 0), max(last, 0))

    def _index(self, cycle: int) -> int:
        """Index of the first scene of a cycle or of one after it."""
        scenes = self.reel.scenes
        low, high = 0, len(scenes)
        while low < high:
            middle = (low + high) // 2
            if scenes[middle].snapshot.time < cycle:
                low = middle + 1
            else:
                high = middle
        return low

    def _episode_begin(self, step: int) -> int:
        """Index of the begin of the next episode, or of this one, or of the one before when we are at its begin."""
        scenes = self.reel.scenes
        if not scenes:
            return 0
        here = min(self.position, len(scenes) - 1)
        number = scenes[here].episode
        at_begin = here == 0 or scenes[here - 1].episode != number
        wanted = number + step if step > 0 or at_begin else number + step + 1
        for index, scene in enumerate(scenes):
            if scene.episode >= wanted:
                return index
        return len(scenes) - 1

    async def run(self, audience: Audience) -> None:
        """Play until cancelled."""
        await self._fill()
        audience.setup(self.reel.setup, live=False)
        audience.episodes([])
        self._tell_episodes(audience)
        loop = asyncio.get_running_loop()
        while True:
            self._changed.clear()
            self._show(audience)
            begun, first, period = loop.time(), self.position, self.reel.setup.step_s / self.speed
            while self.playing and not self._changed.is_set():
                due = begun + (self.position + 1 - first) * period
                await self._pause(max(due - loop.time(), TICK))
                if self._changed.is_set():
                    break
                now = loop.time()
                if now - due > STALL:
                    break
                await self._advance(first + int((now - begun) / period), audience)
            if not self.playing:
                await self._changed.wait()
            await self._fill()

    async def _pause(self, seconds: float) -> None:
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                await self._changed.wait()

    async def _advance(self, target: int, audience: Audience) -> None:
        if target <= self.position:
            return
        self.position = target
        await self._fill()
        if self.position >= len(self.reel.scenes) - 1:
            self.position = len(self.reel.scenes) - 1
            if self.reel.complete:
                self.playing = False
        self._show(audience)

    async def _fill(self) -> None:
        """See that the scene at our position and the next one are there, if there are any."""
        while self.position + 1 >= len(self.reel.scenes) and not self.reel.complete:
            await self.reel.grow()

    def _show(self, audience: Audience) -> None:
        if not self.reel.scenes:
            return
        self.position = min(self.position, len(self.reel.scenes) - 1)
        audience.frame(self.frame(self.position))
        self._tell_episodes(audience)
        audience.playback(
            {
                "playing": self.playing,
                "speed": self.speed,
                "position": self.position,
                "length": len(self.reel.scenes),
                "complete": self.reel.complete,
            }
        )

    def frame(self, position: int) -> Frame:
        """Make the frame of a scene."""
        scene = self.reel.scenes[position]

        def thought(keeper: int, time: int) -> Decision | None:
            return scene.thoughts.get(keeper)

        return make_frame(scene.snapshot, self.reel.setup, scene.episode, scene.start, thought, self.reel.values)

    def _tell_episodes(self, audience: Audience) -> None:
        """Tell the episodes of a log at once, those of a match that goes on as they end."""
        episodes = self.reel.episodes
        now = self.reel.scenes[self.position].snapshot.time if self.reel.scenes else 0
        if self._told == 0 and self.reel.complete and episodes:
            audience.episodes(episodes)
            self._told = len(episodes)
        while self._told < len(episodes) and episodes[self._told].end <= now:
            audience.episode(episodes[self._told])
            self._told += 1
