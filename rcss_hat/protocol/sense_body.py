"""The sense_body message: bytes to the SENSE_BODY record (19.0.0, src/bodysender, src/serializerplayerstdv1 to v18)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import njit
from rcss_hat.protocol import scan
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.protocol.records import (
    COLLIDED_BALL,
    COLLIDED_PLAYER,
    COLLIDED_POST,
    COUNT_NAMES,
    HIGH,
    LEFT,
    LOW,
    MAX_PLAYERS,
    N_COUNTS,
    NARROW,
    NO_SIDE,
    NORMAL,
    RIGHT,
    WIDE,
)
from rcss_hat.protocol.scan import (
    BAD_COUNT,
    BAD_RANGE,
    BAD_UNUM,
    BAD_WORD,
    LEFT_PARENTHESIS,
    MISSING,
    NUL,
    RIGHT_PARENTHESIS,
    SPACE,
    WANT_CLOSE,
    WANT_NAME,
    WANT_NUMBER,
    WANT_OPEN,
    WANT_SPACE,
    failure,
    integer,
    is_angle,
    is_quantity,
    key_of,
    number,
    skip_group,
    skip_spaces,
    word,
)

_SENSE_BODY = key_of("sense_body")
_VIEW_MODE, _STAMINA, _SPEED, _HEAD_ANGLE = (key_of(name) for name in ("view_mode", "stamina", "speed", "head_angle"))
_ARM, _FOCUS, _TACKLE, _COLLISION = (key_of(name) for name in ("arm", "focus", "tackle", "collision"))
_MOVABLE, _EXPIRES, _TARGET, _COUNT = (key_of(name) for name in ("movable", "expires", "target", "count"))
_LOW, _HIGH, _NARROW, _NORMAL, _WIDE = (key_of(name) for name in ("low", "high", "narrow", "normal", "wide"))
_NONE, _L, _R, _BALL, _PLAYER, _POST = (key_of(name) for name in ("none", "l", "r", "ball", "player", "post"))
_COUNT_KEYS = np.array([key_of(name) for name in COUNT_NAMES], dtype=np.int64)
_HAS_VIEW_MODE, _HAS_STAMINA, _HAS_SPEED = 1, 2, 4


def parse_sense_body(data: bytes, sense: NDArray[np.void]) -> None:
    """Read a sense_body message into a record.

    All forms of protocol versions 7 to 19. Parts that a version lacks are 0 (``capacity``: -1); parts that the record
    has no room for (``foul``, ``focus_point``, ``change_focus`` and whatever may come) are passed over.

    Parameters
    ----------
    data : bytes
        The message, with or without its NUL.
    sense : ndarray of SENSE_BODY, shape (1,)
        Overwritten. After an error all its fields are 0.

    Raises
    ------
    RemoteProtocolError
        When the message is malformed or lacks view_mode, stamina or speed; names the position.
    """
    result = _parse(scan.to_array(data), sense)
    if result:
        sense[:] = np.zeros((), sense.dtype)
        raise RemoteProtocolError(f"bad sense_body message: {scan.REASONS[result % 16]}", data, result // 16)


@njit
def _parse(data: NDArray[np.uint8], sense: NDArray[np.void]) -> int:
    """Read ``(sense_body TIME (NAME ...) ...)``; 0, or a failure."""
    if data[0] != LEFT_PARENTHESIS:
        return failure(WANT_OPEN, 0)
    key, i = word(data, 1)
    if key != _SENSE_BODY:
        return failure(WANT_NAME, 1)
    if data[i] != SPACE:
        return failure(WANT_SPACE, i)
    i = skip_spaces(data, i)
    time, after = integer(data, i)
    if after < 0:
        return failure(WANT_NUMBER, i)
    _clear(sense)
    sense["time"][0] = time
    i = skip_spaces(data, after)
    present = 0
    while data[i] == LEFT_PARENTHESIS:
        key, i = word(data, i + 1)
        error, i, part = _group(data, i, key, sense)
        if error != 0:
            return failure(error, i)
        present |= part
        i = skip_spaces(data, i)
    if data[i] != RIGHT_PARENTHESIS:
        return failure(WANT_CLOSE, i)
    i = skip_spaces(data, i + 1)
    if data[i] != NUL:
        return failure(BAD_WORD, i)
    if present != _HAS_VIEW_MODE | _HAS_STAMINA | _HAS_SPEED:
        return failure(MISSING, i)
    return 0 if _plausible(sense) else failure(BAD_RANGE, i)


@njit
def _plausible(sense: NDArray[np.void]) -> bool:
    """Tell whether the values are such that players can calculate with them."""
    angles = is_angle(sense["speed_direction"][0]) and is_angle(sense["head_angle"][0])
    angles = angles and is_angle(sense["arm_direction"][0])
    body = is_quantity(sense["stamina"][0]) and is_quantity(sense["effort"][0]) and is_quantity(sense["capacity"][0])
    return angles and body and is_quantity(sense["speed"][0]) and is_quantity(sense["arm_distance"][0])


@njit
def _clear(sense: NDArray[np.void]) -> None:
    """Set what not every version sends to its default."""
    sense["capacity"][0] = -1.0
    sense["speed_direction"][0] = 0.0
    sense["head_angle"][0] = 0.0
    for k in range(N_COUNTS):
        sense["counts"][0, k] = 0
    sense["arm_movable"][0] = 0
    sense["arm_expires"][0] = 0
    sense["arm_distance"][0] = 0.0
    sense["arm_direction"][0] = 0.0
    sense["arm_count"][0] = 0
    sense["focus_side"][0] = NO_SIDE
    sense["focus_unum"][0] = 0
    sense["focus_count"][0] = 0
    sense["tackle_expires"][0] = 0
    sense["tackle_count"][0] = 0
    sense["has_collision"][0] = 0
    sense["collision"][0] = 0


@njit
def _group(data: NDArray[np.uint8], i: int, key: int, sense: NDArray[np.void]) -> tuple[int, int, int]:
    """Read the group whose name ends at i; returns a reason (0: none), the index behind, and its _HAS_* bit."""
    for k in range(N_COUNTS):
        if key == _COUNT_KEYS[k]:
            count, i, error = _one_integer(data, i)
            if error == 0:
                sense["counts"][0, k] = count
            return error, i, 0
    if key == _VIEW_MODE:
        error, i = _view_mode(data, i, sense)
        return error, i, _HAS_VIEW_MODE
    if key == _STAMINA:
        error, i = _stamina(data, i, sense)
        return error, i, _HAS_STAMINA
    if key in (_SPEED, _HEAD_ANGLE):
        error, i, n, first, second, _ = _numbers(data, i)
        if error != 0:
            return error, i, 0
        if key == _HEAD_ANGLE:
            sense["head_angle"][0] = first
            return (0 if n == 1 else BAD_COUNT), i, 0
        sense["speed"][0] = first
        sense["speed_direction"][0] = second
        return (0 if n < 3 else BAD_COUNT), i, _HAS_SPEED
    if key in (_ARM, _FOCUS, _TACKLE):
        error, i = _nested(data, i, key, sense)
        return error, i, 0
    if key == _COLLISION:
        error, i = _collision(data, i, sense)
        return error, i, 0
    if key == 0:
        return WANT_NAME, i, 0
    after = skip_group(data, i)
    if after < 0:
        return WANT_CLOSE, i, 0
    return 0, after, 0


@njit
def _one_integer(data: NDArray[np.uint8], i: int) -> tuple[int, int, int]:
    """Read `` N)``; returns the number, the index behind and a reason (0: none)."""
    i = skip_spaces(data, i)
    value, after = integer(data, i)
    if after < 0:
        return 0, i, WANT_NUMBER
    i = skip_spaces(data, after)
    if data[i] != RIGHT_PARENTHESIS:
        return 0, i, WANT_CLOSE
    return value, i + 1, 0


@njit
def _numbers(data: NDArray[np.uint8], i: int) -> tuple[int, int, int, float, float, float]:
    """Read one to three numbers and ``)``; returns a reason (0: none), the index behind, how many, and the numbers."""
    first, second, third = 0.0, 0.0, 0.0
    n = 0
    i = skip_spaces(data, i)
    while n == 0 or data[i] != RIGHT_PARENTHESIS:
        if n == 3:
            return WANT_CLOSE, i, n, first, second, third
        value, after = number(data, i)
        if after < 0:
            return WANT_NUMBER, i, n, first, second, third
        if n == 0:
            first = value
        elif n == 1:
            second = value
        else:
            third = value
        n += 1
        i = skip_spaces(data, after)
        if i == after and data[i] != RIGHT_PARENTHESIS:
            return WANT_CLOSE, i, n, first, second, third
    return 0, i + 1, n, first, second, third


@njit
def _view_mode(data: NDArray[np.uint8], i: int, sense: NDArray[np.void]) -> tuple[int, int]:
    """Read `` QUALITY WIDTH)``."""
    i = skip_spaces(data, i)
    key, after = word(data, i)
    if key != _LOW and key != _HIGH:
        return BAD_WORD, i
    sense["quality"][0] = HIGH if key == _HIGH else LOW
    i = skip_spaces(data, after)
    key, after = word(data, i)
    if key == _NARROW:
        sense["width"][0] = NARROW
    elif key == _NORMAL:
        sense["width"][0] = NORMAL
    elif key == _WIDE:
        sense["width"][0] = WIDE
    else:
        return BAD_WORD, i
    i = skip_spaces(data, after)
    if data[i] != RIGHT_PARENTHESIS:
        return WANT_CLOSE, i
    return 0, i + 1


@njit
def _stamina(data: NDArray[np.uint8], i: int, sense: NDArray[np.void]) -> tuple[int, int]:
    """Read `` STAMINA EFFORT)`` or, from version 13 on, `` STAMINA EFFORT CAPACITY)``."""
    error, i, n, stamina, effort, capacity = _numbers(data, i)
    if error == 0 and n < 2:
        error = BAD_COUNT
    if error == 0:
        sense["stamina"][0] = stamina
        sense["effort"][0] = effort
        if n == 3:
            sense["capacity"][0] = capacity
    return error, i


@njit
def _nested(data: NDArray[np.uint8], i: int, outer: int, sense: NDArray[np.void]) -> tuple[int, int]:
    """Read the groups inside arm, focus or tackle, up to the closing ``)``."""
    i = skip_spaces(data, i)
    while data[i] == LEFT_PARENTHESIS:
        key, i = word(data, i + 1)
        if key == _TARGET:
            error, i = _arm_target(data, i, sense) if outer == _ARM else _focus_target(data, i, sense)
        elif key in (_COUNT, _EXPIRES, _MOVABLE):
            value, i, error = _one_integer(data, i)
            if error == 0:
                _count(key, value, outer, sense)
        else:
            after = skip_group(data, i)
            error, i = (WANT_CLOSE, i) if after < 0 else (0, after)
        if error != 0:
            return error, i
        i = skip_spaces(data, i)
    if data[i] != RIGHT_PARENTHESIS:
        return WANT_CLOSE, i
    return 0, i + 1


@njit
def _count(key: int, value: int, outer: int, sense: NDArray[np.void]) -> None:
    """Store a number of arm, focus or tackle."""
    if key == _COUNT:
        if outer == _ARM:
            sense["arm_count"][0] = value
        elif outer == _FOCUS:
            sense["focus_count"][0] = value
        else:
            sense["tackle_count"][0] = value
    elif key == _EXPIRES:
        if outer == _ARM:
            sense["arm_expires"][0] = value
        elif outer == _TACKLE:
            sense["tackle_expires"][0] = value
    elif key == _MOVABLE and outer == _ARM:
        sense["arm_movable"][0] = value


@njit
def _arm_target(data: NDArray[np.uint8], i: int, sense: NDArray[np.void]) -> tuple[int, int]:
    """Read `` DISTANCE DIRECTION)``."""
    error, i, n, distance, direction, _ = _numbers(data, i)
    if error == 0 and n != 2:
        error = BAD_COUNT
    if error == 0:
        sense["arm_distance"][0] = distance
        sense["arm_direction"][0] = direction
    return error, i


@njit
def _focus_target(data: NDArray[np.uint8], i: int, sense: NDArray[np.void]) -> tuple[int, int]:
    """Read `` none)`` or `` SIDE UNUM)``."""
    i = skip_spaces(data, i)
    key, after = word(data, i)
    if key == _NONE:
        i = skip_spaces(data, after)
        if data[i] != RIGHT_PARENTHESIS:
            return WANT_CLOSE, i
        return 0, i + 1
    if key != _L and key != _R:
        return BAD_WORD, i
    unum, i, error = _one_integer(data, after)
    if error == 0 and not 1 <= unum <= MAX_PLAYERS:
        error = BAD_UNUM
    if error == 0:
        sense["focus_side"][0] = LEFT if key == _L else RIGHT
        sense["focus_unum"][0] = unum
    return error, i


@njit
def _collision(data: NDArray[np.uint8], i: int, sense: NDArray[np.void]) -> tuple[int, int]:
    """Read `` none)`` or any of `` (ball) (player) (post))``."""
    sense["has_collision"][0] = 1
    i = skip_spaces(data, i)
    key, after = word(data, i)
    if key == _NONE:
        i = skip_spaces(data, after)
    collided = 0
    while data[i] == LEFT_PARENTHESIS:
        key, after = word(data, i + 1)
        if key == _BALL:
            collided |= COLLIDED_BALL
        elif key == _PLAYER:
            collided |= COLLIDED_PLAYER
        elif key == _POST:
            collided |= COLLIDED_POST
        else:
            return BAD_WORD, i + 1
        if data[after] != RIGHT_PARENTHESIS:
            return WANT_CLOSE, after
        i = skip_spaces(data, after + 1)
    sense["collision"][0] = collided
    if data[i] != RIGHT_PARENTHESIS:
        return WANT_CLOSE, i
    return 0, i + 1
