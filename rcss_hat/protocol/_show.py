"""Monitors' frames: 22 players, several kilobytes, in every cycle; so read with regular expressions, entry by entry."""

from __future__ import annotations

import math
import re
from typing import NoReturn

from rcss_hat.protocol._events import BallState, Show, ShowPlayer, Team
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.protocol.play_modes import PLAY_MODES
from rcss_hat.protocol.records import MAX_PLAYERS

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
