"""Yellow and red cards, which monitors show to players.

Source: 19.0.0, src/stadium.cpp and src/player.cpp (yellowCard, redCard, substitute). No referee here shows
any, so that they are plain Python around the compiled step.
"""

from __future__ import annotations

from collections import Counter

import numpy as np
from numpy.typing import NDArray

from rcss_hat.protocol.records import MAX_PLAYERS
from rcss_hat.simulation.state import F_RED_CARD, F_YELLOW_CARD

_SENT_OFF = 2


class Cards:
    """Who has been shown what.

    Parameters
    ----------
    match : ndarray of MATCH, shape (1,)
    """

    def __init__(self, match: NDArray[np.void]) -> None:
        self._match = match
        self._count: Counter[int] = Counter()
        self._flags: dict[int, int] = {}

    def give(self, i: int, card: str) -> list[str]:
        """Show a player a yellow or red card; returns what the referee announces.

        Whoever is `sent_off` by it has to be taken off the field.
        """
        who = f"{'l' if i < MAX_PLAYERS else 'r'}_{i % MAX_PLAYERS + 1}"
        announced = [f"{card}_card_{who}"]
        self._count[i] += 1 if card == "yellow" else _SENT_OFF
        if card == "yellow" and self.sent_off(i):
            announced.append(f"red_card_{who}")
        self._flags[i] = F_RED_CARD if self.sent_off(i) else F_YELLOW_CARD
        return announced

    def sent_off(self, i: int) -> bool:
        """Tell whether a player has a red card, or two yellow ones."""
        return self._count[i] >= _SENT_OFF

    def shown(self, i: int) -> str:
        """Return the card that counts against a player: y, r, or nothing."""
        return "r" if self.sent_off(i) else "y" if self._count[i] else ""

    def returned(self, i: int) -> None:
        """Note that a player is back: frames show no card any more, but it counts."""
        self._flags.pop(i, None)

    def substituted(self, i: int) -> None:
        """Forget the cards of a player who gets another type, as the original does."""
        self._flags.pop(i, None)
        del self._count[i]

    def mark(self) -> None:
        """Let the frame of a step, whose flags begin anew, show the cards."""
        for i, flags in self._flags.items():
            self._match["flags"][0, i] |= flags
