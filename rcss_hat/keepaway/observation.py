"""What a state is to learners outside: numbers with bounds that hold, in metres and degrees or scaled to 0 to 1."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.landmarks import PITCH_LENGTH, PITCH_WIDTH

PITCH_DIAGONAL = math.hypot(PITCH_LENGTH, PITCH_WIDTH)
"""The largest distance between two players on the pitch (m)."""
MAX_ANGLE = 180.0


def observation_scale(task: Task, normalize: bool) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return what makes an observation of a state: ``minimum(state * scale, high)``, never below 0.

    Parameters
    ----------
    task : Task
    normalize : bool
        Distances over the diagonal of the region and angles over 180 degrees; what lies farther counts as 1. False:
        metres and degrees; players believe things beyond the region, so distances reach to the diagonal of the pitch.

    Returns
    -------
    scale, high : ndarray of float64, shape (n_variables,)
        ``high`` as far as float32 goes, so that no rounding leaves the bounds.
    """
    distances, angles = 3 * (task.keepers - 1) + 2 * task.takers + 1, task.keepers - 1
    if normalize:
        diagonal = math.hypot(task.length, task.width)
        scale = np.array([1.0 / diagonal] * distances + [1.0 / MAX_ANGLE] * angles)
        return scale, np.ones(len(scale))
    high = np.array([PITCH_DIAGONAL] * distances + [MAX_ANGLE] * angles)
    return np.ones(len(high)), high.astype(np.float32).astype(np.float64)
