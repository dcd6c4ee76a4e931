"""Monitors' frames of versions 3 to 5, and those of game logs (19.0.0, src/serializermonitor.cpp, src/dispsender.cpp).

22 players, several kilobytes, in every cycle: so they are read with regular expressions, entry by entry, and written
by a kernel.
"""

from __future__ import annotations

import math
import re
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import RAD
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.numeric.wire import quantize
from rcss_hat.protocol.digits import (
    Buffer,
    ascii_bytes,
    put_hex,
    put_int,
    put_number,
    put_spaced,
    put_spaced_int,
    put_text,
)
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.protocol.messages.answers import Team
from rcss_hat.protocol.messages.event import BY_BYTES, Event, record
from rcss_hat.protocol.messages.frame import COUNTERS
from rcss_hat.protocol.messages.parts import BallState
from rcss_hat.protocol.play_modes import PLAY_MODES
from rcss_hat.protocol.records import HIGH, LEFT, MAX_PLAYERS, NO_SIDE
from rcss_hat.protocol.scan import LOWER_A, RIGHT_PARENTHESIS, SPACE

__all__ = ["Show", "ShowPlayer"]


@record
class ShowPlayer(Event):
    """A player in a monitor's frame.

    Attributes
    ----------
    state : int
        State flags; 0: not connected.
    arm : (float, float) or None
        The point on the field it points to.
    quality : str
        ``h`` or ``l``.
    view_angle : float
    focus_point : (float, float) or None
        Frames of version 5.
    capacity : float or None
        Frames of version 4 and 5.
    attention : (str, int) or None
        Side and number of the player it listens to.
    counts : tuple of int
        kick, dash, turn, catch, move, turn_neck, change_view, say, tackle, pointto, attentionto (version 5:
        change_focus).
    """

    side: str
    unum: int
    player_type: int
    state: int
    x: float
    y: float
    vx: float
    vy: float
    body: float
    neck: float
    arm: tuple[float, float] | None
    quality: str
    view_angle: float
    focus_point: tuple[float, float] | None
    stamina: float
    effort: float
    recovery: float
    capacity: float | None
    attention: tuple[str, int] | None
    counts: tuple[int, ...]


@record
class Show(Event):
    """A monitor's frame of version 3 to 5, or that of a game log (mode and team are None there)."""

    time: int
    mode: str | None
    team: Team | None
    ball: BallState
    players: tuple[ShowPlayer, ...]


_NUMBERS = rb"([-+.e0-9 ]+)"
_HEAD = re.compile(
    rb"\(show ([0-9]{1,9})(?: \(pm ([0-9]{1,2})\))?"
    rb"(?: \(tm ([^ ()\0]+) ([^ ()\0]+) ([0-9]{1,6}) ([0-9]{1,6})((?: [0-9]{1,6}){4})?\))? \(\(b\) %b\)" % _NUMBERS
)
_PLAYER = re.compile(
    rb" \(\(([lr]) ([0-9]{1,2})\) ([0-9]{1,9}) (0x[0-9a-f]{1,8}|0) %b \(v ([hl]) %b\)"
    rb"(?: \(fp %b\))? \(s %b\)(?: \(f ([lr]) ([0-9]{1,2})\))? \(c ([0-9]{1,9}(?: [0-9]{1,9})*)\)\)"
    % (_NUMBERS, _NUMBERS, _NUMBERS, _NUMBERS)
)
_END = re.compile(rb"\)[ \t\r\n]*(?:\0|$)")


