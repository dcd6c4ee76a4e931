"""The arena's own bookkeeping."""

from __future__ import annotations

import numpy as np

# Why the loop came back.
FINISHED, NEEDS_ACTION, LOG_FULL = range(3)

# Where in a cycle the loop is; it can come back in the middle of one, to ask for an action, and go on later.
SIMULATE, PERCEIVE, DECIDE, COMMAND = range(4)

CONTROL = np.dtype(
    [
        ("phase", "i4"),
        ("player", "i4"),  # next to decide
        ("status", "i4"),  # of the decision asked for
        ("reward", "f8"),
        ("choice", "i4"),  # answer to NEEDS_ACTION
        ("has_choice", "u1"),
        ("stop_cycle", "i4"),  # stop before simulating this cycle
        ("stop_episode", "i4"),  # stop when so many episodes have ended
        ("episodes", "i4"),  # finished so far
        ("logged", "i4"),  # entries in the episode log since it was emptied
        ("decided", "i4"),  # entries in the decision log since it was emptied
        ("log_decisions", "u1"),
        ("framed", "i4"),  # entries in the frame log since it was emptied
        ("log_frames", "u1"),
    ]
)
"""State of the loop, shape (1,)."""

FRAME_PLAYERS = 22
FRAME = np.dtype(
    [
        ("time", "i4"),
        ("mode", "i4"),
        ("episode", "i4"),
        ("episode_start", "i4"),
        ("events", "i4"),
        ("ball", "f8", (4,)),  # x, y, vx, vy
        ("enabled", "u1", (FRAME_PLAYERS,)),
        ("pos", "f8", (FRAME_PLAYERS, 2)),
        ("vel", "f8", (FRAME_PLAYERS, 2)),
        ("body", "f8", (FRAME_PLAYERS,)),  # rad
        ("neck", "f8", (FRAME_PLAYERS,)),
        ("flags", "i4", (FRAME_PLAYERS,)),
        ("stamina", "f8", (FRAME_PLAYERS,)),
        ("counts", "i4", (FRAME_PLAYERS, 12)),
    ]
)
"""What a monitor shows of one cycle."""

_DECISION = [
    ("episode", "i4"),
    ("cycle", "i4"),
    ("keeper", "i4"),
    ("status", "i4"),
    ("reward", "f8"),
    ("action", "i4"),
]
DECISION = np.dtype(_DECISION)
"""Who did what; the loop keeps the states apart, so that it is compiled once for all sizes of teams."""


def decision_dtype(n_variables: int) -> np.dtype:
    """Dtype of decisions as people get them: who did what in which state."""
    return np.dtype([*_DECISION, ("state", "f8", (n_variables,))])
