"""The see message: bytes to the SEE record and back (19.0.0, src/visualsenderplayer, src/serializerplayerstdv8 on)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import inlined, kernel, njit
from rcss_hat.protocol import scan
from rcss_hat.protocol.digits import (
    Buffer,
    ascii_bytes,
    put_bytes,
    put_int,
    put_spaced,
    put_spaced_int,
    put_text,
    text_table,
)
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.protocol.landmarks import LANDMARK_NAMES, LINE_NAMES
from rcss_hat.protocol.records import (
    BALL,
    CLOSE_BALL,
    CLOSE_FLAG,
    CLOSE_GOAL,
    CLOSE_PLAYER,
    HAS_CHANGE,
    HAS_DISTANCE,
    HAS_FACING,
    HAS_POINTING,
    IS_KICKING,
    IS_TACKLING,
    LINE,
    MAX_PLAYERS,
    MAX_SEEN,
    OTHER_TEAM,
    OWN_TEAM,
    PLAYER,
)
from rcss_hat.protocol.scan import (
    BAD_COUNT,
    BAD_RANGE,
    BAD_UNUM,
    BAD_WORD,
    LEFT_PARENTHESIS,
    NUL,
    QUOTE,
    RIGHT_PARENTHESIS,
    SPACE,
    TOO_MANY,
    WANT_CLOSE,
    WANT_NAME,
    WANT_NUMBER,
    WANT_OPEN,
    WANT_SPACE,
    byte,
    failure,
    integer,
    is_angle,
    is_quantity,
    key_of,
    number,
    skip_spaces,
    word,
)

_NO_CODE = 255
_LOWER_P, _LOWER_K, _LOWER_T = 112, 107, 116
_SEE, _GOALIE = key_of("see"), key_of("goalie")


def _codes() -> dict[str, int]:
    codes = {name: code for code, name in enumerate(LANDMARK_NAMES)}
    codes |= {name: LINE + i for i, name in enumerate(LINE_NAMES)}
    return codes | {"b": BALL, "B": CLOSE_BALL, "P": CLOSE_PLAYER, "F": CLOSE_FLAG, "G": CLOSE_GOAL}


def _perfect_table(codes: dict[str, int]) -> tuple[int, NDArray[np.int64], NDArray[np.uint8]]:
    """Find the smallest modulus that sends every name to a slot of its own.

    Returns
    -------
    size : int
    keys : ndarray of int64, shape (size,)
        Key of the name in each slot, -1 when empty.
    values : ndarray of uint8, shape (size,)
        Code of that name.
    """
    size = len(codes)
    while len({key_of(name) % size for name in codes}) < len(codes):
        size += 1
    keys = np.full(size, -1, dtype=np.int64)
    values = np.full(size, _NO_CODE, dtype=np.uint8)
    for name, code in codes.items():
        keys[key_of(name) % size] = key_of(name)
        values[key_of(name) % size] = code
    return size, keys, values


_SIZE, _KEYS, _VALUES = _perfect_table(_codes())


def parse_see(data: bytes, team: bytes, see: NDArray[np.void]) -> None:
    """Read a see message into a record.

    All forms of protocol versions 7 to 19: high and low quality, close objects, pointing, tackling, kicking. Objects
    whose name is not in the default landmark file are left out. Fields that the message does not give are 0.

    Parameters
    ----------
    data : bytes
        The message, with or without its NUL.
    team : bytes
        Name of the team that the receiver plays for.
    see : ndarray of SEE, shape (1,)
        Overwritten. After an error it holds no objects.

    Raises
    ------
    RemoteProtocolError
        When the message is malformed; names the position.
    """
    result = _parse(scan.to_array(data), _as_array(team), see)
    if result:
        see["n"][0] = 0
        raise RemoteProtocolError(f"bad see message: {scan.REASONS[result % 16]}", data, result // 16)


@lru_cache(maxsize=64)
def _as_array(team: bytes) -> NDArray[np.uint8]:
    return np.frombuffer(team, dtype=np.uint8)


@njit
def _parse(data: NDArray[np.uint8], team: NDArray[np.uint8], see: NDArray[np.void]) -> int:
    """Read ``(see TIME OBJECT ...)``; 0, or a failure."""
    if data[0] != LEFT_PARENTHESIS:
        return failure(WANT_OPEN, 0)
    key, i = word(data, 1)
    if key != _SEE:
        return failure(WANT_NAME, 1)
    if data[i] != SPACE:
        return failure(WANT_SPACE, i)
    i = skip_spaces(data, i)
    time, after = integer(data, i)
    if after < 0:
        return failure(WANT_NUMBER, i)
    i = skip_spaces(data, after)
    n = 0
    codes = see["code"][0]
    while data[i] == LEFT_PARENTHESIS:
        if n == MAX_SEEN:
            return failure(TOO_MANY, i)
        if data[i + 1] != LEFT_PARENTHESIS:
            return failure(WANT_OPEN, i + 1)
        error, i = _name(data, i + 2, team, see, n)
        if error == 0:
            error, i = _fields(data, i, see, n)
        if error != 0:
            return failure(error, i)
        if codes[n] != _NO_CODE:
            n += 1
        i = skip_spaces(data, i)
    if data[i] != RIGHT_PARENTHESIS:
        return failure(WANT_CLOSE, i)
    i = skip_spaces(data, i + 1)
    if data[i] != NUL:
        return failure(BAD_WORD, i)
    see["time"][0] = time
    see["n"][0] = n
    return 0


@njit
def _name(data: NDArray[np.uint8], i: int, team: NDArray[np.uint8], see: NDArray[np.void], k: int) -> tuple[int, int]:
    """Read an object's name up to its ``)``; returns a reason (0: none) and the index behind."""
    see["team"][0, k] = 0
    see["unum"][0, k] = 0
    see["goalie"][0, k] = 0
    if data[i] == _LOWER_P and (data[i + 1] == SPACE or data[i + 1] == RIGHT_PARENTHESIS):
        see["code"][0, k] = PLAYER
        return _player(data, i + 1, team, see, k)
    key = 0
    start = i
    while data[i] != RIGHT_PARENTHESIS:
        if data[i] < SPACE or data[i] > 126 or data[i] == LEFT_PARENTHESIS or data[i] == QUOTE:
            return WANT_CLOSE, i
        key = (key << 7) ^ byte(data, i) if i - start < 9 else 0
        i += 1
    if i == start:
        return WANT_NAME, i
    slot = key % _SIZE
    see["code"][0, k] = _VALUES[slot] if _KEYS[slot] == key else _NO_CODE
    return 0, i + 1


