"""The whole truth, for players who may know it (19.0.0, src/serializerplayerstdv8, v13, v14 and v18)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import RAD
from rcss_hat.numeric.jit import kernel
from rcss_hat.protocol.digits import Buffer, ascii_bytes, put_int, put_number, put_spaced, put_spaced_int, put_text
from rcss_hat.protocol.messages.answers import Unknown
from rcss_hat.protocol.messages.event import SIDES, Event, reads, record
from rcss_hat.protocol.messages.frame import COUNTERS, arm_target
from rcss_hat.protocol.messages.groups import Group
from rcss_hat.protocol.messages.parts import BallState, counted, marks, pair, read_ball
from rcss_hat.protocol.records import MAX_PLAYERS
from rcss_hat.protocol.scan import LOWER_A, RIGHT_PARENTHESIS, SPACE
from rcss_hat.protocol.sense_body_writer import put_arm, put_focus_point, put_view_mode

__all__ = ["Fullstate", "FullstatePlayer"]


@record
class FullstatePlayer(Event):
    """A player in a fullstate message; what a version does not tell is None.

    Attributes
    ----------
    arm : (float, float) or None
        Distance (m) and direction (**radians**) of where the arm points, relative to the face.
    focus_point : (float, float) or None
        Distance and direction.
    marks : tuple of str
        ``t`` tackling, ``k`` kicking, ``f`` fouled, ``r`` red card, ``y`` yellow card.
    """

    side: str
    unum: int
    goalie: bool
    player_type: int | None
    x: float
    y: float
    vx: float
    vy: float
    body: float
    neck: float
    arm: tuple[float, float] | None
    focus_point: tuple[float, float] | None
    stamina: float
    effort: float
    recovery: float
    capacity: float | None
    marks: tuple[str, ...]


@record
class Fullstate(Event):
    """The whole truth, for players of a side with ``fullstate_l`` or ``fullstate_r``.

    Attributes
    ----------
    counts : tuple of int
        Own kick, dash, turn, catch, move, turn_neck, change_view, say (version 18 and later: change_focus).
    arm : tuple of float
        Own arm: cycles until movable, cycles it stays up, distance, direction (degrees), count.
    score : (int, int)
        Ours, theirs.
    """

    time: int
    mode: str
    quality: str
    width: str
    counts: tuple[int, ...]
    arm: tuple[float, float, float, float, float]
    score: tuple[int, int]
    ball: BallState
    players: tuple[FullstatePlayer, ...]


@reads("fullstate")
def _fullstate(group: Group) -> Event:
    time = group.integer()
    mode = group.group("pmode")
    view = group.group("vmode")
    if not group.has_group("count"):  # version 7
        group.next = len(group.items)
        return Unknown(data=group.data)
    counts = group.group("count").numbers()
    arm = group.group("arm")
    score = group.group("score")
    event = Fullstate(
        time=time,
        mode=mode.word(),
        quality=view.word("high", "low"),
        width=view.word("narrow", "normal", "wide"),
        counts=tuple(int(count) for count in counts),
        arm=_own_arm(arm),
        score=(score.integer(), score.integer()),
        ball=read_ball(group),
        players=tuple(_fullstate_player(group.group()) for _ in range(len(group.items) - group.next)),
    )
    for part in (mode, view, arm, score):
        part.finish()
    return event


def _own_arm(arm: Group) -> tuple[float, float, float, float, float]:
    movable, expires = arm.group("movable").number(), arm.group("expires").number()
    target = arm.group("target")
    distance, direction = target.number(), target.number()
    return movable, expires, distance, direction, arm.group("count").number()


def _fullstate_player(entry: Group) -> FullstatePlayer:
    name = entry.group("p")
    side, unum = name.word(*SIDES), name.integer(1, MAX_PLAYERS)
    goalie = name.peek() == "g"
    if goalie:
        name.word()
    player_type = name.integer(0) if name.more else None
    name.finish()
    x, y, vx, vy, body, neck, *arm = counted(entry, 6, 8)
    focus_point = pair(entry.group("focus_point")) if entry.has_group("focus_point") else None
    stamina = entry.group("stamina")
    energy = counted(stamina, 3, 4)
    return FullstatePlayer(
        side=side,
        unum=unum,
        goalie=goalie,
        player_type=player_type,
        x=x,
        y=y,
        vx=vx,
        vy=vy,
        body=body,
        neck=neck,
        arm=(arm[0], arm[1]) if arm else None,
        focus_point=focus_point,
        stamina=energy[0],
        effort=energy[1],
        recovery=energy[2],
        capacity=energy[3] if len(energy) == 4 else None,
        marks=marks(entry),
    )


# --- writing ----------------------------------------------------------------------------------------------------------
_L, _R, _G, _T, _K, _Y = (LOWER_A + k for k in (11, 17, 6, 19, 10, 24))
_COUNTED = ("kick", "dash", "turn", "catch", "move", "turn_neck", "change_view", "say", "change_focus")
_FULLSTATE = ascii_bytes("(fullstate ")
_PMODE = ascii_bytes(" (pmode ")
_VMODE = ascii_bytes(") (vmode ")
_FULL_COUNT = ascii_bytes(" (count ")
_SCORE = ascii_bytes(")) (score ")
_BALL = ascii_bytes(") ((b)")
_PLAYER = ascii_bytes(" ((p ")
_STAMINA = ascii_bytes(" (stamina ")
_POINTTO = COUNTERS.index("pointto")
_FULL_ORDER = np.array([k for k, name in enumerate(COUNTERS) if name in _COUNTED], dtype=np.int64)


@kernel
def _put_player(frame: NDArray[np.void], i: int, version: int, yellow: bool, buffer: Buffer, at: int) -> int:
    at = put_text(buffer, at, _PLAYER)
    buffer[at] = _L if i < MAX_PLAYERS else _R
    at = put_spaced_int(buffer, at + 1, i % MAX_PLAYERS + 1)
    if frame["goalie"][0, i]:
        buffer[at] = SPACE
        buffer[at + 1] = _G
        at += 2
    if version >= 14 or not frame["goalie"][0, i]:
        at = put_spaced_int(buffer, at, frame["type"][0, i])
    buffer[at] = RIGHT_PARENTHESIS
    at += 1
    at = put_spaced(buffer, at, frame["pos"][0, i, 0])
    at = put_spaced(buffer, at, frame["pos"][0, i, 1])
    at = put_spaced(buffer, at, frame["vel"][0, i, 0])
    at = put_spaced(buffer, at, frame["vel"][0, i, 1])
    at = put_spaced(buffer, at, frame["body"][0, i] * RAD)
    at = put_spaced(buffer, at, frame["neck"][0, i] * RAD)
    if frame["arm_expires"][0, i] > 0:
        distance, direction = arm_target(frame, i)
        at = put_spaced(buffer, at, distance)
        at = put_spaced(buffer, at, direction)
    if version >= 18:
        at = put_focus_point(buffer, at, frame["focus_dist"][0, i], frame["focus_dir"][0, i] * RAD)
    at = put_number(buffer, put_text(buffer, at, _STAMINA), frame["stamina"][0, i])
    at = put_spaced(buffer, at, frame["effort"][0, i])
    at = put_spaced(buffer, at, frame["recovery"][0, i])
    if version >= 13:
        at = put_spaced(buffer, at, frame["capacity"][0, i])
    buffer[at] = RIGHT_PARENTHESIS
    at += 1
    if version >= 13 and (frame["tackle_cycles"][0, i] > 0 or frame["kick_cycles"][0, i] > 0):
        buffer[at] = SPACE
        buffer[at + 1] = _T if frame["tackle_cycles"][0, i] > 0 else _K
        at += 2
    if version >= 14 and yellow:
        buffer[at] = SPACE
        buffer[at + 1] = _Y
        at += 2
    buffer[at] = RIGHT_PARENTHESIS
    return at + 1


@kernel
def write_fullstate(frame: NDArray[np.void], i: int, yellow: NDArray[np.bool_], mode: Buffer, buffer: Buffer) -> int:
    """Write the fullstate message of player ``i``.

    Parameters
    ----------
    frame : ndarray of a record of the match, shape (1,)
        See `frame`.
    i : int
        Index of the player who receives it.
    yellow : ndarray of bool, shape (22,)
        Who has been shown a yellow card.
    mode : ndarray of uint8
        Name of the play mode.
    buffer : ndarray of uint8, shape (8192,)

    Returns
    -------
    int
        Length of the message.
    """
    version = frame["version"][0, i]
    at = put_int(buffer, put_text(buffer, 0, _FULLSTATE), frame["time"][0])
    at = put_text(buffer, put_text(buffer, at, _PMODE), mode)
    at = put_view_mode(buffer, put_text(buffer, at, _VMODE), frame["quality"][0, i], frame["width"][0, i])
    at = put_text(buffer, at, _FULL_COUNT)
    for k in range(9 if version >= 18 else 8):
        if k > 0:
            buffer[at] = SPACE
            at += 1
        at = put_int(buffer, at, frame["counts"][0, i, _FULL_ORDER[k]])
    distance, direction = arm_target(frame, i)
    at = put_arm(
        buffer, at, frame["arm_movable"][0, i], frame["arm_expires"][0, i], distance, int(round(direction * RAD)),
        frame["counts"][0, i, _POINTTO],
    )  # fmt: skip
    own = 0 if i < MAX_PLAYERS else 1
    at = put_int(buffer, put_text(buffer, at, _SCORE), frame["score"][0, own])
    at = put_spaced_int(buffer, at, frame["score"][0, 1 - own])
    at = put_text(buffer, at, _BALL)
    at = put_spaced(buffer, at, frame["ball_pos"][0, 0])
    at = put_spaced(buffer, at, frame["ball_pos"][0, 1])
    at = put_spaced(buffer, at, frame["ball_vel"][0, 0])
    at = put_spaced(buffer, at, frame["ball_vel"][0, 1])
    buffer[at] = RIGHT_PARENTHESIS
    at += 1
    for j in range(2 * MAX_PLAYERS):
        if frame["enabled"][0, j]:
            at = _put_player(frame, j, version, yellow[j], buffer, at)
    buffer[at] = RIGHT_PARENTHESIS
    return at + 1
