"""Milliseconds since a participant began, whatever is done to the computer's clock."""

from __future__ import annotations

import time
from collections.abc import Callable
from datetime import UTC, datetime

Now = Callable[[], float]


class Clock:
    """Counts milliseconds since a participant's beginning; it never goes back.

    While the program runs, time goes by the machine's monotonic clock. Across a restart it goes by the time of day, and
    where that was set back in between, from what was counted last.

    Parameters
    ----------
    begun : float
        Time of day of the beginning, seconds since 1970.
    counted : int
        Milliseconds that were counted before, by an earlier run of the program.
    day, steady : callable
        Time of day, and a clock that is never set; seconds.

    Attributes
    ----------
    origin : float
        What the steady clock showed at the beginning; other processes of this machine have the same.
    """

    def __init__(self, begun: float, counted: int = 0, day: Now = time.time, steady: Now = time.monotonic) -> None:
        self._day, self._steady = day, steady
        self.origin = steady() - max(day() - begun, counted / 1000.0)

    def ms(self) -> int:
        """Milliseconds since the beginning."""
        return since(self.origin, self._steady())

    def utc(self, ms: int) -> str:
        """Time of day of a count, by the clock as it is set now; see `utc_text`."""
        return utc_text(self._day() - (self.ms() - ms) / 1000.0)


def since(origin: float, steady: float) -> int:
    """Milliseconds from one reading of the steady clock to another."""
    return round((steady - origin) * 1000.0)


def utc_text(seconds: float) -> str:
    """Write a time of day: ``2026-11-29T13:00:00.250Z``."""
    return datetime.fromtimestamp(seconds, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def utc_seconds(text: str) -> float:
    """Read what `utc_text` wrote.

    Raises
    ------
    ValueError
    """
    return datetime.fromisoformat(text).timestamp()
