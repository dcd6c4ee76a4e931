"""A match in the arena that a person plays: cycle by cycle at a person's pace, without a server."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.arena.match import ArenaMatch
from rcss_hat.hat.policy import TeamPolicy
from rcss_hat.keepaway.report import Episode
from rcss_hat.keepaway.task import Task
from rcss_hat.numeric.aside import aside
from rcss_hat.viewer.arena_reel import snapshot_of
from rcss_hat.viewer.audience import Audience
from rcss_hat.viewer.demonstration import Demonstration
from rcss_hat.viewer.frames import CYCLE_S, Setup
from rcss_hat.viewer.narrator import make_frame

PEEK = 0.05
"""Seconds between two looks whether the person has come."""
STALL = 1.0
"""Seconds after which a stopped machine does not make up for the cycles it missed."""


class ArenaGame:
    """A match of the arena whose keepers a person plays; a `rcss_hat.viewer.audience.Source`.

    Parameters
    ----------
    task : Task
    seed : int
    policy : TeamPolicy
        Gives the arena its random streams; the person decides.
    demonstration : Demonstration
        Who decides.
    speed : float
        Times real time.
    countdown : int
        Seconds between the person's coming and the first cycle. While nobody is there, the game stands still.
    """

    def __init__(
        self,
        task: Task,
        seed: int,
        policy: TeamPolicy,
        demonstration: Demonstration,
        speed: float = 1.0,
        countdown: int = 0,
    ) -> None:
        self.demonstration, self.countdown = demonstration, countdown
        self.setup = replace(Setup.from_params(f"arena, seed {seed}", task.params()), step_s=CYCLE_S / speed)
        self._match = ArenaMatch(task, seed, policy, external=self._decide, log_frames=True)

    def command(self, name: str, value: float) -> bool:
        """Refuse: what a person plays is not stopped or sought."""
        return False

    def _decide(self, state: NDArray[np.float64], info: dict[str, Any]) -> int:
        return self.demonstration.decide(info["keeper"], info["cycle"], info["status"], info["reward"], state)

    async def run(self, audience: Audience) -> None:
        """Play until the demonstration is finished."""
        audience.notice("Compiling; this takes a while the first time.")
        await aside(self._advance)
        audience.notice("")
        audience.setup(self.setup, live=True)
        audience.episodes([])
        self._show(audience)
        await self._person(audience)
        loop = asyncio.get_running_loop()
        due = loop.time()
        while not self.demonstration.finished:
            if self.demonstration.away:
                await self._person(audience)
                due = loop.time()
            due = max(due + self.setup.step_s, loop.time() - STALL)
            await asyncio.sleep(max(due - loop.time(), 0.0))
            ended = self._advance()
            self._show(audience)
            for episode in ended:
                audience.episode(episode)

    async def _person(self, audience: Audience) -> None:
        """Wait until the person is there, and ready."""
        while self.demonstration.away and not self.demonstration.finished:
            await asyncio.sleep(PEEK)
        for left in range(self.countdown, 0, -1):
            audience.notice(f"Begins in {left} ...")
            await asyncio.sleep(1.0)
        audience.notice("")

    def _advance(self) -> list[Episode]:
        """Play one cycle; returns the episodes that ended."""
        return [e for chunk in self._match.advance(cycles=self._match.cycle + 1) for e in chunk]

    def _show(self, audience: Audience) -> None:
        insight = self.demonstration.insight
        for record in self._match.take_frames():
            episode, start = int(record["episode"]), int(record["episode_start"])
            audience.frame(make_frame(snapshot_of(record), self.setup, episode, start, insight.thought, insight.values))
