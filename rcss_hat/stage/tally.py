"""Which episodes of a match count: those that began when everybody was there."""

from __future__ import annotations

from typing import Protocol

from rcss_hat.keepaway.report import OUT, TAKEN, Episode
from rcss_hat.protocol.params import Value

NOT_YET = 2**31 - 1


class Heard(Protocol):
    """What one player has heard of the match; a `KeepawayPlayer`, or the mirror of one in another process."""

    team: str
    told: dict[str, Value]
    mode: str
    stopped_by: str
    first_cycle: int
    cycle: int
    episodes: list[tuple[int, bool]]


class Tally:
    """The episodes of a match, as a player hears them begin and end.

    Parameters
    ----------
    player : Heard
    wanted : int or None
        How many to count at most.

    Attributes
    ----------
    after : int or None
        None: the first episode begins with the kick-off. Otherwise somebody played here before, or players came later
        than others: the first episode begins with the first end of an episode from this cycle on.
    start : int or None
        Cycle in which the first episode began, where that is known.
    until : int
        Episodes that end later do not count.
    """

    def __init__(self, player: Heard, wanted: int | None) -> None:
        self.player, self.wanted = player, wanted
        self.after: int | None = None
        self.start: int | None = None
        self.until = NOT_YET

    def _begin(self) -> tuple[int, int] | None:
        """Cycle in which the first episode began, and how many ends came no later; None before."""
        if self.start is not None:
            return self.start, sum(end <= self.start for end, _ in self.player.episodes)
        if self.after is None:
            return self.player.first_cycle, 0
        for k, (end, _) in enumerate(self.player.episodes):
            if end >= self.after:
                return end, k + 1
        return None

    @property
    def begun(self) -> bool:
        """Whether episodes count by now."""
        return self._begin() is not None

    @property
    def running_since(self) -> int | None:
        """Cycle in which the running episode began; None while none counts."""
        begin = self._begin()
        if begin is None:
            return None
        ended = self.player.episodes[begin[1] :]
        return ended[-1][0] if ended else begin[0]

    @property
    def finished(self) -> int:
        """How many episodes have ended."""
        begin = self._begin()
        return 0 if begin is None else len(self.player.episodes) - begin[1]

    def episodes(self) -> list[Episode]:
        """Episodes that have ended; the reasons are what the player believed."""
        begin = self._begin()
        if begin is None:
            return []
        start, first = begin
        counted = []
        for number, (end, taken) in enumerate(self.player.episodes[first:], 1):
            if end > self.until or (self.wanted is not None and number > self.wanted):
                break
            counted.append(Episode(number, start, end, TAKEN if taken else OUT))
            start = end
        return counted

    @property
    def cycles(self) -> int:
        """Cycles since the first episode began; the end of an episode is heard before the cycle's sense_body."""
        begin = self._begin()
        if begin is None:
            return 0
        last = self.player.episodes[-1][0] if self.player.episodes else 0
        return max(0, max(self.player.cycle, last) - begin[0])
