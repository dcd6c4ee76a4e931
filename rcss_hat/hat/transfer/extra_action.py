"""Extra Action: a pseudo-action that executes what D advises (HAT paper, section 3.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.transfer.method import NO_ADVICE, TransferMethod, check_count
from rcss_hat.learning.exploration import NO_ACTION, epsilon_greedy
from rcss_hat.learning.sarsa import exploration, select_epsilon_greedily


def select_extra_action(
    method: NDArray[np.void], learner: NDArray[np.void], rng: NDArray[np.uint64], advice: int, confidence: float
) -> int:
    """Select the pseudo-action during the first C episodes, then epsilon-greedily among all actions and it.

    Without advice the pseudo-action means nothing and cannot be selected.
    """
    if advice == NO_ADVICE:
        return select_epsilon_greedily(learner, rng)
    pseudo = learner["n_actions"][0]
    if learner["episodes"][0] < method["settings"][0, 0]:
        return pseudo
    return epsilon_greedy(rng, learner["q"][0], pseudo + 1, exploration(learner), NO_ACTION, 0.0)


@dataclass(frozen=True, slots=True)
class ExtraAction(TransferMethod):
    """Learn for each state whether to follow the advice, by a pseudo-action with weights of its own.

    What was selected is credited: the pseudo-action, not the action it stood for; and an action selected for itself
    leaves the pseudo-action alone even when D advises the same.
    """

    forced: int = 100
    """C: for so many episodes the pseudo-action is selected without a choice (and without exploration)."""

    name: ClassVar[str] = "extra-action"
    n_extra_actions: ClassVar[int] = 1
    select = staticmethod(select_extra_action)

    def __post_init__(self) -> None:
        """Check the settings."""
        check_count("forced", self.forced)

    def describe(self) -> str:
        """Return one line for people."""
        return f"Extra Action: pseudo-action D, forced for {self.forced} episodes"

    def settings(self) -> tuple[float, ...]:
        """Return the numbers that the kernel gets."""
        return (self.forced,)
