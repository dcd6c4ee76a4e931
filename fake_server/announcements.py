"""What the referee says about the events of a step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.protocol.play_modes import PLAY_MODES
from rcss_hat.simulation.state import (
    E_DROP_BALL,
    E_EPISODE_OUT,
    E_EPISODE_TAKEN,
    E_HALF_TIME,
    E_PLAY_ON,
    E_TIME_EXTENDED,
    E_TIME_UP,
    E_WITHOUT_A_TEAM,
    GOAL_LEFT,
    GOAL_RIGHT,
)

EPISODE_END = "training Keepaway 1"
"""What the referee says at the end of every episode."""


def announcements(match: NDArray[np.void], before: int) -> list[str]:
    """Return what the referee says about the events of a match, in the server's order; ``before`` was the play mode."""
    events, after = int(match["events"][0]), int(match["mode"][0])
    said = []
    if events & E_HALF_TIME:
        said.append("half_time")
    if events & E_TIME_EXTENDED:
        said.append("time_extended")
    if events & E_TIME_UP:
        said.append("time_up_without_a_team" if events & E_WITHOUT_A_TEAM else "time_up")
    if events & E_DROP_BALL:
        said.append("drop_ball")
    if events & E_PLAY_ON:
        said.append("play_on")
    elif after != before and after not in (GOAL_LEFT, GOAL_RIGHT):
        said.append(PLAY_MODES[after])
    if events & (E_EPISODE_OUT | E_EPISODE_TAKEN):
        said.append(EPISODE_END)
    return said
