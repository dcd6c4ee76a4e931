"""No Prior: Sarsa alone, the baseline of every comparison."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.transfer.method import TransferMethod
from rcss_hat.learning.sarsa import select_epsilon_greedily


def select_no_prior(
    method: NDArray[np.void], learner: NDArray[np.void], rng: NDArray[np.uint64], advice: int, confidence: float
) -> int:
    """Select epsilon-greedily on Q."""
    return select_epsilon_greedily(learner, rng)


@dataclass(frozen=True, slots=True)
class NoPrior(TransferMethod):
    """Learning without demonstrations."""

    name: ClassVar[str] = "no-prior"
    needs_advice: ClassVar[bool] = False
    select = staticmethod(select_no_prior)

    def describe(self) -> str:
        """Return one line for people."""
        return "No Prior: Sarsa alone"
