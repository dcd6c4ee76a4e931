"""The arena's own bookkeeping."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

# Why the loop came back.
FINISHED, NEEDS_ACTION, LOG_FULL, BALL_STUCK, EPISODE_OVER = range(5)

# Where in a cycle the loop is; it can come back in the middle of one, to ask for an action, and go on later.
SIMULATE, PERCEIVE, DECIDE, COMMAND, JUDGE = range(5)

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

ORDER = np.dtype(
    [
        ("outside", "u1"),  # somebody outside the loop decides for this taker
        ("order", "i4"),  # its macro-action, see `rcss_hat.keepaway.taker`
        ("until", "i4"),  # cycle of its next decision
        ("lasts", "i4"),  # cycles from one decision to the next
    ]
)
"""What a taker was told from outside; by itself it is hand-coded."""

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


class Team(NamedTuple):
    """The players of both teams, keepers first, and what lies between them and the simulation.

    Attributes
    ----------
    agents : AGENT, shape (players,)
        What everybody believes, see `rcss_hat.keepaway.agent`.
    seats : ndarray of int64, shape (players,)
        Where each plays in the simulation's arrays.
    started : ndarray of uint8, shape (players,)
        Whether an episode has begun since a player perceived last.
    sense, heard : SENSE_BODY, HEARD, shape (1,)
        Of the player at hand.
    sees : SEE, shape (players,)
    has_see : ndarray of uint8, shape (players,)
        Whether ``sees`` is new.
    due : ndarray of uint8, shape (all seats,)
        Who sees in this half of the cycle.
    landmarks : ndarray of uint8
        Numbers of the landmarks that our players use.
    actions : ACTION, shape (players,)
    state : ndarray of float64, shape (n_variables,)
        State variables of the decision at hand.
    orders : ORDER, shape (players,)
        Of the takers.
    taker_state : ndarray of float64, shape (n_taker_variables,)
        State variables of a taker's decision at hand.
    pauses : ndarray of uint8, shape (1,)
        Whether the loop comes back when an episode has ended, before anybody perceives the next one.
    """

    agents: NDArray[np.void]
    seats: NDArray[np.int64]
    started: NDArray[np.uint8]
    sense: NDArray[np.void]
    heard: NDArray[np.void]
    sees: NDArray[np.void]
    has_see: NDArray[np.uint8]
    due: NDArray[np.uint8]
    landmarks: NDArray[np.uint8]
    actions: NDArray[np.void]
    state: NDArray[np.float64]
    orders: NDArray[np.void]
    taker_state: NDArray[np.float64]
    pauses: NDArray[np.uint8]


class Logs(NamedTuple):
    """What the loop writes down, as much as there is room for.

    Attributes
    ----------
    episodes : EPISODE, shape (room,)
    decisions : DECISION, shape (room,)
    states : ndarray of float64, shape (room, n_variables)
        State variables of the decisions.
    frames : FRAME, shape (room,)
    """

    episodes: NDArray[np.void]
    decisions: NDArray[np.void]
    states: NDArray[np.float64]
    frames: NDArray[np.void]
