"""A match in the arena as a reel: played some cycles ahead of what is shown."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from rcss_hat.arena.match import ArenaMatch
from rcss_hat.hat.policy import TeamPolicy
from rcss_hat.keepaway.report import Episode
from rcss_hat.keepaway.task import Task
from rcss_hat.numeric.aside import aside
from rcss_hat.protocol.play_modes import PLAY_MODES
from rcss_hat.protocol.records import MAX_PLAYERS
from rcss_hat.viewer.frames import Player, Setup, Snapshot
from rcss_hat.viewer.narrator import Thought, Values
from rcss_hat.viewer.playback import Scene

CHUNK = 100
"""Cycles played at once."""
_KICKING = 0x2


class ArenaReel:
    """A match of the arena; a `rcss_hat.viewer.playback.Reel`.

    Parameters
    ----------
    task : Task
    seed : int
    policy : TeamPolicy
    episodes : int
        Where the match ends; all its scenes stay in memory, about 1.5 kB each.
    values : callable, optional
        Q-values of the keepers.
    title : str, optional
    """

    def __init__(
        self,
        task: Task,
        seed: int,
        policy: TeamPolicy,
        episodes: int,
        values: Values | None = None,
        title: str | None = None,
    ) -> None:
        self.setup = Setup.from_params(title or f"arena, {policy.spec}, seed {seed}", task.params())
        self.values = values
        self.scenes: list[Scene] = []
        self.episodes: list[Episode] = []
        self.complete = False
        self._wanted = episodes
        self._match = ArenaMatch(task, seed, policy, log_decisions=True, log_frames=True)

    async def grow(self) -> None:
        """Play some cycles more; in a thread, for the first time it compiles."""
        await aside(self._play)

    def _play(self) -> None:
        match = self._match
        for finished in match.advance(cycles=match.cycle + CHUNK, episodes=self._wanted):
            self.episodes += finished
        thoughts: dict[int, dict[int, Thought]] = {}
        for d in match.take_decisions():
            cycle = int(d["cycle"])
            thought = Thought(cycle, tuple(map(float, d["state"])), int(d["action"]))
            thoughts.setdefault(cycle, {})[int(d["keeper"])] = thought
        self.scenes += [_scene(frame, thoughts.get(int(frame["time"]), {})) for frame in match.take_frames()]
        self.complete = len(self.episodes) >= self._wanted


def snapshot_of(frame: Any) -> Snapshot:
    """Make a snapshot of one record of dtype `rcss_hat.arena.records.FRAME`."""
    players = []
    for i in np.flatnonzero(frame["enabled"]):
        unum = int(i) % MAX_PLAYERS + 1
        x, y = frame["pos"][i]
        players.append(
            Player(
                "l" if i < MAX_PLAYERS else "r",
                unum,
                round(float(x), 4),
                round(float(y), 4),
                round(math.degrees(frame["body"][i]), 3),
                round(math.degrees(frame["neck"][i]), 3),
                float(frame["stamina"][i]),
                bool(frame["flags"][i] & _KICKING),
            )
        )
    x, y, vx, vy = (float(v) for v in frame["ball"])
    return Snapshot(int(frame["time"]), PLAY_MODES[int(frame["mode"])], (x, y, vx, vy), tuple(players))


def _scene(frame: Any, thoughts: dict[int, Thought]) -> Scene:
    return Scene(snapshot_of(frame), int(frame["episode"]), int(frame["episode_start"]), thoughts)
