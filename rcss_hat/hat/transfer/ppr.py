"""Probabilistic Policy Reuse: follow D with a probability that fades (HAT paper, section 3.3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.transfer.record import KIND_PPR, NO_ADVICE, TransferMethod, check_number, method_record
from rcss_hat.hat.transfer.reuse import SCHEDULES, check_schedule, reuse_probability
from rcss_hat.learning.exploration import NO_ACTION, epsilon_greedy
from rcss_hat.learning.sarsa import exploration
from rcss_hat.numeric.jit import kernel
from rcss_hat.numeric.rng import bernoulli


@kernel
def select_ppr(method: NDArray[np.void], learner: NDArray[np.void], rng: NDArray[np.uint64], advice: int) -> int:
    """Select the advice with probability psi, otherwise epsilon-greedily on Q."""
    if advice != NO_ADVICE and bernoulli(rng, reuse_probability(method, learner)):
        return advice
    return epsilon_greedy(rng, learner["q"][0], learner["n_actions"][0], exploration(learner), NO_ACTION, 0.0)


@dataclass(frozen=True, slots=True)
class PPR(TransferMethod):
    """Follow the advice with probability psi, explore with (1 - psi) epsilon, else exploit.

    The paper's probabilities psi, epsilon and 1 - psi - epsilon do not add up while psi is near 1; this reading is that
    of pi-reuse. The coin is flipped at every decision, and the update is Sarsa's with the action that was taken.
    """

    decay: float = 0.999
    """psi after k episodes is ``decay ** k``."""
    schedule: str = "episode"
    """What psi decays with: ``episode``, ``decision`` or ``within-episode``."""

    name: ClassVar[str] = "ppr"

    def __post_init__(self) -> None:
        """Check the settings."""
        check_number("decay", self.decay, 0.0, 1.0)
        check_schedule(self.schedule)

    def describe(self) -> str:
        """Return one line for people."""
        return f"Probabilistic Policy Reuse: psi = {self.decay:g} ** {self.schedule}s"

    def to_record(self) -> NDArray[np.void]:
        """Return the METHOD record, shape (1,)."""
        return method_record(KIND_PPR, decay=self.decay, schedule=SCHEDULES.index(self.schedule))
