"""The state of a match: everything a server knows, in one record.

Players are indexed 0 .. 21: left 1 .. 11, then right 1 .. 11 (``index(side, unum)``). Positions are metres, velocities
metres per cycle, angles radians (as inside rcssserver), world axes (x to the right goal, y down). The record is a
structured array of shape ``(1,)``; kernels index ``match["pos"][0, i, 0]``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric import rng
from rcss_hat.protocol.records import LEFT, MAX_PLAYERS, SAY_SIZE

N_PLAYERS = 2 * MAX_PLAYERS

# Play modes: identifiers of the monitor protocol (19.0.0, src/types.h); names in rcss_hat.protocol.
BEFORE_KICK_OFF, TIME_OVER, PLAY_ON = 1, 2, 3

# Command counters: the monitor's order.
N_COUNTERS = 12
(C_KICK, C_DASH, C_TURN, C_CATCH, C_MOVE, C_TURN_NECK, C_CHANGE_VIEW, C_SAY, C_TACKLE, C_POINTTO, C_ATTENTIONTO,
 C_CHANGE_FOCUS) = range(12)  # fmt: skip

# State flags of a player (monitor protocol).
(F_STAND, F_KICK, F_KICK_FAULT, F_GOALIE, F_CATCH, F_CATCH_FAULT, F_BALL_TO_PLAYER, F_PLAYER_TO_BALL, F_DISCARD, F_LOST,
 F_BALL_COLLIDE, F_PLAYER_COLLIDE, F_TACKLE, F_TACKLE_FAULT) = (1 << bit for bit in range(14))  # fmt: skip

# What the referee did in a step (events; bits of match["events"]).
E_PLAY_ON, E_EPISODE_OUT, E_EPISODE_TAKEN, E_DROP_BALL, E_TIME_UP = 1, 2, 4, 8, 16

# Random streams of a match: rows of its (3, 4) array of streams.
PHYSICS, PERCEPTION, LANDMARKS = range(3)
"""PHYSICS: motion, kicks, tackles, placement, order of hearing. PERCEPTION: what is lost of players and ball.
LANDMARKS: what is lost of landmarks, apart so that callers that need no landmarks may skip them."""

_P = (N_PLAYERS,)

MATCH = np.dtype(
    [
        ("time", "i4"),
        ("stopped", "i4"),  # steps spent in the current stoppage
        ("mode", "i4"),  # play mode
        ("events", "i4"),  # E_* bits of the last step
        ("score", "i4", (2,)),
        # ball
        ("ball_pos", "f8", (2,)),
        ("ball_vel", "f8", (2,)),
        ("ball_acc", "f8", (2,)),
        # players
        ("enabled", "u1", _P),  # connected and not discarded
        ("goalie", "u1", _P),
        ("type", "u1", _P),
        ("version", "u1", _P),  # protocol version of the client
        ("pos", "f8", (N_PLAYERS, 2)),
        ("vel", "f8", (N_PLAYERS, 2)),
        ("acc", "f8", (N_PLAYERS, 2)),
        ("body", "f8", _P),  # committed angles, rad
        ("neck", "f8", _P),
        ("body_pending", "f8", _P),  # what turn and turn_neck asked for; committed in the next step
        ("neck_pending", "f8", _P),
        ("stamina", "f8", _P),
        ("effort", "f8", _P),
        ("recovery", "f8", _P),
        ("capacity", "f8", _P),
        ("dash_power", "f8", _P),  # the dash of this cycle, applied at the start of the next step (19)
        ("dash_dir", "f8", _P),
        ("has_dash", "u1", _P),
        ("command_done", "u1", _P),  # a body command was accepted in this cycle
        ("neck_done", "u1", _P),
        ("flags", "i4", _P),  # F_* state flags, without F_STAND and F_GOALIE
        ("kick_cycles", "i4", _P),  # how long the kick flags stay up
        ("tackle_cycles", "i4", _P),  # immobile for so many cycles more
        ("catch_ban", "i4", _P),
        ("collided", "u1", _P),  # COLLIDED_* bits of the last step
        ("counts", "i4", (N_PLAYERS, N_COUNTERS)),
        # view
        ("quality", "u1", _P),  # records.LOW, HIGH
        ("width", "u1", _P),  # records.NARROW, NORMAL, WIDE
        ("synch_see", "u1", _P),
        ("see_ticks", "i4", _P),  # ticks of send_step/4 since the last see
        # arm and attention
        ("arm_pos", "f8", (N_PLAYERS, 2)),  # absolute target
        ("arm_movable", "i4", _P),
        ("arm_expires", "i4", _P),
        ("arm_age", "i4", _P),
        ("focus_side", "u1", _P),  # records.NO_SIDE, LEFT, RIGHT
        ("focus_unum", "u1", _P),
        # speech
        ("hear_own", "f8", _P),  # hearing capacity for team mates and opponents
        ("hear_other", "f8", _P),
        ("ear_off", "u1", _P),  # bits: 1 own complete, 2 own partial, 4 other complete, 8 other partial
        ("said_n", "i4", _P),  # the last message of this cycle, 0: none
        ("said", "u1", (N_PLAYERS, SAY_SIZE)),
        ("said_pos", "f8", (N_PLAYERS, 2)),  # where the speaker stood
        # referee
        ("stuck_pos", "f8", (2,)),
        ("stuck_cycles", "i4"),
        ("n_keepers", "i4"),  # counted once, at the first play_on; 0 before
        ("n_takers", "i4"),
        ("taken", "i4"),  # steps a taker was in kicking range
        ("episode", "i4"),  # number of the running episode, from 1
        ("episode_start", "i4"),
        # clock
        ("clock", "i4"),  # virtual ms since the last step-boundary that is a multiple of all steps
    ]
)
"""A whole match."""

EPISODE = np.dtype([("episode", "i4"), ("start", "i4"), ("end", "i4"), ("taken", "u1")])
"""A finished episode: number, first and last cycle, taken (1) or out (0)."""


def index(side: int, unum: int) -> int:
    """Index of a player: side ``records.LEFT`` or ``RIGHT``, uniform number 1 .. 11."""
    return (0 if side == LEFT else MAX_PLAYERS) + unum - 1


def streams(seed: int) -> NDArray[np.uint64]:
    """Random streams of a match, shape (3, 4): PHYSICS, PERCEPTION, LANDMARKS."""
    return np.stack([rng.stream(seed, rng.SERVER, which) for which in range(3)])
