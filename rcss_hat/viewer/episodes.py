"""Episodes from what can be seen: a referee's view rebuilt from snapshots.

Monitors and game logs do not tell when a Keepaway episode ends. But the server then puts the ball back exactly on its
spot, at rest, where no play brings it; and when it was still there, the players into their corners, farther than
anybody can move. Why it ended follows from the referee's own count: rcssserver (19.0.0, src/referee.cpp, KeepawayRef)
counts the cycles in which a taker can kick the ball, and takes the count back to 0 when only a keeper can.
"""

from __future__ import annotations

import math

from rcss_hat.keepaway.report import OUT, TAKEN, Episode
from rcss_hat.viewer.frames import Setup, Snapshot

CORNER = 4.0
"""The ball starts so far inside the corner at negative x and y, metres."""
TURNOVER_TIME = 4
"""Cycles of a taker's possession that end an episode."""
_PLAYER_STEP = 2.0
"""What no player can move within one cycle, collisions included, metres."""


class EpisodeTracker:
    """Follows the episodes of a match, snapshot by snapshot.

    Parameters
    ----------
    setup : Setup

    Attributes
    ----------
    number : int
        Of the running episode, from 1; 0 when we came in the middle of one.
    start : int
        Cycle in which it began, or in which we came.
    """

    def __init__(self, setup: Setup) -> None:
        self.setup = setup
        self.number, self.start = 0, 0
        self._spot = (CORNER - setup.length / 2.0, CORNER - setup.width / 2.0)
        self._before: Snapshot | None = None
        self._taken = 0

    def see(self, now: Snapshot) -> Episode | None:
        """Take the next snapshot.

        Returns
        -------
        Episode or None
            The episode that ended with it, if one did whose begin was seen.
        """
        before, self._before = self._before, now
        if not self.setup.keepaway:
            return None
        if before is None or now.time < before.time:
            # The first step of a match shows cycle 1 with the ball on its spot; the match began with cycle 0.
            self._begin(0 if now.time <= 1 else now.time, known=now.time <= 1 and self._at_start(now))
            return None
        if before.mode != now.mode and now.mode == "play_on" and self._at_start(now):
            self._begin(before.time, known=True)
            return None
        if now.mode != "play_on" or now.time == before.time:
            return None
        if not self._at_start(now) or (self._at_start(before) and not _jumped(before, now)):
            self._count(now)
            return None
        ended = Episode(self.number, self.start, now.time, self._reason(before, now)) if self.number else None
        self._begin(now.time, known=True)
        return ended

    def _begin(self, start: int, known: bool) -> None:
        self.number = self.number + 1 if known else self.number
        self.start, self._taken = start, 0

    def _at_start(self, now: Snapshot) -> bool:
        x, y, vx, vy = now.ball
        return abs(x - self._spot[0]) < 1e-3 and abs(y - self._spot[1]) < 1e-3 and vx == 0.0 and vy == 0.0

    def _count(self, now: Snapshot) -> None:
        """Count as the referee does: takers first, a keeper alone takes the count back."""
        reach = self.setup.reach
        near = {p.side for p in now.players if math.hypot(p.x - now.ball[0], p.y - now.ball[1]) < reach}
        if "r" in near:
            self._taken += 1
        elif "l" in near:
            self._taken = 0

    def _reason(self, before: Snapshot, now: Snapshot) -> str:
        """Tell why an episode ended; the referee looks at the ball's position first."""
        missed = now.time - before.time - 1
        if self._taken + missed < TURNOVER_TIME:
            return OUT
        x, y, vx, vy = before.ball
        inside = abs(x + vx) < self.setup.length / 2.0 and abs(y + vy) < self.setup.width / 2.0
        return TAKEN if inside else OUT


def _jumped(before: Snapshot, now: Snapshot) -> bool:
    """Tell whether a player is where he cannot have gone."""
    reach = _PLAYER_STEP * (now.time - before.time)
    places = {p.id: p for p in before.players}
    return any(p.id in places and math.hypot(p.x - places[p.id].x, p.y - places[p.id].y) > reach for p in now.players)
