"""Between what is watched and those who watch: what a source tells, and what it can be told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from rcss_hat.keepaway.report import Episode
from rcss_hat.viewer.frames import Frame, Setup


class Audience(Protocol):
    """Those who watch: a page with its browsers, or a terminal. Nothing here may block."""

    def setup(self, setup: Setup, live: bool) -> None:
        """Take what is watched from now on; ``live``: it cannot be stopped or sought."""

    def frame(self, frame: Frame) -> None:
        """Take the newest picture."""

    def episodes(self, episodes: Sequence[Episode]) -> None:
        """Take all episodes known so far, instead of those before."""

    def episode(self, episode: Episode) -> None:
        """Take one more episode that ended."""

    def playback(self, status: Mapping[str, Any]) -> None:
        """Take where in a recording we are: playing, speed, position, length."""

    def notice(self, text: str, code: str | None = None, **values: Any) -> None:
        """Take a remark for people; an empty one takes the last back.

        Whoever shows it in another language knows it by its code, and puts in the values.
        """


class Source(Protocol):
    """What can be watched."""

    async def run(self, audience: Audience) -> None:
        """Show it until it ends or the task is cancelled.

        Raises
        ------
        WatchError
            When there is nothing to show (any more).
        """

    def command(self, name: str, value: float) -> bool:
        """Do what a person asked for (``play``, ``pause``, ``step``, ``seek``, ``speed``); False: it cannot be done."""


class WatchError(RuntimeError):
    """What is to be watched is not there."""
