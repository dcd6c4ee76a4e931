"""No Prior: Sarsa alone, the baseline of every comparison."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.transfer.record import KIND_NO_PRIOR, TransferMethod, method_record
from rcss_hat.learning.exploration import NO_ACTION, epsilon_greedy
from rcss_hat.learning.sarsa import exploration
from rcss_hat.numeric.jit import kernel


@kernel
def select_no_prior(learner: NDArray[np.void], rng: NDArray[np.uint64]) -> int:
    """Select epsilon-greedily on Q."""
    return epsilon_greedy(rng, learner["q"][0], learner["n_actions"][0], exploration(learner), NO_ACTION, 0.0)


@dataclass(frozen=True, slots=True)
class NoPrior(TransferMethod):
    """Learning without demonstrations."""

    name: ClassVar[str] = "no-prior"
    needs_advice: ClassVar[bool] = False

    def describe(self) -> str:
        """Return one line for people."""
        return "No Prior: Sarsa alone"

    def to_record(self) -> NDArray[np.void]:
        """Return the METHOD record, shape (1,)."""
        return method_record(KIND_NO_PRIOR)
