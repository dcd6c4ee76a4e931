"""What learners see: the state variables with bounds that hold, in metres and degrees or scaled to [0, 1]."""

from __future__ import annotations

import math

import numpy as np
from gymnasium.spaces import Box, Discrete
from numpy.typing import NDArray

from rcss_hat.keepaway.decision import action_name
from rcss_hat.keepaway.state import state_names
from rcss_hat.keepaway.taker_state import taker_state_names
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.landmarks import PITCH_LENGTH, PITCH_WIDTH

PITCH_DIAGONAL = math.hypot(PITCH_LENGTH, PITCH_WIDTH)
"""The largest distance between two players on the pitch (m)."""
MAX_ANGLE = 180.0


class Observations:
    """Turns state variables into observations of one task.

    Parameters
    ----------
    task : Task
    normalize : bool
        Distances over the diagonal of the region and angles over 180 degrees, in [0, 1]: what lies farther than that
        diagonal, outside the region, counts as 1. False: metres and degrees; beliefs leave the region, so distances
        reach to the diagonal of the pitch.
    taker : bool
        Of a taker (`rcss_hat.keepaway.taker_state`), instead of a keeper.

    Attributes
    ----------
    names : list of str
        Of the variables, in order: ``dist(K1,C)`` first, see `rcss_hat.keepaway.state.state_names`.
    scale, high : ndarray of float64, shape (variables,)
        An observation is ``minimum(state * scale, high)``; the smallest value of each is 0.
    space : Box
        dtype float32, shape (variables,).
    """

    def __init__(self, task: Task, normalize: bool = False, taker: bool = False) -> None:
        self.task, self.normalize = task, normalize
        self.names = (taker_state_names if taker else state_names)(task.keepers, task.takers)
        variables = len(self.names)
        angles = np.array(["ang(" in name for name in self.names])
        if normalize:
            self.scale = np.where(angles, 1.0 / MAX_ANGLE, 1.0 / math.hypot(task.length, task.width))
            self.high = np.ones(variables)
        else:
            self.scale = np.ones(variables)
            self.high = np.where(angles, MAX_ANGLE, PITCH_DIAGONAL)
        high = self.high.astype(np.float32)
        self.high = high.astype(np.float64)  # as far as float32 goes, so that no rounding leaves the space
        self.space = Box(np.zeros_like(high), high, dtype=np.float32)

    def of(self, state: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return a new observation.

        Parameters
        ----------
        state : ndarray of float64, shape (..., variables)
            State variables in metres and degrees.

        Returns
        -------
        ndarray of float32, the same shape
        """
        return np.minimum(state * self.scale, self.high).astype(np.float32)

    def write(self, state: NDArray[np.float64], out: NDArray[np.float32]) -> None:
        """Write observations into an array of float32 of the state's shape."""
        np.minimum(state * self.scale, self.high, out=out, casting="same_kind")


def action_space(task: Task, seed: int | None = None) -> Discrete:
    """Return the keepers' actions: 0 is Hold, a the pass to the a-th nearest team mate.

    Parameters
    ----------
    task : Task
    seed : int, optional
        Of `Discrete.sample`.
    """
    return Discrete(task.keepers, seed=seed)


def action_names(task: Task) -> list[str]:
    """Return the names of the keepers' actions, ``Hold``, ``PASS1``, ..."""
    return [action_name(a) for a in range(task.keepers)]
