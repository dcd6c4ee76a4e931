"""The probability psi with which a decision reuses the advice, and how it fades."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.transfer.method import TransferMethod, check_choice, check_number
from rcss_hat.numeric.jit import kernel

SCHEDULES = ("episode", "decision", "within-episode")
"""What psi decays with: finished episodes; this keeper's decisions; or its decisions since the episode began, starting
from 1 again in every episode (the pi-reuse strategy of Fernandez and Veloso 2006)."""
PER_EPISODE, PER_DECISION, WITHIN_EPISODE = range(3)


_DECAY, _SCHEDULE, OWN = range(3)
"""Where a method's settings are; its own begin behind those of the schedule."""


@kernel
def faded(decay: float, schedule: int, learner: NDArray[np.void]) -> float:
    """Return psi for the decision at hand: ``decay ** k`` after k episodes (or decisions, by the schedule)."""
    if schedule == PER_EPISODE:
        k = learner["episodes"][0]
    elif schedule == PER_DECISION:
        k = learner["decisions"][0]
    else:
        k = learner["episode_decisions"][0]
    return math.pow(decay, float(k))


@kernel
def reuse_probability(method: NDArray[np.void], learner: NDArray[np.void]) -> float:
    """Return psi for the decision at hand, by a method's record."""
    return faded(method["settings"][0, _DECAY], int(method["settings"][0, _SCHEDULE]), learner)


@dataclass(frozen=True, slots=True)
class Reuse(TransferMethod):
    """Base of the methods that reuse the advice with a probability psi."""

    decay: float = 0.999
    """psi after k episodes is ``decay ** k``."""
    schedule: str = "episode"
    """What psi decays with: ``episode``, ``decision`` or ``within-episode``."""

    def __post_init__(self) -> None:
        """Check the settings."""
        check_number("decay", self.decay, 0.0, 1.0)
        check_choice("schedule", self.schedule, SCHEDULES)

    def settings(self) -> tuple[float, ...]:
        """Return the numbers that the kernel gets."""
        return self.decay, SCHEDULES.index(self.schedule)

    def psi_after(self, episodes: int) -> float | None:
        """Return psi after so many episodes; None where it fades with decisions."""
        if self.schedule == "episode":
            return float(self.decay**episodes)
        return 1.0 if self.schedule == "within-episode" else None

    def psi(self, learner: NDArray[np.void]) -> float:
        """Return the probability with which a learner's next decision reuses the advice."""
        return float(faded(self.decay, SCHEDULES.index(self.schedule), learner))
