"""The recorder of decisions: whoever decides, wherever it is played."""

from __future__ import annotations

from dataclasses import replace

from rcss_hat.hat.demonstration_writer import DemonstrationWriter
from rcss_hat.keepaway.decision import Decision
from rcss_hat.keepaway.report import Episode


class Recorder:
    """Sorts decisions into episodes, and writes those of episodes that are kept.

    Parameters
    ----------
    writer : DemonstrationWriter, optional
        Where kept episodes go.
    """

    def __init__(self, writer: DemonstrationWriter | None = None) -> None:
        self.writer = writer
        self._decisions: list[Decision] = []

    def decided(self, decision: Decision) -> None:
        """Take a decision."""
        self._decisions.append(decision)

    def correct(self, cycle: int, keeper: int, right: int | None) -> bool:
        """Note what would have been right for a decision, or that it was right; False: there is no such decision."""
        for k, d in enumerate(self._decisions):
            if (d.cycle, d.keeper) == (cycle, keeper):
                self._decisions[k] = replace(d, right=right)
                return True
        return False

    def of(self, episode: Episode) -> list[Decision]:
        """Return the decisions of an episode that is neither taken nor kept yet."""
        return self._of(episode)

    def take(self, episode: Episode) -> list[Decision]:
        """Return the decisions of an episode in order; what was decided before its end is forgotten.

        Keepers hear of the end one after another: decisions from its last cycle on belong to the next episode.
        """
        mine = self._of(episode)
        self._decisions = [d for d in self._decisions if d.cycle >= episode.end]
        return mine

    def keep(self, episode: Episode, idle: bool = False) -> None:
        """Write a finished episode; ``idle``: the person who decided pressed no key.

        Raises
        ------
        NotWritten
            When the disk is full, for example; the episode is still here, to be kept again.
        """
        if self.writer is not None:
            self.writer.drop_episode()  # what a write that failed has left
            for d in self._of(episode):
                self.writer.add(d.cycle, d.keeper, d.state, d.action, d.by, d.right)
            self.writer.end_episode(episode.start, episode.end, episode.reason, idle, episode.final)
        self.take(episode)

    def _of(self, episode: Episode) -> list[Decision]:
        mine = [d for d in self._decisions if episode.start <= d.cycle < episode.end]
        return sorted(mine, key=lambda d: (d.cycle, d.keeper))

    def forget(self) -> None:
        """Forget what was decided."""
        self._decisions = []
