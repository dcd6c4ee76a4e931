"""The records into which server messages are parsed and from which the arena's players see.

Every record is a NumPy structured array of shape ``(1,)``; kernels index ``record["field"][0, i]``, the order that
works with and without compilation. Perception in the simulation writes exactly these records, text is made from
them, and parsing the text gives the same record again.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

MAX_PLAYERS = 11
"""Players of one side."""

# --- see -----------------------------------------------------------------------------------------------------------
MAX_SEEN = 96
"""Room for 55 landmarks, the ball, 21 players and 4 lines."""

# Codes 0 .. 54 are landmarks, see rcss_hat.protocol.landmarks.
BALL = 60
PLAYER = 61
LINE = 64
"""LINE + 0 .. 3: lines l, r, t, b."""
CLOSE_BALL = 70
"""``(B)``: the ball, near but outside the view cone."""
CLOSE_PLAYER = 71
CLOSE_FLAG = 72
CLOSE_GOAL = 73

HAS_DISTANCE = 1
HAS_CHANGE = 2
HAS_FACING = 4
HAS_POINTING = 8
IS_TACKLING = 16
IS_KICKING = 32

UNKNOWN_TEAM, OWN_TEAM, OTHER_TEAM = 0, 1, 2

SEE = np.dtype(
    [
        ("time", "i4"),
        ("n", "i4"),  # objects, in message order
        ("code", "u1", (MAX_SEEN,)),
        ("fields", "u1", (MAX_SEEN,)),  # HAS_* and IS_* bits; direction is always there
        ("team", "u1", (MAX_SEEN,)),  # players: UNKNOWN_TEAM, OWN_TEAM, OTHER_TEAM
        ("unum", "u1", (MAX_SEEN,)),  # players: 0 unknown
        ("goalie", "u1", (MAX_SEEN,)),
        ("distance", "f8", (MAX_SEEN,)),  # m
        ("direction", "f8", (MAX_SEEN,)),  # degrees relative to the face
        ("distance_change", "f8", (MAX_SEEN,)),  # m/cycle
        ("direction_change", "f8", (MAX_SEEN,)),  # degrees/cycle
        ("body", "f8", (MAX_SEEN,)),  # degrees relative to the observer's face
        ("head", "f8", (MAX_SEEN,)),
        ("pointing", "f8", (MAX_SEEN,)),
    ]
)
"""A see message: one entry per object."""

# --- sense_body ----------------------------------------------------------------------------------------------------
NARROW, NORMAL, WIDE = 0, 1, 2
LOW, HIGH = 0, 1
N_COUNTS = 8
COUNT_KICK, COUNT_DASH, COUNT_TURN, COUNT_SAY, COUNT_TURN_NECK, COUNT_CATCH, COUNT_MOVE, COUNT_CHANGE_VIEW = range(8)
COUNT_NAMES = ("kick", "dash", "turn", "say", "turn_neck", "catch", "move", "change_view")
COLLIDED_BALL, COLLIDED_PLAYER, COLLIDED_POST = 1, 2, 4
NO_SIDE, LEFT, RIGHT = 0, 1, 2

SENSE_BODY = np.dtype(
    [
        ("time", "i4"),
        ("quality", "u1"),
        ("width", "u1"),
        ("stamina", "f8"),
        ("effort", "f8"),
        ("capacity", "f8"),  # version 13 and later, else -1
        ("speed", "f8"),  # m/cycle
        ("speed_direction", "f8"),  # degrees relative to the face
        ("head_angle", "f8"),  # degrees relative to the body
        ("counts", "i4", (N_COUNTS,)),  # accepted commands, COUNT_* order
        ("arm_movable", "i4"),
        ("arm_expires", "i4"),
        ("arm_distance", "f8"),
        ("arm_direction", "f8"),
        ("arm_count", "i4"),
        ("focus_side", "u1"),  # NO_SIDE, LEFT, RIGHT
        ("focus_unum", "u1"),
        ("focus_count", "i4"),
        ("tackle_expires", "i4"),
        ("tackle_count", "i4"),
        ("has_collision", "u1"),  # version 12 and later
        ("collision", "u1"),  # COLLIDED_* bits
    ]
)
"""A sense_body message."""

# --- hear ----------------------------------------------------------------------------------------------------------
SAY_SIZE = 10
"""Longest player message with the server's default ``say_msg_size``."""

HEARD = np.dtype(
    [
        ("time", "i4"),  # -1: nothing heard
        ("direction", "f8"),  # degrees relative to the body
        ("unum", "u1"),  # of the team mate who spoke
        ("n", "u1"),  # length of the text
        ("text", "u1", (SAY_SIZE,)),
    ]
)
"""The last complete message heard from a team mate in a cycle."""

# --- what a player does in a cycle -----------------------------------------------------------------------------------
NO_COMMAND, DASH, TURN, KICK, TACKLE, CATCH, MOVE = range(7)

ACTION = np.dtype(
    [
        ("kind", "u1"),  # body command, NO_COMMAND .. MOVE
        ("a", "f8"),  # dash, kick: power; turn: moment (degrees); move: x
        ("b", "f8"),  # kick, dash: direction (degrees); move: y
        ("turns_neck", "u1"),
        ("neck", "f8"),  # moment (degrees)
        ("say_n", "u1"),  # 0: says nothing
        ("say", "u1", (SAY_SIZE,)),
    ]
)
"""The commands of one player in one cycle: one body command, turn_neck, say. All numbers are integers."""


def empty(dtype: np.dtype) -> NDArray[np.void]:
    """Make one zeroed record of a kind (shape ``(1,)``)."""
    return np.zeros(1, dtype=dtype)
