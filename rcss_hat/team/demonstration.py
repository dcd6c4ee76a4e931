"""Recording what a team's policy decides, over UDP."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.demonstration_writer import DemonstrationWriter
from rcss_hat.keepaway.decision import Decide, EpisodeEnd, KeeperPolicy, hold_cycles_of
from rcss_hat.keepaway.report import Episode

Decision = tuple[int, int, NDArray[np.float64], int]


class DemonstrationRecorder:
    """Stands between the keepers and the policy that teaches, and writes down every decision.

    Parameters
    ----------
    writer : DemonstrationWriter
    teacher : callable
        The policy that decides.
    """

    def __init__(self, writer: DemonstrationWriter, teacher: KeeperPolicy) -> None:
        self.writer, self.teacher, self.hold_cycles = writer, teacher, hold_cycles_of(teacher)
        self._decisions: list[Decision] = []

    def __call__(self, number: int) -> tuple[Decide, EpisodeEnd | None]:
        """Return the recorded policy of one keeper (from 0)."""
        decide, ended = self.teacher(number)

        def recorded(cycle: int, status: int, reward: float, state: NDArray[np.float64]) -> int:
            action = decide(cycle, status, reward, state)
            self._decisions.append((cycle, number + 1, state.copy(), action))
            return action

        return recorded, ended

    def end_episode(self, episode: Episode, keep: bool = True) -> None:
        """Write the decisions of a finished episode.

        Keepers hear of the end one after another: decisions from its last cycle on belong to the next episode.
        """
        mine = sorted((d for d in self._decisions if d[0] < episode.end), key=lambda d: d[:2])
        self._decisions = [d for d in self._decisions if d[0] >= episode.end]
        if not keep:
            return
        for cycle, keeper, state, action in mine:
            self.writer.add(cycle, keeper, state, action)
        self.writer.end_episode(episode.start, episode.end, episode.reason)
