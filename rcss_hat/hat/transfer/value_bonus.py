"""Value Bonus: the action that D advises is worth B cycles more (HAT paper, section 3.1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.transfer.method import NO_ADVICE, TransferMethod, check_count, check_number
from rcss_hat.learning.exploration import epsilon_greedy
from rcss_hat.learning.sarsa import exploration

_BONUS, _FORCED = range(2)


def select_value_bonus(
    method: NDArray[np.void], learner: NDArray[np.void], rng: NDArray[np.uint64], advice: int, confidence: float
) -> int:
    """Select the advice during the first C episodes, then epsilon-greedily on Q plus bonus."""
    if advice != NO_ADVICE and learner["episodes"][0] < method["settings"][0, _FORCED]:
        return advice
    bonus = method["settings"][0, _BONUS]
    return epsilon_greedy(rng, learner["q"][0], learner["n_actions"][0], exploration(learner), advice, bonus)


@dataclass(frozen=True, slots=True)
class ValueBonus(TransferMethod):
    """Add a bonus to the value of the advised action.

    With ``Qb(s, a) = Q(s, a) + B`` for a = D(s) and Q(s, a) otherwise, Qb is the action-value function in everything:
    selection and temporal differences. So the bonus is an initial value, which experience can unlearn.
    """

    bonus: float = 10.0
    """B, in cycles (10 cycles are one second of play)."""
    forced: int = 100
    """C: for so many episodes the advice is followed without a choice (and without exploration)."""
    in_targets: bool = True
    """False: the bonus counts in selection only, as a preference that never fades (an ablation)."""

    name: ClassVar[str] = "value-bonus"
    select = staticmethod(select_value_bonus)

    def __post_init__(self) -> None:
        """Check the settings."""
        check_number("bonus", self.bonus, -1e6, 1e6)
        check_count("forced", self.forced)

    def describe(self) -> str:
        """Return one line for people."""
        where = "" if self.in_targets else ", in selection only"
        return f"Value Bonus: B = {self.bonus:g} cycles{where}, D forced for {self.forced} episodes"

    def settings(self) -> tuple[float, ...]:
        """Return the numbers that the kernel gets."""
        return self.bonus, self.forced

    @property
    def target_bonus(self) -> float:
        """Cycles added to Q of the advised action in the values that learning aims at."""
        return self.bonus if self.in_targets else 0.0
