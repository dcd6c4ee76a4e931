"""Where an episode begins, when somebody says so: checked places of players and ball."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.landmarks import PITCH_LENGTH, PITCH_WIDTH

_TEAMS = ("keepers", "takers")
BALL = "ball"


@dataclass(frozen=True, slots=True)
class Positions:
    """Where everybody is put.

    Attributes
    ----------
    players : ndarray of float64, shape (players, 2)
        x, y in metres, keepers first; nan: stays where the referee has put him.
    ball : ndarray of float64, shape (2,), or None
        Likewise.
    """

    players: NDArray[np.float64]
    ball: NDArray[np.float64] | None


def check_positions(task: Task, positions: Mapping[str, Any]) -> Positions:
    """Check positions that somebody asks for.

    Parameters
    ----------
    task : Task
    positions : mapping
        ``keepers``: n rows of x, y, ``takers``: m rows, ``ball``: x, y; each can be left out. Metres from the centre
        of the region, x to the right and y down, as on the server.

    Raises
    ------
    ValueError
        When they are none of this task, a player is off the pitch, or the ball is not within the region.
    """
    if not isinstance(positions, Mapping) or (unknown := set(positions) - {*_TEAMS, BALL}):
        what = f"{', '.join(map(repr, sorted(map(str, unknown))))}" if isinstance(positions, Mapping) else positions
        raise ValueError(f"positions are a mapping with 'keepers', 'takers' and 'ball', not {what}")
    players = np.full((task.keepers + task.takers, 2), np.nan)
    for team, first, size in ((_TEAMS[0], 0, task.keepers), (_TEAMS[1], task.keepers, task.takers)):
        if team in positions:
            limits = np.array([PITCH_LENGTH, PITCH_WIDTH]) / 2.0
            players[first : first + size] = _places(team, positions[team], (size, 2), limits)
    ball = None
    if BALL in positions:
        ball = _places(BALL, positions[BALL], (2,), np.array([task.length, task.width]) / 2.0)
    return Positions(players, ball)


def _places(name: str, given: Any, shape: tuple[int, ...], limits: NDArray[np.float64]) -> NDArray[np.float64]:
    try:
        places = np.array(given, dtype=np.float64)
    except (TypeError, ValueError):
        places = np.empty(0)
    if places.shape != shape:
        raise ValueError(f"positions[{name!r}] must be numbers of shape {shape}, not {given!r}")
    if not (np.abs(places) < limits).all():  # nan is none, either
        length, width = 2.0 * limits
        raise ValueError(f"positions[{name!r}] must be within {length:g} m x {width:g} m around (0, 0), not {given!r}")
    return places