@njit
def _player(data: NDArray[np.uint8], i: int, team: NDArray[np.uint8], see: NDArray[np.void], k: int) -> tuple[int, int]:
    """Read the rest of ``p``, ``p "TEAM"``, ``p "TEAM" UNUM`` or ``p "TEAM" UNUM goalie``."""
    i = skip_spaces(data, i)
    if data[i] == QUOTE:
        start = i + 1
        i = start
        same = True
        while data[i] != QUOTE:
            if data[i] == NUL:
                return WANT_NAME, i
            same = same and i - start < len(team) and data[i] == team[i - start]
            i += 1
        see["team"][0, k] = OWN_TEAM if same and i - start == len(team) else OTHER_TEAM
        i = skip_spaces(data, i + 1)
        if data[i] != RIGHT_PARENTHESIS:
            unum, after = integer(data, i)
            if after < 0 or unum < 1 or unum > MAX_PLAYERS:
                return BAD_UNUM, i
            see["unum"][0, k] = unum
            i = skip_spaces(data, after)
            key, after = word(data, i)
            if key == _GOALIE:
                see["goalie"][0, k] = 1
                i = skip_spaces(data, after)
    if data[i] != RIGHT_PARENTHESIS:
        return WANT_CLOSE, i
    return 0, i + 1


