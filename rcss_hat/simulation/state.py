"""The state of a match: everything a server knows, in one record.

Players are indexed 0 .. 21: left 1 .. 11, then right 1 .. 11 (``index(side, unum)``). Positions are metres, velocities
metres per cycle, angles radians (as inside rcssserver), world axes (x to the right goal, y down). The record is a
structured array of shape ``(1,)``; kernels index ``match["pos"][0, i, 0]``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric import rng
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.protocol.records import HIGH, LEFT, MAX_PLAYERS, NORMAL, RIGHT, SAY_SIZE
from rcss_hat.simulation.world import World

N_PLAYERS = 2 * MAX_PLAYERS

# Play modes: identifiers of the monitor protocol (19.0.0, src/types.h); names in rcss_hat.protocol.
BEFORE_KICK_OFF, TIME_OVER, PLAY_ON = 1, 2, 3
KICK_OFF_LEFT, KICK_OFF_RIGHT = 4, 5
KICK_IN_LEFT, KICK_IN_RIGHT = 6, 7
FREE_KICK_LEFT, FREE_KICK_RIGHT = 8, 9
CORNER_KICK_LEFT, CORNER_KICK_RIGHT = 10, 11
GOAL_KICK_LEFT, GOAL_KICK_RIGHT = 12, 13
GOAL_LEFT, GOAL_RIGHT = 14, 15
DROP_BALL = 16
OFFSIDE_LEFT, OFFSIDE_RIGHT = 17, 18
FOUL_CHARGE_LEFT, FOUL_CHARGE_RIGHT = 24, 25
FOUL_PUSH_LEFT, FOUL_PUSH_RIGHT = 26, 27
BACK_PASS_LEFT, BACK_PASS_RIGHT = 32, 33
FREE_KICK_FAULT_LEFT, FREE_KICK_FAULT_RIGHT = 34, 35
CATCH_FAULT_LEFT, CATCH_FAULT_RIGHT = 36, 37
INDIRECT_FREE_KICK_LEFT, INDIRECT_FREE_KICK_RIGHT = 38, 39
ILLEGAL_DEFENSE_LEFT, ILLEGAL_DEFENSE_RIGHT = 50, 51
N_MODES = 52

# Command counters: the monitor's order.
N_COUNTERS = 12
(C_KICK, C_DASH, C_TURN, C_CATCH, C_MOVE, C_TURN_NECK, C_CHANGE_VIEW, C_SAY, C_TACKLE, C_POINTTO, C_ATTENTIONTO,
 C_CHANGE_FOCUS) = range(12)  # fmt: skip

# State flags of a player (monitor protocol).
(F_STAND, F_KICK, F_KICK_FAULT, F_GOALIE, F_CATCH, F_CATCH_FAULT, F_BALL_TO_PLAYER, F_PLAYER_TO_BALL, F_DISCARD, F_LOST,
 F_BALL_COLLIDE, F_PLAYER_COLLIDE, F_TACKLE, F_TACKLE_FAULT) = (1 << bit for bit in range(14))  # fmt: skip
F_POST_COLLIDE, F_YELLOW_CARD, F_RED_CARD = 0x10000, 0x40000, 0x80000

# What the referee did in a step (events; bits of match["events"]), in the order in which the server announces it.
E_PLAY_ON, E_EPISODE_OUT, E_EPISODE_TAKEN, E_DROP_BALL, E_TIME_UP = 1, 2, 4, 8, 16
E_HALF_TIME, E_TIME_EXTENDED, E_WITHOUT_A_TEAM, E_CAUGHT = 32, 64, 128, 256

# Random streams of a match: rows of its (3, 4) array of streams.
PHYSICS, PERCEPTION, LANDMARKS = range(3)
"""PHYSICS: motion, kicks, tackles, placement, order of hearing. PERCEPTION: what is lost of players and ball.
LANDMARKS: what is lost of landmarks, apart so that callers that need no landmarks may skip them."""

# What the legs do in this cycle.
LEG_FREE, LEG_DASH, LEG_BUSY = range(3)
# Bits of ear_off.
EAR_OWN_COMPLETE, EAR_OWN_PARTIAL, EAR_OTHER_COMPLETE, EAR_OTHER_PARTIAL = 1, 2, 4, 8
EARS_AT_FIRST = EAR_OWN_PARTIAL | EAR_OTHER_PARTIAL
"""Nobody hears messages in part until he asks for it (19.0.0, src/audio.h)."""

MAX_MESSAGES = 60
"""Player messages kept per cycle; what is said beyond them in one cycle is lost."""

_P = (N_PLAYERS,)
_M = (MAX_MESSAGES,)

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
        ("catcher", "i8"),  # index of the goalie that holds the ball, -1: nobody
        # players
        ("n_players", "i4"),
        ("players", "i8", _P),  # indices of the enabled players in rising order, n_players of them
        ("enabled", "u1", _P),  # connected and not discarded
        ("goalie", "u1", _P),
        ("type", "u1", _P),
        ("version", "u1", _P),  # protocol version of the client
        ("size", "f8", _P),  # of the player's type
        ("effort_max", "f8", _P),  # of the player's type
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
        ("leg", "u1", (N_PLAYERS, 2)),  # LEG_*: left, right leg
        ("leg_power", "f8", (N_PLAYERS, 2)),  # the dash of this cycle, applied at the start of the next step (19)
        ("leg_dir", "f8", (N_PLAYERS, 2)),  # degrees relative to the body
        ("command_done", "u1", _P),  # a body command was accepted in this cycle
        ("neck_done", "u1", _P),
        ("flags", "i4", _P),  # F_* as frames and logs of the last step show them, without F_STAND and F_GOALIE
        ("flags_next", "i4", _P),  # what commands have added since
        ("kick_cycles", "i4", _P),  # above 0: the player is seen kicking
        ("tackle_cycles", "i4", _P),  # immobile for so many cycles more
        ("catch_ban", "i4", _P),
        ("moves_since_catch", "i4", _P),
        ("collided", "u1", _P),  # COLLIDED_* bits of the last step
        ("counts", "i4", (N_PLAYERS, N_COUNTERS)),
        # view
        ("quality", "u1", _P),  # records.LOW, HIGH
        ("width", "u1", _P),  # records.NARROW, NORMAL, WIDE
        ("synch_see", "u1", _P),
        ("gaussian_see", "u1", _P),
        ("see_ticks", "i4", _P),  # ticks of send_step/4 since the last see
        ("focus_dist", "f8", _P),  # focus point, m
        ("focus_dir", "f8", _P),  # rad relative to the face
        # arm and attention
        ("arm_pos", "f8", (N_PLAYERS, 2)),  # absolute target
        ("arm_movable", "i4", _P),  # cycles until the arm may be moved again
        ("arm_expires", "i4", _P),  # cycles the arm stays up, 0: down
        ("focus_side", "u1", _P),  # records.NO_SIDE, LEFT, RIGHT
        ("focus_unum", "u1", _P),
        # speech
        ("hear_own", "f8", _P),  # hearing capacity for team mates and opponents
        ("hear_other", "f8", _P),
        ("ear_off", "u1", _P),  # EAR_* bits
        ("n_said", "i4"),  # messages since the last step
        ("said_by", "i8", _M),  # index of the speaker
        ("said_n", "i4", _M),  # length
        ("said", "u1", (MAX_MESSAGES, SAY_SIZE)),
        ("said_to", "i8", _M),  # bit i: player i is near enough and has not stopped his ears
        ("n_heard", "i4"),  # the messages of the cycle before, to be heard now
        ("heard_by", "i8", _M),  # index of the speaker
        ("heard_n", "i4", _M),
        ("heard", "u1", (MAX_MESSAGES, SAY_SIZE)),
        ("heard_to", "i8", _M),
        # referee
        ("kick_off_side", "u1"),  # records.NO_SIDE, LEFT, RIGHT
        ("half_count", "i4"),  # halves that have ended
        ("mode_steps", "i4"),  # steps in the present mode, for restarts and drop balls
        ("stuck_pos", "f8", (2,)),
        ("stuck_cycles", "i4"),
        ("n_keepers", "i4"),  # counted once, at the first play_on; 0 before
        ("n_takers", "i4"),
        ("taken", "i4"),  # steps a taker was in kicking range
        ("episode", "i4"),  # number of the running episode, from 1
        ("episode_start", "i4"),
        ("last_start", "i4"),  # of the episode that ended last
        ("last_end", "i4"),
        ("last_taken", "u1"),
        # places that colliding objects propose in a step: x, y, how many, whether any; the ball is last
        ("proposals", "f8", (N_PLAYERS + 1, 4)),
        # clock
        ("clock", "i4"),  # virtual ms since the last step-boundary that is a multiple of all steps
    ]
)
"""A whole match."""

EPISODE = np.dtype([("episode", "i4"), ("start", "i4"), ("end", "i4"), ("taken", "u1")])
"""A finished episode: number, first and last cycle, taken (1) or out (0)."""

BENCH_Y = -37.0


@inlined
def index(side: int, unum: int) -> int:
    """Index of a player: side ``records.LEFT`` or ``RIGHT``, uniform number 1 .. 11."""
    return (0 if side == LEFT else MAX_PLAYERS) + unum - 1


@inlined
def side_of(i: int) -> int:
    """Side of the player with an index, ``records.LEFT`` or ``RIGHT``."""
    return LEFT if i < MAX_PLAYERS else RIGHT


@inlined
def unum_of(i: int) -> int:
    """Uniform number of the player with an index."""
    return i + 1 if i < MAX_PLAYERS else i + 1 - MAX_PLAYERS


def streams(seed: int) -> NDArray[np.uint64]:
    """Random streams of a match, shape (3, 4): PHYSICS, PERCEPTION, LANDMARKS."""
    return np.stack([rng.stream(seed, rng.SERVER, which) for which in range(3)])


@kernel
def to_bench(match: NDArray[np.void], i: int) -> None:
    """Put a player on his place at the bench, at rest (19.0.0, src/player.cpp, disable)."""
    away = -3.0 * unum_of(i)
    match["pos"][0, i, 0] = away if side_of(i) == LEFT else -away
    match["pos"][0, i, 1] = BENCH_Y
    for axis in range(2):
        match["vel"][0, i, axis] = 0.0
        match["acc"][0, i, axis] = 0.0


@kernel
def recover(match: NDArray[np.void], params: NDArray[np.void], i: int) -> None:
    """Restore stamina, effort, recovery, stamina capacity and hearing (19.0.0, src/player.cpp, recoverAll)."""
    match["stamina"][0, i] = params["stamina_max"][0]
    match["recovery"][0, i] = 1.0
    match["effort"][0, i] = match["effort_max"][0, i]
    match["capacity"][0, i] = params["stamina_capacity"][0]
    match["hear_own"][0, i] = params["hear_max"][0]
    match["hear_other"][0, i] = params["hear_max"][0]


@kernel
def list_players(match: NDArray[np.void]) -> None:
    """Write the list of enabled players, over which all kernels loop."""
    n = 0
    for i in range(N_PLAYERS):
        if match["enabled"][0, i]:
            match["players"][0, n] = i
            n += 1
    match["n_players"][0] = n


def new_match(params: NDArray[np.void]) -> NDArray[np.void]:
    """Make a match before kick-off: nobody connected, all 22 players on the bench, the ball in the centre.

    Parameters
    ----------
    params : ndarray of PARAMS, shape (1,)

    Returns
    -------
    ndarray of MATCH, shape (1,)
    """
    match = np.zeros(1, dtype=MATCH)
    match["mode"][0] = BEFORE_KICK_OFF
    match["catcher"][0] = -1
    match["kick_off_side"][0] = LEFT
    for i in range(N_PLAYERS):
        match["size"][0, i] = params["player_size"][0]
        match["effort_max"][0, i] = params["effort_init"][0]
        match["quality"][0, i] = HIGH
        match["width"][0, i] = NORMAL
        match["ear_off"][0, i] = EARS_AT_FIRST
        to_bench(match, i)
        recover(match, params, i)
        match["kick_cycles"][0, i] = 1
    return match


@kernel
def connect(match: NDArray[np.void], params: NDArray[np.void], i: int, version: int, goalie: bool) -> None:
    """Enable a player who has connected or reconnected (19.0.0, src/player.cpp, init).

    Parameters
    ----------
    match : ndarray of MATCH, shape (1,)
    params : ndarray of PARAMS, shape (1,)
    i : int
        Index of the player.
    version : int
        Protocol version of the client; from 18 on it sees in step with the simulation (synch_see), as in 19.0.0.
    goalie : bool
    """
    match["enabled"][0, i] = 1
    match["goalie"][0, i] = goalie
    match["version"][0, i] = version
    match["flags"][0, i] = 0
    match["flags_next"][0, i] = 0
    match["catch_ban"][0, i] = 0
    match["moves_since_catch"][0, i] = 0
    match["see_ticks"][0, i] = 0
    # The right team looks to the left until the first step, which commits the angle 0.
    match["body"][0, i] = 0.0 if side_of(i) == LEFT else np.pi
    if version >= 18 and not params["version_11"][0]:
        match["synch_see"][0, i] = 1
        match["quality"][0, i] = HIGH
    list_players(match)


@kernel
def substitute(world: World, i: int, player_type: int) -> None:
    """Give a player another type, and fresh stamina (19.0.0, src/player.cpp, substitute)."""
    match, params, types = world.match, world.params, world.types
    match["type"][0, i] = player_type
    match["size"][0, i] = types["player_size"][player_type]
    match["effort_max"][0, i] = types["effort_max"][player_type]
    match["flags_next"][0, i] = 0
    recover(match, params, i)


@kernel
def disconnect(match: NDArray[np.void], i: int) -> None:
    """Disable a player who has gone; he moves to the bench and keeps his uniform number (19.0.0, src/player.cpp)."""
    if match["catcher"][0] == i:
        match["catcher"][0] = -1
    match["enabled"][0, i] = 0
    match["flags"][0, i] = 0
    match["flags_next"][0, i] = 0
    match["command_done"][0, i] = 1
    to_bench(match, i)
    list_players(match)
