"""What a team's keepers believe at the ends of episodes, over UDP; in the arena the loop looks back itself."""

from __future__ import annotations

import numpy as np

from rcss_hat.keepaway.agent import new_agent
from rcss_hat.keepaway.decision import Believer, Decision
from rcss_hat.keepaway.state import n_state_variables, state_variables
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.records import LEFT


class FinalStates:
    """Takes down the final state of every episode; an `Onlooker` of the keepers, who is told their decisions, too.

    When the first of them hears of an end, all still believe what was before: the referee has moved nobody yet, as far
    as they have seen.

    Parameters
    ----------
    task : Task
    """

    def __init__(self, task: Task) -> None:
        self._task = task
        self._seen: dict[int, Believer] = {}
        self._last = (-1, 1)  # cycle and keeper of the last decision
        self._finals: dict[int, tuple[float, ...] | None] = {}

    def warm_up(self) -> None:
        """Compile what is looked at, before a server waits for an answer."""
        keepers, takers = self._task.keepers, self._task.takers
        agent = new_agent(LEFT, 1, keepers, takers, self._task.params().record(), 0)
        state_variables(agent, np.zeros(n_state_variables(keepers, takers)))

    def decided(self, decision: Decision) -> None:
        """Take a decision."""
        self._last = max(self._last, (decision.cycle, decision.keeper))

    def acted(self, player: Believer) -> None:
        """See `Onlooker.acted`."""
        self._seen[player.unum] = player

    def ended(self, player: Believer, cycle: int, taken: bool) -> None:
        """See `Onlooker.ended`."""
        if cycle not in self._finals:
            self._finals[cycle] = self._look_back()

    def _look_back(self) -> tuple[float, ...] | None:
        """Return what the keeper who decided last believes, or the first who knows where all are."""
        last = self._last[1]
        for unum in (last, *(k for k in sorted(self._seen) if k != last)):
            beliefs = self._seen[unum].beliefs if unum in self._seen else None
            state = np.zeros(n_state_variables(self._task.keepers, self._task.takers))
            if beliefs is not None and state_variables(beliefs.copy(), state):
                return tuple(state.tolist())
        return None

    def take(self, end: int) -> tuple[float, ...] | None:
        """Return the final state of the episode that ended then, None where nobody knew it, and forget earlier ones."""
        final = self._finals.get(end)
        self._finals = {cycle: state for cycle, state in self._finals.items() if cycle > end}
        return final
