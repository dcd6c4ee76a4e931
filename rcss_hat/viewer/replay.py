"""An episode that is looked at again, so that the person can say what would have been right."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rcss_hat.keepaway.decision import Decision
from rcss_hat.keepaway.report import Episode
from rcss_hat.viewer.frames import Frame

LONGEST = 900
"""Pictures of the end of an episode that are kept: a minute and a half."""


class Film:
    """Keeps the pictures of the running episode."""

    def __init__(self) -> None:
        self._frames: list[Frame] = []

    def take(self, frame: Frame) -> None:
        """Keep a picture."""
        self._frames.append(frame)
        del self._frames[:-LONGEST]

    def cut(self, episode: Episode, decisions: Sequence[Decision], actions: Sequence[int]) -> dict[str, Any]:
        """Return an episode that has ended as pages are told it, and begin with the next one.

        Parameters
        ----------
        episode : Episode
        decisions : sequence of Decision
            Of the episode.
        actions : sequence of int
            Those that can be called right.

        Returns
        -------
        dict
            ``episode`` (its number), ``frames``, ``actions``, and ``decisions``, each with ``cycle``, ``keeper``,
            ``action``, ``by`` and ``right``.
        """
        frames, self._frames = self._frames, []
        told = [
            {"cycle": d.cycle, "keeper": d.keeper, "action": d.action, "by": d.by or None, "right": d.right}
            for d in decisions
        ]
        shown = [frame for frame in frames if episode.start <= frame["time"] <= episode.end]
        return {"episode": episode.number, "frames": shown, "actions": list(actions), "decisions": told}