def parse_show(data: bytes) -> Show:
    """Read a frame of version 3, 4 or 5, from a monitor's datagram or a game log.

    Raises
    ------
    RemoteProtocolError
        When it is malformed; names the entry that is.
    """
    head = _HEAD.match(data)
    if head is None:
        _fail("expected (show TIME ... ((b) X Y VX VY)", data, 0)
    time, mode, left, right, left_score, right_score, penalties, ball = head.groups()
    if mode is not None and int(mode) not in PLAY_MODES:
        _fail("unknown play mode", data, head.start(2))
    team = None
    if left is not None:
        team = Team(
            left=left.decode("latin-1"),
            right=right.decode("latin-1"),
            left_score=int(left_score),
            right_score=int(right_score),
            penalties=tuple(map(int, (penalties or b"").split())),
        )
    x, y, vx, vy = _floats(ball, data, head.start(8), 4)
    players, position = _players(data, head.end())
    if not _END.match(data, position):
        _fail("expected an entry of a player, or ')'", data, position)
    return Show(
        time=int(time),
        mode=None if mode is None else PLAY_MODES[int(mode)],
        team=team,
        ball=BallState(x=x, y=y, vx=vx, vy=vy),
        players=players,
    )


def _players(data: bytes, position: int) -> tuple[tuple[ShowPlayer, ...], int]:
    players = []
    while entry := _PLAYER.match(data, position):
        players.append(_player(entry, data))
        position = entry.end()
    return tuple(players), position


def _player(entry: re.Match[bytes], data: bytes) -> ShowPlayer:
    side, unum, player_type, state, place, quality, angle, focus, energy, other_side, other, counts = entry.groups()
    start = entry.start()
    if not 1 <= int(unum) <= MAX_PLAYERS or (other is not None and not 1 <= int(other) <= MAX_PLAYERS):
        _fail(f"expected uniform numbers from 1 to {MAX_PLAYERS}", data, start)
    x, y, vx, vy, body, neck, *arm = _floats(place, data, start, 6, 8)
    stamina, effort, recovery, *capacity = _floats(energy, data, start, 3, 4)
    numbers = tuple(map(int, counts.split()))
    if len(numbers) not in (11, 12):
        _fail("expected 11 or 12 counts", data, start)
    focus_point = None
    if focus is not None:
        distance, direction = _floats(focus, data, start, 2)
        focus_point = (distance, direction)
    return ShowPlayer(
        side=side.decode(),
        unum=int(unum),
        player_type=int(player_type),
        state=int(state, 16),
        x=x,
        y=y,
        vx=vx,
        vy=vy,
        body=body,
        neck=neck,
        arm=(arm[0], arm[1]) if arm else None,
        quality=quality.decode(),
        view_angle=_floats(angle, data, start, 1)[0],
        focus_point=focus_point,
        stamina=stamina,
        effort=effort,
        recovery=recovery,
        capacity=capacity[0] if capacity else None,
        attention=None if other is None else (other_side.decode(), int(other)),
        counts=numbers,
    )


def _floats(text: bytes, data: bytes, position: int, *allowed: int) -> list[float]:
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        _fail("expected numbers", data, position)
    if len(values) not in allowed or not all(map(math.isfinite, values)):
        _fail(f"expected {' or '.join(map(str, allowed))} finite numbers", data, position)
    return values


def _fail(reason: str, data: bytes, position: int) -> NoReturn:
    raise RemoteProtocolError(f"bad show message: {reason}", data, position)


BY_BYTES[b"show"] = lambda data, team: parse_show(data)


# --- writing ----------------------------------------------------------------------------------------------------------
MAX_SHOW = 65536
"""Room for a frame; the longest that a match can print is far shorter."""
LENGTH, ANGLE = 0.0001, 0.001
"""To which lengths (m, m/cycle) and angles (degrees) are rounded."""
_L, _R = LOWER_A + 11, LOWER_A + 17
_SHOW = ascii_bytes("(show ")
_BALL = ascii_bytes(" ((b)")
_PLAYER_START = ascii_bytes(" ((")
_HIGH_VIEW, _LOW_VIEW = ascii_bytes(" (v h"), ascii_bytes(" (v l")
_FOCUS_POINT = ascii_bytes(") (fp")
_STAMINA = ascii_bytes(") (s ")
_FOCUS = ascii_bytes(") (f ")
_COUNTS = ascii_bytes(") (c")


@inlined
def _put_pair(buffer: Buffer, at: int, pair: NDArray[np.float64]) -> int:
    at = put_spaced(buffer, at, quantize(pair[0], LENGTH))
    return put_spaced(buffer, at, quantize(pair[1], LENGTH))


