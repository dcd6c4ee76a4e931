"""What a taker is told to do by whoever decides for him, and how long that lasts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.keepaway.agent import NO_DECISION
from rcss_hat.keepaway.decision import Decide, legal_order
from rcss_hat.keepaway.taker import HAND_CODED
from rcss_hat.keepaway.taker_state import n_taker_variables, taker_state_variables


class Orders:
    """The macro-actions of one taker, asked for anew when the last one has lasted long enough.

    Parameters
    ----------
    n_keepers, n_takers : int
    lasts : int
        Cycles from one decision to the next.
    """

    def __init__(self, n_keepers: int, n_takers: int, lasts: int) -> None:
        self._n_keepers, self._lasts = n_keepers, lasts
        self._state = np.zeros(n_taker_variables(n_keepers, n_takers))
        self._order, self._until = HAND_CODED, 0

    def forget(self) -> None:
        """Ask again in the next cycle: an episode begins."""
        self._until = 0

    def told(self, decide: Decide | None, cycle: int, agent: NDArray[np.void]) -> int:
        """Return what a taker does: as hand-coded when nobody decides, or he does not know where everybody is.

        Parameters
        ----------
        decide : callable or None
        cycle : int
        agent : AGENT, shape (1,)
            What he believes.
        """
        if decide is None:
            return HAND_CODED
        if cycle >= self._until:
            if not taker_state_variables(agent, self._state):
                return HAND_CODED
            answer = decide(cycle, NO_DECISION, 0.0, self._state)
            self._order, self._until = legal_order(answer, self._n_keepers), cycle + self._lasts
        return self._order
