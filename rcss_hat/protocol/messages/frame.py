"""What a server's record of the match must hold to be told whole, as fullstate and monitors' frames tell it.

Writers read the fields by name, so that nothing is copied. A record of shape (1,) has

- time, stopped (cycles), mode (number of the play mode), score (2,), ball_pos and ball_vel (2,; m, m/cycle);
- per player, first those of the left side, (22,): enabled, goalie, type, flags, version (of the client's protocol),
  pos and vel (22, 2), body and neck (rad), stamina, effort, recovery, capacity, quality, width, tackle_cycles,
  kick_cycles, arm_movable, arm_expires (cycles), arm_pos (22, 2), focus_dist (m) and focus_dir (rad) of the focus
  point, focus_side and focus_unum of the player listened to, and counts (22, 12) in the order of `COUNTERS`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import kernel

COUNTERS = (
    "kick", "dash", "turn", "catch", "move", "turn_neck", "change_view", "say", "tackle", "pointto", "attentionto",
    "change_focus",
)  # fmt: skip
"""Accepted commands that servers count, in the order in which frames tell them."""


@kernel
def arm_target(frame: NDArray[np.void], i: int) -> tuple[float, float]:
    """Return distance (m) and direction (rad, relative to the face) of a player's arm target; zeros when it is down."""
    if frame["arm_expires"][0, i] <= 0:
        return 0.0, 0.0
    x = frame["arm_pos"][0, i, 0] - frame["pos"][0, i, 0]
    y = frame["arm_pos"][0, i, 1] - frame["pos"][0, i, 1]
    face = frame["body"][0, i] + frame["neck"][0, i]
    # rotated like the server does it, not by subtracting angles: the last digits differ
    turned_x = x * math.cos(-face) - y * math.sin(-face)
    turned_y = x * math.sin(-face) + y * math.cos(-face)
    direction = 0.0 if turned_x == 0.0 and turned_y == 0.0 else math.atan2(turned_y, turned_x)
    return math.sqrt(turned_x * turned_x + turned_y * turned_y), direction
