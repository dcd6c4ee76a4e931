"""Episodes that have ended and are not written yet: some may still be dropped, and some wait for a sign of life."""

from __future__ import annotations

from dataclasses import dataclass

from rcss_hat.hat.recorder import Recorder
from rcss_hat.keepaway.report import Episode


@dataclass(slots=True)
class Finished:
    """An episode that has ended.

    Attributes
    ----------
    episode : Episode
    idle : bool
        The person did nothing in it.
    dropped : bool
    """

    episode: Episode
    idle: bool
    dropped: bool = False


class Shelf:
    """Keeps what has ended until it is written, or dropped for good.

    The last episode waits until the next one has ended, so that it can be dropped. Idle episodes wait for a sign of
    life: whoever has gone away demonstrates nothing.

    Parameters
    ----------
    recording : Recorder
    at_once : bool
        Write an episode as soon as it has ended; it cannot be dropped then.

    Attributes
    ----------
    written : int
        How many were written, or only played where nothing is recorded.
    dropped : int
        How many were dropped for good.
    """

    def __init__(self, recording: Recorder, at_once: bool = False) -> None:
        self.written, self.dropped = 0, 0
        self._recording, self._at_once = recording, at_once
        self._waiting: list[Finished] = []

    def put(self, episode: Episode, idle: bool) -> None:
        """Take an episode that has ended, and write what need not wait any longer."""
        self._waiting.append(Finished(episode, idle))
        self.settle(max(self.idle, 0 if self._at_once else 1))

    @property
    def waiting(self) -> int:
        """How many will be written."""
        return sum(not e.dropped for e in self._waiting)

    @property
    def idle(self) -> int:
        """How many wait for a sign of life: idle ones, one after the other, up to the last."""
        active = [k for k, e in enumerate(self._waiting) if not e.idle]
        return len(self._waiting) - (active[-1] + 1 if active else 0)

    @property
    def last(self) -> Finished | None:
        """The one that can be dropped."""
        return None if self._at_once or not self._waiting else self._waiting[-1]

    def settle(self, but: int = 0) -> None:
        """Write all but the newest."""
        while len(self._waiting) > but:
            oldest = self._waiting[0]
            if oldest.dropped:
                self.dropped += 1
                self._recording.take(oldest.episode)
            else:
                self._recording.keep(oldest.episode, oldest.idle)
                self.written += 1
            # Not before: a full disk may have room again when the demonstration is closed.
            self._waiting.pop(0)

    def leave_idle(self) -> None:
        """Drop what waits for a sign of life that does not come."""
        for e in self._waiting[len(self._waiting) - self.idle :]:
            e.dropped = True
