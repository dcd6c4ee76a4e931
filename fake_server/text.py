"""What the server says to players: kernels that write see, sense_body and fullstate, and the other messages as strings.

The kernels write the records that perception filled, byte for byte as rcssserver 19.0.0 prints them
(src/serializerplayerstdv8, v13, v14 and v18). No message here ends in NUL: the connection adds it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fake_server.digits import Buffer, ascii_bytes, put_bytes, put_int, put_number, put_spaced, put_spaced_int, put_text
from fake_server.simulation.hearing import HEAR_FULL, HEAR_SELF, voice_direction
from fake_server.simulation.state import (
    C_CATCH,
    C_CHANGE_FOCUS,
    C_CHANGE_VIEW,
    C_DASH,
    C_KICK,
    C_MOVE,
    C_POINTTO,
    C_SAY,
    C_TURN,
    C_TURN_NECK,
    N_PLAYERS,
    unum_of,
)
from rcss_hat.numeric.angles import RAD
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.protocol.landmarks import LANDMARK_NAMES, LINE_NAMES
from rcss_hat.protocol.records import (
    BALL,
    CLOSE_BALL,
    CLOSE_FLAG,
    CLOSE_GOAL,
    CLOSE_PLAYER,
    COLLIDED_BALL,
    COLLIDED_PLAYER,
    COLLIDED_POST,
    COUNT_NAMES,
    HAS_CHANGE,
    HAS_DISTANCE,
    HAS_FACING,
    HAS_POINTING,
    HIGH,
    IS_KICKING,
    IS_TACKLING,
    LEFT,
    LINE,
    MAX_PLAYERS,
    N_COUNTS,
    NARROW,
    NO_SIDE,
    PLAYER,
    WIDE,
)

MAX_MESSAGE = 8192
"""Largest datagram either way, bytes."""
FIRST_VERSION, LAST_VERSION = 8, 19
"""Protocol versions of players that are served."""

_SPACE, _OPEN, _CLOSE, _T, _K = 32, 40, 41, 116, 107
_L, _R = 108, 114


def _table(texts: dict[int, str]) -> tuple[Buffer, NDArray[np.int64]]:
    """Pack texts into rows of bytes, with their lengths; row i is text i."""
    sizes = np.zeros(max(texts) + 1, dtype=np.int64)
    rows = np.zeros((max(texts) + 1, max(map(len, texts.values()))), dtype=np.uint8)
    for i, text in texts.items():
        sizes[i] = len(text)
        rows[i, : len(text)] = np.frombuffer(text.encode("ascii"), dtype=np.uint8)
    return rows, sizes


_NAMES, _NAME_SIZES = _table(
    dict(enumerate(LANDMARK_NAMES))
    | {LINE + i: name for i, name in enumerate(LINE_NAMES)}
    | {BALL: "b", CLOSE_BALL: "B", CLOSE_PLAYER: "P", CLOSE_FLAG: "F", CLOSE_GOAL: "G"}
)
_COUNTS, _COUNT_SIZES = _table({i: f") ({name} " for i, name in enumerate(COUNT_NAMES)})
_GOALIE = ascii_bytes(" goalie")
_SEE = ascii_bytes("(see ")


def team_names(own: str, other: str) -> tuple[Buffer, NDArray[np.int64]]:
    """Return how an observer calls a player of no known team, of its own and of the other team.

    Parameters
    ----------
    own, other : str
        Team names.

    Returns
    -------
    names : ndarray of uint8, shape (3, n)
        Rows by records.UNKNOWN_TEAM, OWN_TEAM, OTHER_TEAM.
    sizes : ndarray of int64, shape (3,)
    """
    return _table({0: "p", 1: f'p "{own}"', 2: f'p "{other}"'})


# --- see --------------------------------------------------------------------------------------------------------------
@inlined
def _put_name(
    see: NDArray[np.void], k: int, teams: Buffer, team_sizes: NDArray[np.int64], buffer: Buffer, at: int
) -> int:
    buffer[at] = _OPEN
    at += 1
    code = see["code"][0, k]
    if code == PLAYER:
        team = see["team"][0, k]
        at = put_bytes(buffer, at, teams[team], team_sizes[team])
        if see["unum"][0, k] > 0:
            at = put_spaced_int(buffer, at, see["unum"][0, k])
            if see["goalie"][0, k]:
                at = put_text(buffer, at, _GOALIE)
    else:
        at = put_bytes(buffer, at, _NAMES[code], _NAME_SIZES[code])
    buffer[at] = _CLOSE
    return at + 1


@inlined
def _put_fields(see: NDArray[np.void], k: int, buffer: Buffer, at: int) -> int:
    bits = see["fields"][0, k]
    if bits & HAS_DISTANCE:
        at = put_spaced(buffer, at, see["distance"][0, k])
    at = put_spaced_int(buffer, at, int(see["direction"][0, k]))
    if bits & HAS_CHANGE:
        at = put_spaced(buffer, at, see["distance_change"][0, k])
        at = put_spaced(buffer, at, see["direction_change"][0, k])
    if bits & HAS_FACING:
        at = put_spaced_int(buffer, at, int(see["body"][0, k]))
        at = put_spaced_int(buffer, at, int(see["head"][0, k]))
    if bits & HAS_POINTING:
        at = put_spaced_int(buffer, at, int(see["pointing"][0, k]))
    if bits & (IS_TACKLING | IS_KICKING):
        buffer[at] = _SPACE
        buffer[at + 1] = _T if bits & IS_TACKLING else _K
        at += 2
    return at


@kernel
def write_see(see: NDArray[np.void], teams: Buffer, team_sizes: NDArray[np.int64], buffer: Buffer) -> int:
    """Write a see message.

    Parameters
    ----------
    see : ndarray of records.SEE, shape (1,)
    teams, team_sizes
        As from `team_names`.
    buffer : ndarray of uint8, shape (MAX_MESSAGE,)

    Returns
    -------
    int
        Length of the message.
    """
    at = put_text(buffer, 0, _SEE)
    at = put_int(buffer, at, see["time"][0])
    for k in range(see["n"][0]):
        buffer[at] = _SPACE
        buffer[at + 1] = _OPEN
        at = _put_name(see, k, teams, team_sizes, buffer, at + 2)
        at = _put_fields(see, k, buffer, at)
        buffer[at] = _CLOSE
        at += 1
    buffer[at] = _CLOSE
    return at + 1


# --- sense_body -------------------------------------------------------------------------------------------------------
_SENSE_BODY = ascii_bytes("(sense_body ")
_VIEW_MODE = ascii_bytes(" (view_mode ")
_HIGH, _LOW = ascii_bytes("high"), ascii_bytes("low")
_NARROW, _NORMAL, _WIDE = ascii_bytes(" narrow)"), ascii_bytes(" normal)"), ascii_bytes(" wide)")
_STAMINA = ascii_bytes(" (stamina ")
_SPEED = ascii_bytes(") (speed ")
_HEAD_ANGLE = ascii_bytes(") (head_angle ")
_CHANGE_FOCUS = ascii_bytes(") (change_focus ")
_ARM = ascii_bytes(") (arm (movable ")
_EXPIRES = ascii_bytes(") (expires ")
_TARGET = ascii_bytes(") (target ")
_COUNT = ascii_bytes(") (count ")
_FOCUS = ascii_bytes(")) (focus (target ")
_NONE = ascii_bytes("none")
_TACKLE = ascii_bytes(")) (tackle (expires ")
_END = ascii_bytes("))")
_COLLISION = ascii_bytes(" (collision")
_NO_COLLISION = ascii_bytes(" none)")
_WITH_BALL, _WITH_PLAYER, _WITH_POST = ascii_bytes(" (ball)"), ascii_bytes(" (player)"), ascii_bytes(" (post)")
_FOUL = ascii_bytes(" (foul (charged 0) (card none))")
_FOCUS_POINT = ascii_bytes(" (focus_point ")


@inlined
def _put_view_mode(buffer: Buffer, at: int, quality: int, width: int) -> int:
    at = put_text(buffer, at, _HIGH) if quality == HIGH else put_text(buffer, at, _LOW)
    if width == NARROW:
        return put_text(buffer, at, _NARROW)
    return put_text(buffer, at, _WIDE) if width == WIDE else put_text(buffer, at, _NORMAL)


@kernel
def _put_arm(buffer: Buffer, at: int, movable: int, expires: int, distance: float, direction: int, count: int) -> int:
    """Write the own arm from ``) (arm`` on, its last number last."""
    at = put_int(buffer, put_text(buffer, at, _ARM), movable)
    at = put_int(buffer, put_text(buffer, at, _EXPIRES), expires)
    at = put_number(buffer, put_text(buffer, at, _TARGET), distance)
    at = put_spaced_int(buffer, at, direction)
    return put_int(buffer, put_text(buffer, at, _COUNT), count)


@kernel
def _put_collision(buffer: Buffer, at: int, collision: int) -> int:
    at = put_text(buffer, at, _COLLISION)
    if collision == 0:
        return put_text(buffer, at, _NO_COLLISION)
    if collision & COLLIDED_BALL:
        at = put_text(buffer, at, _WITH_BALL)
    if collision & COLLIDED_PLAYER:
        at = put_text(buffer, at, _WITH_PLAYER)
    if collision & COLLIDED_POST:
        at = put_text(buffer, at, _WITH_POST)
    buffer[at] = _CLOSE
    return at + 1


@kernel
def _put_focus_point(match: NDArray[np.void], i: int, buffer: Buffer, at: int) -> int:
    at = put_number(buffer, put_text(buffer, at, _FOCUS_POINT), match["focus_dist"][0, i])
    at = put_spaced(buffer, at, match["focus_dir"][0, i] * RAD)
    buffer[at] = _CLOSE
    return at + 1


@kernel
def write_sense_body(sense: NDArray[np.void], match: NDArray[np.void], i: int, buffer: Buffer) -> int:
    """Write the sense_body message of player ``i`` for the version of the protocol that its client speaks.

    Collisions are told from version 12 on, stamina capacity from 13, foul from 14, focus point from 18.

    Parameters
    ----------
    sense : ndarray of records.SENSE_BODY, shape (1,)
    match : ndarray of MATCH, shape (1,)
        For the version, and for the focus point, which the record does not hold.
    i : int
        Index of the player.
    buffer : ndarray of uint8, shape (MAX_MESSAGE,)

    Returns
    -------
    int
        Length of the message.
    """
    version = match["version"][0, i]
    at = put_int(buffer, put_text(buffer, 0, _SENSE_BODY), sense["time"][0])
    at = _put_view_mode(buffer, put_text(buffer, at, _VIEW_MODE), sense["quality"][0], sense["width"][0])
    at = put_number(buffer, put_text(buffer, at, _STAMINA), sense["stamina"][0])
    at = put_spaced(buffer, at, sense["effort"][0])
    if version >= 13:
        at = put_spaced(buffer, at, sense["capacity"][0])
    at = put_number(buffer, put_text(buffer, at, _SPEED), sense["speed"][0])
    at = put_spaced_int(buffer, at, int(sense["speed_direction"][0]))
    at = put_int(buffer, put_text(buffer, at, _HEAD_ANGLE), int(sense["head_angle"][0]))
    counts = sense["counts"][0]
    for k in range(N_COUNTS):
        at = put_int(buffer, put_bytes(buffer, at, _COUNTS[k], _COUNT_SIZES[k]), counts[k])
    if version >= 18:
        at = put_int(buffer, put_text(buffer, at, _CHANGE_FOCUS), match["counts"][0, i, C_CHANGE_FOCUS])
    arm_direction = int(sense["arm_direction"][0])
    at = _put_arm(
        buffer, at, sense["arm_movable"][0], sense["arm_expires"][0], sense["arm_distance"][0], arm_direction,
        sense["arm_count"][0],
    )  # fmt: skip
    at = put_text(buffer, at, _FOCUS)
    if sense["focus_side"][0] == NO_SIDE:
        at = put_text(buffer, at, _NONE)
    else:
        buffer[at] = _L if sense["focus_side"][0] == LEFT else _R
        at = put_spaced_int(buffer, at + 1, sense["focus_unum"][0])
    at = put_int(buffer, put_text(buffer, at, _COUNT), sense["focus_count"][0])
    at = put_int(buffer, put_text(buffer, at, _TACKLE), sense["tackle_expires"][0])
    at = put_int(buffer, put_text(buffer, at, _COUNT), sense["tackle_count"][0])
    at = put_text(buffer, at, _END)
    if version >= 12:
        at = _put_collision(buffer, at, sense["collision"][0])
    if version >= 14:
        at = put_text(buffer, at, _FOUL)
    if version >= 18:
        at = _put_focus_point(match, i, buffer, at)
    buffer[at] = _CLOSE
    return at + 1


# --- fullstate --------------------------------------------------------------------------------------------------------
_FULLSTATE = ascii_bytes("(fullstate ")
_PMODE = ascii_bytes(" (pmode ")
_VMODE = ascii_bytes(") (vmode ")
_FULL_COUNT = ascii_bytes(" (count ")
_SCORE = ascii_bytes(")) (score ")
_BALL = ascii_bytes(") ((b)")
_PLAYER = ascii_bytes(" ((p ")
_FULL_ORDER = np.array(
    [C_KICK, C_DASH, C_TURN, C_CATCH, C_MOVE, C_TURN_NECK, C_CHANGE_VIEW, C_SAY, C_CHANGE_FOCUS], dtype=np.int64
)


@kernel
def arm_target(match: NDArray[np.void], i: int) -> tuple[float, float]:
    """Return distance (m) and direction (rad, relative to the face) of a player's arm target; zeros when it is down."""
    if match["arm_expires"][0, i] <= 0:
        return 0.0, 0.0
    x = match["arm_pos"][0, i, 0] - match["pos"][0, i, 0]
    y = match["arm_pos"][0, i, 1] - match["pos"][0, i, 1]
    face = match["body"][0, i] + match["neck"][0, i]
    # rotated like the server does it, not by subtracting angles: the last digits differ
    turned_x = x * math.cos(-face) - y * math.sin(-face)
    turned_y = x * math.sin(-face) + y * math.cos(-face)
    direction = 0.0 if turned_x == 0.0 and turned_y == 0.0 else math.atan2(turned_y, turned_x)
    return math.sqrt(turned_x * turned_x + turned_y * turned_y), direction


@kernel
def _put_full_player(match: NDArray[np.void], i: int, version: int, buffer: Buffer, at: int) -> int:
    at = put_text(buffer, at, _PLAYER)
    buffer[at] = _L if i < MAX_PLAYERS else _R
    at = put_spaced_int(buffer, at + 1, i % MAX_PLAYERS + 1)
    if match["goalie"][0, i]:
        buffer[at] = _SPACE
        buffer[at + 1] = 103  # g
        at += 2
    if version >= 14 or not match["goalie"][0, i]:
        at = put_spaced_int(buffer, at, match["type"][0, i])
    buffer[at] = _CLOSE
    at += 1
    at = put_spaced(buffer, at, match["pos"][0, i, 0])
    at = put_spaced(buffer, at, match["pos"][0, i, 1])
    at = put_spaced(buffer, at, match["vel"][0, i, 0])
    at = put_spaced(buffer, at, match["vel"][0, i, 1])
    at = put_spaced(buffer, at, match["body"][0, i] * RAD)
    at = put_spaced(buffer, at, match["neck"][0, i] * RAD)
    if match["arm_expires"][0, i] > 0:
        distance, direction = arm_target(match, i)
        at = put_spaced(buffer, at, distance)
        at = put_spaced(buffer, at, direction)
    if version >= 18:
        at = _put_focus_point(match, i, buffer, at)
    at = put_number(buffer, put_text(buffer, at, _STAMINA), match["stamina"][0, i])
    at = put_spaced(buffer, at, match["effort"][0, i])
    at = put_spaced(buffer, at, match["recovery"][0, i])
    if version >= 13:
        at = put_spaced(buffer, at, match["capacity"][0, i])
    buffer[at] = _CLOSE
    at += 1
    if version >= 13 and (match["tackle_cycles"][0, i] > 0 or match["kick_cycles"][0, i] > 0):
        buffer[at] = _SPACE
        buffer[at + 1] = _T if match["tackle_cycles"][0, i] > 0 else _K
        at += 2
    buffer[at] = _CLOSE
    return at + 1


@kernel
def write_fullstate(match: NDArray[np.void], i: int, mode: Buffer, buffer: Buffer) -> int:
    """Write the fullstate message of player ``i``.

    Parameters
    ----------
    match : ndarray of MATCH, shape (1,)
    i : int
        Index of the player who receives it.
    mode : ndarray of uint8
        Name of the play mode.
    buffer : ndarray of uint8, shape (MAX_MESSAGE,)

    Returns
    -------
    int
        Length of the message.
    """
    version = match["version"][0, i]
    at = put_int(buffer, put_text(buffer, 0, _FULLSTATE), match["time"][0])
    at = put_text(buffer, put_text(buffer, at, _PMODE), mode)
    at = _put_view_mode(buffer, put_text(buffer, at, _VMODE), match["quality"][0, i], match["width"][0, i])
    at = put_text(buffer, at, _FULL_COUNT)
    for k in range(9 if version >= 18 else 8):
        if k > 0:
            buffer[at] = _SPACE
            at += 1
        at = put_int(buffer, at, match["counts"][0, i, _FULL_ORDER[k]])
    distance, direction = arm_target(match, i)
    at = _put_arm(
        buffer, at, match["arm_movable"][0, i], match["arm_expires"][0, i], distance, int(round(direction * RAD)),
        match["counts"][0, i, C_POINTTO],
    )  # fmt: skip
    own = 0 if i < MAX_PLAYERS else 1
    at = put_int(buffer, put_text(buffer, at, _SCORE), match["score"][0, own])
    at = put_spaced_int(buffer, at, match["score"][0, 1 - own])
    at = put_text(buffer, at, _BALL)
    at = put_spaced(buffer, at, match["ball_pos"][0, 0])
    at = put_spaced(buffer, at, match["ball_pos"][0, 1])
    at = put_spaced(buffer, at, match["ball_vel"][0, 0])
    at = put_spaced(buffer, at, match["ball_vel"][0, 1])
    buffer[at] = _CLOSE
    at += 1
    for j in range(N_PLAYERS):
        if match["enabled"][0, j]:
            at = _put_full_player(match, j, version, buffer, at)
    buffer[at] = _CLOSE
    return at + 1


# --- hear --------------------------------------------------------------------------------------------------------
_HEAR = ascii_bytes("(hear ")
_SELF = ascii_bytes(" self ")
_OUR = ascii_bytes(" our ")
_OPP = ascii_bytes(" opp")
_QUOTE = 34


@inlined
def _put_quoted(match: NDArray[np.void], m: int, buffer: Buffer, at: int) -> int:
    buffer[at] = _QUOTE
    at = put_bytes(buffer, at + 1, match["heard"][0, m], match["heard_n"][0, m])
    buffer[at] = _QUOTE
    return at + 1


@kernel
def write_hear(
    match: NDArray[np.void], i: int, order: NDArray[np.int32], n: int, buffer: Buffer, ends: NDArray[np.int64]
) -> None:
    """Write what player ``i`` hears of players, one datagram behind the other, each with its NUL.

    Parameters
    ----------
    match : ndarray of MATCH, shape (1,)
    i : int
        Index of the listener.
    order : ndarray of int32, shape (MAX_MESSAGES, 2)
        As filled by ``hearing.deliver``.
    n : int
        Number of messages.
    buffer : ndarray of uint8, shape (MAX_MESSAGE,)
    ends : ndarray of int64, shape (MAX_MESSAGES,)
        Set to the end of every message.
    """
    at = 0
    for k in range(n):
        m, how = order[k, 0], order[k, 1]
        speaker = match["heard_by"][0, m]
        own = (speaker < MAX_PLAYERS) == (i < MAX_PLAYERS)
        at = put_int(buffer, put_text(buffer, at, _HEAR), match["time"][0])
        if how == HEAR_SELF:
            at = _put_quoted(match, m, buffer, put_text(buffer, at, _SELF))
        else:
            if how == HEAR_FULL:
                at = put_spaced_int(buffer, at, voice_direction(match, i, speaker))
            at = put_int(buffer, put_text(buffer, at, _OUR), unum_of(speaker)) if own else put_text(buffer, at, _OPP)
            if how == HEAR_FULL:
                buffer[at] = _SPACE
                at = _put_quoted(match, m, buffer, at + 1)
        buffer[at] = _CLOSE
        buffer[at + 1] = 0
        at += 2
        ends[k] = at


# --- short messages ---------------------------------------------------------------------------------------------------
def init_reply(side: str, unum: int, mode: str) -> str:
    """Return the reply to an accepted ``(init ...)``; ``side`` is ``l`` or ``r``."""
    return f"(init {side} {unum} {mode})"


def reconnect_reply(side: str, mode: str) -> str:
    """Return the reply to an accepted ``(reconnect ...)``."""
    return f"(reconnect {side} {mode})"


def score_reply(time: int, ours: int, theirs: int) -> str:
    """Return the reply to ``(score)``."""
    return f"(score {time} {ours} {theirs})"


def hear_referee(time: int, message: str) -> str:
    """Return how players hear the referee."""
    return f"(hear {time} referee {message})"


def hear_coach(time: int, message: str) -> str:
    """Return how players hear the trainer."""
    return f'(hear {time} coach "{message}")'


def change_player_type(unum: int, player_type: int | None) -> str:
    """Return the news of a substitution: with the type to the own team, without it to the opponents."""
    return f"(change_player_type {unum})" if player_type is None else f"(change_player_type {unum} {player_type})"
