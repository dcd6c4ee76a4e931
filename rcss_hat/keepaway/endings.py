"""When episodes ended, as any of some players was told, and whether an end is missing among these.

The referee tells every player by a message of its own, and a network may lose, double or delay each of them. What one
player of a process has heard is therefore known to all of them. That nobody was told shows in what they see: see
`rcss_hat.keepaway.moved`. An end is not the only reason for which a referee puts players elsewhere: a ball that nobody
has moved for ``drop_ball_time`` cycles is dropped where it lies, and everybody near it has to be 9.15 m away. Where
many commands are lost, that is no rare event; every player is told of it, too.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right, insort

EARLY, LATE = 1, 3
"""Cycles before and after the two looks between which somebody was moved in which an end explains it: a trainer tells
of an end a cycle or two after it. No episode is as short as that."""
Span = tuple[int, int]
"""Cycles of two looks."""
Evidence = tuple[list[Span], list[int]]
"""Moves that nothing explained, and cycles in which the ball was dropped."""


class Endings:
    """The ends of a match's episodes; each counts once, in the order of the cycles.

    Attributes
    ----------
    cycles : list of int
        In which episodes ended, ascending.
    suspected : list of (int, int)
        Looks between which somebody was moved, and nothing that explains it was known by then.
    dropped : list of int
        Cycles in which the ball was dropped, ascending.
    """

    def __init__(self) -> None:
        self.cycles: list[int] = []
        self.suspected: list[Span] = []
        self.dropped: list[int] = []
        self._taken: dict[int, bool] = {}

    def add(self, cycle: int, taken: bool) -> None:
        """File an end: its cycle, and whether who heard of it believes that the ball was taken away."""
        if cycle not in self._taken:
            insort(self.cycles, cycle)
            self._taken[cycle] = taken

    def taken(self, cycle: int) -> bool:
        """Whether the first who heard of an end believed that the ball was taken away."""
        return self._taken[cycle]

    def drop(self, cycle: int) -> None:
        """File that the ball was dropped, which moves players and ends nothing."""
        if cycle not in self.dropped:
            insort(self.dropped, cycle)

    def evidence(self) -> Evidence:
        """Return what is to be told to others beside the ends: moves that nothing explains, and drops."""
        return list(self.suspected), list(self.dropped)

    def learn(self, evidence: Evidence) -> None:
        """Take what others have seen and heard."""
        suspected, dropped = evidence
        for cycle in dropped:
            self.drop(cycle)
        for span in suspected:
            self.suspect(*span)

    def suspect(self, since: int, until: int) -> None:
        """File that an episode has ended after one cycle and not after another, unless something explains the move."""
        if not self._explained((since, until)) and (since, until) not in self.suspected:
            self.suspected.append((since, until))

    def _explained(self, span: Span) -> bool:
        since, until = span[0] - EARLY, span[1] + LATE
        return any(bisect_left(told, since) < bisect_right(told, until) for told in (self.cycles, self.dropped))

    def unheard(self) -> list[Span]:
        """Return where ends are missing: spans of cycles that do not overlap, each with an end that nobody heard."""
        missing: list[Span] = []
        for since, until in sorted(span for span in self.suspected if not self._explained(span)):
            if missing and since < missing[-1][1] + LATE:
                missing[-1] = max(since, missing[-1][0]), min(until, missing[-1][1])  # the same end, seen by others
            else:
                missing.append((since, until))
        return missing
