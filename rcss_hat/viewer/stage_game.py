"""A match that a person plays, on a stage that waits: cycle by cycle at the person's pace."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rcss_hat.keepaway.report import Episode
from rcss_hat.numeric.aside import aside
from rcss_hat.stage.stages import Part, Stage
from rcss_hat.viewer.audience import Audience
from rcss_hat.viewer.demonstrator import Demonstrator
from rcss_hat.viewer.frames import CYCLE_S, Setup
from rcss_hat.viewer.narrator import make_frame
from rcss_hat.viewer.stage_reel import snapshot_of

PEEK = 0.05
"""Seconds between two looks whether the person has come."""
STALL = 1.0
"""Seconds after which a stopped machine does not make up for the cycles it missed."""


class StageGame:
    """A match whose keepers a person plays; a `rcss_hat.viewer.audience.Source`.

    Parameters
    ----------
    stage : Stage
        One that waits; its policy asks the demonstrator.
    demonstrator : Demonstrator
        Who decides.
    speed : float
        Times real time.
    countdown : int
        Seconds between the person's coming and the first cycle. While nobody is there, does not look, or does not
        answer, the game stands still.
    """

    def __init__(self, stage: Stage, demonstrator: Demonstrator, speed: float = 1.0, countdown: int = 0) -> None:
        self.stage, self.demonstrator, self.countdown = stage, demonstrator, countdown
        demonstrator.stops = True
        title = f"{stage.place}, seed {stage.seed}"
        self.setup = replace(Setup.from_params(title, stage.task.params()), step_s=CYCLE_S / speed)

    def command(self, name: str, value: float) -> bool:
        """Refuse: what a person plays is not stopped or sought."""
        return False

    async def run(self, audience: Audience) -> None:
        """Play until the demonstration is finished."""
        audience.notice("Compiling; this takes a while the first time.", "compiling")
        frames, _ = await aside(self._advance)
        audience.notice("")
        audience.setup(self.setup, live=True)
        audience.episodes([])
        self._show(frames, audience)
        await self._person(audience, "Begins", "begins")
        loop = asyncio.get_running_loop()
        due = loop.time()
        while not self.demonstrator.finished:
            if self.demonstrator.standing:
                await self._person(audience, "Goes on", "goes_on")
                due = loop.time()
            due = max(due + self.setup.step_s, loop.time() - STALL)
            await asyncio.sleep(max(due - loop.time(), 0.0))
            frames, ended = self._advance()
            self._show(frames, audience)
            for episode in ended:
                audience.episode(episode)

    async def _person(self, audience: Audience, what: str, code: str) -> None:
        """Wait until the person is there, and ready."""
        demonstrator, left, told = self.demonstrator, float(self.countdown), 0
        while not demonstrator.finished and (demonstrator.standing or left > 0.0):
            left = float(self.countdown) if demonstrator.standing else left - PEEK
            seconds = 0 if demonstrator.standing else math.ceil(left + PEEK / 2)
            if seconds != told:
                audience.notice(f"{what} in {seconds} ..." if seconds else "", code, seconds=seconds)
                told = seconds
            await asyncio.sleep(PEEK)
        audience.notice("")

    def _advance(self) -> tuple[list[np.void], list[Episode]]:
        """Play one cycle; returns what there was to see in it, and the episodes that ended."""
        frames, ended = list[np.void](), list[Episode]()

        def over(episodes: Sequence[Episode], cycle: int) -> None:
            ended.extend(episodes)
            self.demonstrator.ended(episodes, cycle)

        self.stage.play(Part(None, self.stage.cycle + 1, over, self.demonstrator.decided, frames.append))
        return frames, ended

    def _show(self, frames: list[np.void], audience: Audience) -> None:
        insight = self.demonstrator.insight
        for record in frames:
            episode, start = int(record["episode"]), int(record["episode_start"])
            audience.frame(make_frame(snapshot_of(record), self.setup, episode, start, insight.thought, insight.values))