@kernel
def _put_player(
    frame: NDArray[np.void], i: int, flags: int, view_angle: float, version: int, buffer: Buffer, at: int
) -> int:
    at = put_text(buffer, at, _PLAYER_START)
    buffer[at] = _L if i < MAX_PLAYERS else _R
    at = put_spaced_int(buffer, at + 1, i % MAX_PLAYERS + 1)
    buffer[at] = RIGHT_PARENTHESIS
    at = put_spaced_int(buffer, at + 1, frame["type"][0, i])
    buffer[at] = SPACE
    at = put_hex(buffer, at + 1, flags)
    at = _put_pair(buffer, at, frame["pos"][0, i])
    at = _put_pair(buffer, at, frame["vel"][0, i])
    at = put_spaced(buffer, at, quantize(frame["body"][0, i] * RAD, ANGLE))
    at = put_spaced(buffer, at, quantize(frame["neck"][0, i] * RAD, ANGLE))
    if frame["arm_expires"][0, i] > 0:
        at = _put_pair(buffer, at, frame["arm_pos"][0, i])
    at = put_text(buffer, at, _HIGH_VIEW) if frame["quality"][0, i] == HIGH else put_text(buffer, at, _LOW_VIEW)
    at = put_spaced(buffer, at, quantize(view_angle, ANGLE))
    if version >= 5:
        at = put_spaced(buffer, put_text(buffer, at, _FOCUS_POINT), quantize(frame["focus_dist"][0, i], LENGTH))
        at = put_spaced(buffer, at, quantize(frame["focus_dir"][0, i] * RAD, LENGTH))
    at = put_number(buffer, put_text(buffer, at, _STAMINA), frame["stamina"][0, i])
    at = put_spaced(buffer, at, frame["effort"][0, i])
    at = put_spaced(buffer, at, frame["recovery"][0, i])
    if version >= 4:
        at = put_spaced(buffer, at, frame["capacity"][0, i])
    if frame["enabled"][0, i] and frame["focus_side"][0, i] != NO_SIDE:
        at = put_text(buffer, at, _FOCUS)
        buffer[at] = _L if frame["focus_side"][0, i] == LEFT else _R
        at = put_spaced_int(buffer, at + 1, frame["focus_unum"][0, i])
    at = put_text(buffer, at, _COUNTS)
    for k in range(len(COUNTERS) if version >= 5 else len(COUNTERS) - 1):
        at = put_spaced_int(buffer, at, frame["counts"][0, i, k])
    buffer[at] = RIGHT_PARENTHESIS
    buffer[at + 1] = RIGHT_PARENTHESIS
    return at + 2


@kernel
def write_show(
    frame: NDArray[np.void],
    flags: NDArray[np.int64],
    view_angles: NDArray[np.float64],
    version: int,
    head: Buffer,
    buffer: Buffer,
) -> int:
    """Write a frame.

    Parameters
    ----------
    frame : ndarray of a record of the frame, shape (1,)
        See `frame`.
    flags : ndarray of int64, shape (22,)
        Every player's state.
    view_angles : ndarray of float64, shape (22,)
        Degrees.
    version : int
        Of the monitor protocol, 3 to 5; a game log of version V has the players of monitor version V - 1.
    head : ndarray of uint8
        What stands between time and ball: play mode and teams for monitors, one space for logs.
    buffer : ndarray of uint8, shape (MAX_SHOW,)

    Returns
    -------
    int
        Length of the frame.
    """
    at = put_int(buffer, put_text(buffer, 0, _SHOW), frame["time"][0])
    if head.size > 1:
        at = put_text(buffer, at, head)
    at = put_text(buffer, at, _BALL)
    at = _put_pair(buffer, at, frame["ball_pos"][0])
    at = _put_pair(buffer, at, frame["ball_vel"][0])
    buffer[at] = RIGHT_PARENTHESIS
    at += 1
    for i in range(2 * MAX_PLAYERS):
        at = _put_player(frame, i, flags[i], view_angles[i], version, buffer, at)
    buffer[at] = RIGHT_PARENTHESIS
    return at + 1
