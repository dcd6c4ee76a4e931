"""The sense_body message: the SENSE_BODY record to bytes (19.0.0, src/serializerplayerstdv8, v12, v13, v14 and v18)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.protocol.digits import (
    Buffer,
    ascii_bytes,
    put_bytes,
    put_int,
    put_number,
    put_spaced,
    put_spaced_int,
    put_text,
    text_table,
)
from rcss_hat.protocol.records import (
    COLLIDED_BALL,
    COLLIDED_PLAYER,
    COLLIDED_POST,
    COUNT_NAMES,
    HIGH,
    LEFT,
    N_COUNTS,
    NARROW,
    NO_SIDE,
    WIDE,
)
from rcss_hat.protocol.scan import LOWER_A, RIGHT_PARENTHESIS

NO_CARD, YELLOW_CARD, RED_CARD = range(3)
_L, _R = LOWER_A + 11, LOWER_A + 17
_COUNTS, _COUNT_SIZES = text_table({i: f") ({name} " for i, name in enumerate(COUNT_NAMES)})
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
_FOUL = ascii_bytes(" (foul (charged 0) (card ")
_YELLOW, _RED = ascii_bytes("yellow"), ascii_bytes("red")
_FOCUS_POINT = ascii_bytes(" (focus_point ")


@inlined
def put_view_mode(buffer: Buffer, at: int, quality: int, width: int) -> int:
    """Write ``QUALITY WIDTH)``."""
    at = put_text(buffer, at, _HIGH) if quality == HIGH else put_text(buffer, at, _LOW)
    if width == NARROW:
        return put_text(buffer, at, _NARROW)
    return put_text(buffer, at, _WIDE) if width == WIDE else put_text(buffer, at, _NORMAL)


@kernel
def put_arm(buffer: Buffer, at: int, movable: int, expires: int, distance: float, direction: int, count: int) -> int:
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
    buffer[at] = RIGHT_PARENTHESIS
    return at + 1


@kernel
def _put_card(buffer: Buffer, at: int, card: int) -> int:
    """Write a player's own card."""
    if card == RED_CARD:
        at = put_text(buffer, at, _RED)
    else:
        at = put_text(buffer, at, _YELLOW) if card == YELLOW_CARD else put_text(buffer, at, _NONE)
    return put_text(buffer, at, _END)


@kernel
def put_focus_point(buffer: Buffer, at: int, distance: float, direction: float) -> int:
    """Write `` (focus_point DISTANCE DIRECTION)``, metres and degrees."""
    at = put_number(buffer, put_text(buffer, at, _FOCUS_POINT), distance)
    at = put_spaced(buffer, at, direction)
    buffer[at] = RIGHT_PARENTHESIS
    return at + 1


@kernel
def write_sense_body(
    sense: NDArray[np.void], version: int, change_focus: int, card: int, focus: tuple[float, float], buffer: Buffer
) -> int:
    """Write the sense_body message for a version of the protocol.

    Collisions are told from version 12 on, stamina capacity from 13, foul from 14, focus point from 18.

    Parameters
    ----------
    sense : ndarray of records.SENSE_BODY, shape (1,)
    version : int
    change_focus : int
        Accepted change_focus commands; this and what follows the record does not hold.
    card : int
        NO_CARD, YELLOW_CARD or RED_CARD.
    focus : tuple of float
        Distance (m) and direction (degrees) of the focus point.
    buffer : ndarray of uint8, shape (8192,)

    Returns
    -------
    int
        Length of the message.
    """
    at = put_int(buffer, put_text(buffer, 0, _SENSE_BODY), sense["time"][0])
    at = put_view_mode(buffer, put_text(buffer, at, _VIEW_MODE), sense["quality"][0], sense["width"][0])
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
        at = put_int(buffer, put_text(buffer, at, _CHANGE_FOCUS), change_focus)
    arm_direction = int(sense["arm_direction"][0])
    at = put_arm(
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
        at = _put_card(buffer, put_text(buffer, at, _FOUL), card)
    if version >= 18:
        at = put_focus_point(buffer, at, focus[0], focus[1])
    buffer[at] = RIGHT_PARENTHESIS
    return at + 1
