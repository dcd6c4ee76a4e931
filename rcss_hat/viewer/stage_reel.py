"""A match on a stage that waits as a reel: played some cycles ahead of what is shown."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from rcss_hat.keepaway.decision import Decision
from rcss_hat.keepaway.report import INTERRUPTED, Episode
from rcss_hat.protocol.play_modes import PLAY_MODES
from rcss_hat.protocol.records import MAX_PLAYERS
from rcss_hat.stage.stages import Part, Stage
from rcss_hat.viewer.audience import WatchError
from rcss_hat.viewer.frames import Player, Setup, Snapshot
from rcss_hat.viewer.narrator import Values
from rcss_hat.viewer.playback import Scene

CHUNK = 100
"""Cycles played at once."""
_KICKING = 0x2


class StageReel:
    """A match on a stage that waits; a `rcss_hat.viewer.playback.Reel`.

    Parameters
    ----------
    stage : Stage
    episodes : int
        Where the match ends; all its scenes stay in memory, about 1.5 kB each.
    values : callable, optional
        Q-values of the keepers.
    """

    def __init__(self, stage: Stage, episodes: int, values: Values | None = None) -> None:
        spec = stage.policy.spec if stage.policy is not None else "-"
        self.setup = Setup.from_params(f"{stage.place}, {spec}, seed {stage.seed}", stage.task.params())
        self.values = values
        self.scenes: list[Scene] = []
        self.episodes: list[Episode] = []
        self.complete = False
        self._stage, self._wanted = stage, episodes

    async def grow(self) -> None:
        """Play some cycles more; in a thread, for the first time it compiles.

        Raises
        ------
        WatchError
            When the match cannot go on, because a policy in Python failed.
        """
        report = await self._stage.run(
            Part(self._wanted, self._stage.cycle + CHUNK, self._ended, self._decided, self._seen)
        )
        if report.failure not in (None, INTERRUPTED):
            raise WatchError(report.failure)
        self.complete = len(self.episodes) >= self._wanted

    def _seen(self, frame: np.void) -> None:
        self.scenes.append(Scene(snapshot_of(frame), int(frame["episode"]), int(frame["episode_start"])))

    def _decided(self, decision: Decision) -> None:
        self.scenes[-1].thoughts[decision.keeper] = decision  # of the cycle that was seen last

    def _ended(self, episodes: Sequence[Episode], cycle: int) -> None:
        self.episodes += episodes


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