@njit
def _fields(data: NDArray[np.uint8], i: int, see: NDArray[np.void], k: int) -> tuple[int, int]:
    """Read an object's values and marks up to its ``)``; returns a reason (0: none) and the index behind."""
    first = i
    count = 0
    values = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    v0, v1, v2, v3, v4, v5, v6 = values
    marks = 0
    while data[i] == SPACE:
        i = skip_spaces(data, i)
        if data[i] == _LOWER_T or data[i] == _LOWER_K:
            marks |= IS_TACKLING if data[i] == _LOWER_T else IS_KICKING
            i += 1
            continue
        value, after = number(data, i)
        if after < 0 or marks != 0:
            return (WANT_NUMBER if marks == 0 else BAD_WORD), i
        if count == 0:
            v0 = value
        elif count == 1:
            v1 = value
        elif count == 2:
            v2 = value
        elif count == 3:
            v3 = value
        elif count == 4:
            v4 = value
        elif count == 5:
            v5 = value
        elif count == 6:
            v6 = value
        count += 1
        i = after
    if data[i] != RIGHT_PARENTHESIS:
        return WANT_CLOSE, i
    is_player = see["code"][0, k] == PLAYER
    # Direction alone (low quality); distance too; change too; a player's facing too; a raised arm makes it 3 or 7.
    fields = -1
    if count == 1:
        fields = 0
    elif count == 2:
        fields = HAS_DISTANCE
    elif count == 3 and is_player:
        fields = HAS_DISTANCE | HAS_POINTING
    elif count == 4:
        fields = HAS_DISTANCE | HAS_CHANGE
    elif count == 6 and is_player:
        fields = HAS_DISTANCE | HAS_CHANGE | HAS_FACING
    elif count == 7 and is_player:
        fields = HAS_DISTANCE | HAS_CHANGE | HAS_FACING | HAS_POINTING
    if fields < 0:
        return BAD_COUNT, first
    see["fields"][0, k] = fields | marks
    see["distance"][0, k] = 0.0 if count == 1 else v0
    see["direction"][0, k] = v0 if count == 1 else v1
    see["distance_change"][0, k] = v2 if count > 3 else 0.0
    see["direction_change"][0, k] = v3
    see["body"][0, k] = v4
    see["head"][0, k] = v5
    see["pointing"][0, k] = v2 if count == 3 else v6
    return (0, i + 1) if _plausible(see, k) else (BAD_RANGE, first)


@njit
def _plausible(see: NDArray[np.void], k: int) -> bool:
    """Tell whether an object's values are such that players can calculate with them."""
    angles = is_angle(see["direction"][0, k]) and is_angle(see["body"][0, k])
    angles = angles and is_angle(see["head"][0, k]) and is_angle(see["pointing"][0, k])
    changes = is_quantity(see["distance_change"][0, k]) and is_quantity(see["direction_change"][0, k])
    return angles and changes and is_quantity(see["distance"][0, k])


# --- writing ----------------------------------------------------------------------------------------------------------
_NAMES, _NAME_SIZES = text_table(
    dict(enumerate(LANDMARK_NAMES))
    | {LINE + i: name for i, name in enumerate(LINE_NAMES)}
    | {BALL: "b", CLOSE_BALL: "B", CLOSE_PLAYER: "P", CLOSE_FLAG: "F", CLOSE_GOAL: "G"}
)
_START, _GOALIE_MARK = ascii_bytes("(see "), ascii_bytes(" goalie")


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
    return text_table({0: "p", 1: f'p "{own}"', 2: f'p "{other}"'})


@inlined
def _put_name(
    see: NDArray[np.void], k: int, teams: Buffer, team_sizes: NDArray[np.int64], buffer: Buffer, at: int
) -> int:
    buffer[at] = LEFT_PARENTHESIS
    at += 1
    code = see["code"][0, k]
    if code == PLAYER:
        team = see["team"][0, k]
        at = put_bytes(buffer, at, teams[team], team_sizes[team])
        if see["unum"][0, k] > 0:
            at = put_spaced_int(buffer, at, see["unum"][0, k])
            if see["goalie"][0, k]:
                at = put_text(buffer, at, _GOALIE_MARK)
    else:
        at = put_bytes(buffer, at, _NAMES[code], _NAME_SIZES[code])
    buffer[at] = RIGHT_PARENTHESIS
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
        buffer[at] = SPACE
        buffer[at + 1] = _LOWER_T if bits & IS_TACKLING else _LOWER_K
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
    buffer : ndarray of uint8, shape (8192,)

    Returns
    -------
    int
        Length of the message.
    """
    at = put_text(buffer, 0, _START)
    at = put_int(buffer, at, see["time"][0])
    for k in range(see["n"][0]):
        buffer[at] = SPACE
        buffer[at + 1] = LEFT_PARENTHESIS
        at = _put_name(see, k, teams, team_sizes, buffer, at + 2)
        at = _put_fields(see, k, buffer, at)
        buffer[at] = RIGHT_PARENTHESIS
        at += 1
    buffer[at] = RIGHT_PARENTHESIS
    return at + 1
