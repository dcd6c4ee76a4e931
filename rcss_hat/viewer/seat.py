"""Who of those who have the page open plays; no sockets and clocks.

The first browser takes the seat and keeps it while it looks: a browser whose pages are all closed leaves the seat free,
and one whose pages are all hidden, or stand behind a dialog, can be replaced by whoever asks for the seat.
"""

from __future__ import annotations

PLAYER, WATCHER = "player", "watcher"
FREE, LEFT, TAKEN = "free", "left", "taken"
"""Nobody has the seat; who has it does not look; who has it looks."""


class Visitor:
    """One open page.

    Attributes
    ----------
    session : str
        Of its browser; a browser may have several pages open.
    looking : bool
        Whether somebody sees the page, and no dialog covers it.
    """

    def __init__(self, session: str) -> None:
        self.session, self.looking = session, True


class Seat:
    """The seat of the one who plays.

    Attributes
    ----------
    owner : str or None
        Session of the browser that has it.
    """

    def __init__(self) -> None:
        self.owner: str | None = None
        self._visitors: set[Visitor] = set()

    def enter(self, visitor: Visitor) -> None:
        """Count a page; a free seat is its browser's."""
        self._visitors.add(visitor)
        if self.owner is None:
            self.owner = visitor.session

    def leave(self, visitor: Visitor) -> None:
        """Count a page no more; the seat stays its browser's until it is given up."""
        self._visitors.discard(visitor)

    def take(self, session: str) -> bool:
        """Give the seat to a browser that asks for it; False while who has it is playing."""
        if session != self.owner and self.state == TAKEN:
            return False
        self.owner = session
        return True

    def give_up(self) -> bool:
        """Free the seat when its browser is gone; tells whether that was so."""
        if self.owner is None or self.occupied:
            return False
        self.owner = None
        return True

    def role(self, visitor: Visitor) -> str:
        """Tell whether a page plays or watches."""
        return PLAYER if visitor.session == self.owner else WATCHER

    @property
    def occupied(self) -> bool:
        """Whether a page of the seat's browser is open."""
        return any(v.session == self.owner for v in self._visitors)

    @property
    def looking(self) -> bool:
        """Whether one of these pages is seen."""
        return any(v.session == self.owner and v.looking for v in self._visitors)

    @property
    def state(self) -> str:
        """`FREE`, `LEFT` or `TAKEN`."""
        if self.owner is None:
            return FREE
        return TAKEN if self.looking else LEFT
