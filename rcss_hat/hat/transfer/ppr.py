"""Probabilistic Policy Reuse: follow D with a probability that fades (HAT paper, section 3.3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.transfer.method import NO_ADVICE
from rcss_hat.hat.transfer.reuse import Reuse, reuse_probability
from rcss_hat.learning.sarsa import select_epsilon_greedily
from rcss_hat.numeric.rng import bernoulli


def select_ppr(
    method: NDArray[np.void], learner: NDArray[np.void], rng: NDArray[np.uint64], advice: int, confidence: float
) -> int:
    """Select the advice with probability psi, otherwise epsilon-greedily on Q."""
    if advice != NO_ADVICE and bernoulli(rng, reuse_probability(method, learner)):
        return advice
    return select_epsilon_greedily(learner, rng)


@dataclass(frozen=True, slots=True)
class PPR(Reuse):
    """Follow the advice with probability psi, explore with (1 - psi) epsilon, else exploit.

    The paper's probabilities psi, epsilon and 1 - psi - epsilon do not add up while psi is near 1; this reading is that
    of pi-reuse. The coin is flipped at every decision, and the update is Sarsa's with the action that was taken.
    """

    name: ClassVar[str] = "ppr"
    select = staticmethod(select_ppr)

    def describe(self) -> str:
        """Return one line for people."""
        return f"Probabilistic Policy Reuse: psi = {self.decay:g} ** {self.schedule}s"
