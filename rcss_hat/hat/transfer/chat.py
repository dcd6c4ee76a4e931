"""Confidence-based HAT: follow D where it is sure, with a probability that fades (Wang and Taylor, IJCAI 2017)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.transfer.method import NO_ADVICE, check_number
from rcss_hat.hat.transfer.reuse import OWN, Reuse, reuse_probability
from rcss_hat.learning.sarsa import select_epsilon_greedily
from rcss_hat.numeric.rng import bernoulli


def select_chat(
    method: NDArray[np.void], learner: NDArray[np.void], rng: NDArray[np.uint64], advice: int, confidence: float
) -> int:
    """Select as Probabilistic Policy Reuse does, taking advice below the threshold of confidence for none."""
    trusted = advice != NO_ADVICE and confidence >= method["settings"][0, OWN]
    if trusted and bernoulli(rng, reuse_probability(method, learner)):
        return advice
    return select_epsilon_greedily(learner, rng)


@dataclass(frozen=True, slots=True)
class CHAT(Reuse):
    """Follow the advice with probability psi where the summary's confidence reaches a threshold.

    The published factor for Keepaway is 0.999. It decays there with every time step; the default here is PPR's decay by
    episodes, so that the two methods differ by the threshold alone. The threshold is this package's choice.
    """

    threshold: float = 0.6
    """Confidence, 0 to 1, from which on advice may be followed."""

    name: ClassVar[str] = "chat"
    select = staticmethod(select_chat)

    def __post_init__(self) -> None:
        """Check the settings."""
        Reuse.__post_init__(self)
        check_number("threshold", self.threshold, 0.0, 1.0)

    def settings(self) -> tuple[float, ...]:
        """Return the numbers that the kernel gets."""
        return *Reuse.settings(self), self.threshold

    def describe(self) -> str:
        """Return one line for people."""
        return f"CHAT: D where its confidence is at least {self.threshold:g}, psi = {self.decay:g} ** {self.schedule}s"
