"""The probability psi with which a decision reuses the advice, and how it fades."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import kernel

SCHEDULES = ("episode", "decision", "within-episode")
"""What psi decays with: finished episodes; this keeper's decisions; or its decisions since the episode began, starting
from 1 again in every episode (the pi-reuse strategy of Fernandez and Veloso 2006)."""
PER_EPISODE, PER_DECISION, WITHIN_EPISODE = range(3)


@kernel
def reuse_probability(method: NDArray[np.void], learner: NDArray[np.void]) -> float:
    """Return psi for the decision at hand: ``decay ** k`` after k episodes (or decisions, by the schedule)."""
    schedule = method["schedule"][0]
    if schedule == PER_EPISODE:
        k = learner["episodes"][0]
    elif schedule == PER_DECISION:
        k = learner["decisions"][0]
    else:
        k = learner["episode_decisions"][0]
    return math.pow(method["decay"][0], float(k))


def check_schedule(schedule: str) -> None:
    """Raise ValueError for an unknown schedule."""
    if schedule not in SCHEDULES:
        raise ValueError(f"schedule must be one of {', '.join(SCHEDULES)}, not {schedule!r}")
