"""What monitors and game logs get: the whole match as text (versions 3 to 5) or JSON (version -1).

Source: 19.0.0, src/serializermonitor.cpp and src/dispsender.cpp. No text here ends in NUL: the connection adds it.
"""

from __future__ import annotations

import json

import numpy as np
from numpy.typing import NDArray

from fake_server.digits import (
    Buffer,
    ascii_bytes,
    put_hex,
    put_int,
    put_number,
    put_spaced,
    put_spaced_int,
    put_text,
)
from fake_server.simulation.clock import view_angle
from fake_server.simulation.state import (
    F_GOALIE,
    F_RED_CARD,
    F_STAND,
    F_YELLOW_CARD,
    N_COUNTERS,
    N_PLAYERS,
)
from rcss_hat.numeric.angles import RAD
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.numeric.wire import quantize
from rcss_hat.protocol.records import HIGH, LEFT, MAX_PLAYERS, NO_SIDE

MAX_SHOW = 65536
"""Room for a frame; the longest that a match can print is far shorter."""
MESSAGE_BOARD, LOG_BOARD = 1, 2

_LENGTH, _ANGLE = 0.0001, 0.001
_OPEN, _CLOSE, _SPACE, _L, _R = 40, 41, 32, 108, 114
_SHOW = ascii_bytes("(show ")
_BALL = ascii_bytes(" ((b)")
_PLAYER = ascii_bytes(" ((")
_HIGH_VIEW, _LOW_VIEW = ascii_bytes(" (v h"), ascii_bytes(" (v l")
_FOCUS_POINT = ascii_bytes(") (fp")
_STAMINA = ascii_bytes(") (s ")
_FOCUS = ascii_bytes(") (f ")
_COUNTS = ascii_bytes(") (c")


@inlined
def state_flags(match: NDArray[np.void], i: int) -> int:
    """Return a player's state word of the monitor protocol; off the field only cards are left of it."""
    flags = match["flags"][0, i]
    if not match["enabled"][0, i]:
        return flags & (F_YELLOW_CARD | F_RED_CARD)
    return flags | F_STAND | (F_GOALIE if match["goalie"][0, i] else 0)


@inlined
def _put_pair(buffer: Buffer, at: int, pair: NDArray[np.float64]) -> int:
    at = put_spaced(buffer, at, quantize(pair[0], _LENGTH))
    return put_spaced(buffer, at, quantize(pair[1], _LENGTH))


@kernel
def _put_player(
    match: NDArray[np.void], params: NDArray[np.void], i: int, version: int, buffer: Buffer, at: int
) -> int:
    at = put_text(buffer, at, _PLAYER)
    buffer[at] = _L if i < MAX_PLAYERS else _R
    at = put_spaced_int(buffer, at + 1, i % MAX_PLAYERS + 1)
    buffer[at] = _CLOSE
    at = put_spaced_int(buffer, at + 1, match["type"][0, i])
    buffer[at] = _SPACE
    at = put_hex(buffer, at + 1, state_flags(match, i))
    at = _put_pair(buffer, at, match["pos"][0, i])
    at = _put_pair(buffer, at, match["vel"][0, i])
    at = put_spaced(buffer, at, quantize(match["body"][0, i] * RAD, _ANGLE))
    at = put_spaced(buffer, at, quantize(match["neck"][0, i] * RAD, _ANGLE))
    if match["arm_expires"][0, i] > 0:
        at = _put_pair(buffer, at, match["arm_pos"][0, i])
    at = put_text(buffer, at, _HIGH_VIEW) if match["quality"][0, i] == HIGH else put_text(buffer, at, _LOW_VIEW)
    at = put_spaced(buffer, at, quantize(view_angle(match, params, i), _ANGLE))
    if version >= 5:
        at = put_spaced(buffer, put_text(buffer, at, _FOCUS_POINT), quantize(match["focus_dist"][0, i], _LENGTH))
        at = put_spaced(buffer, at, quantize(match["focus_dir"][0, i] * RAD, _LENGTH))
    at = put_number(buffer, put_text(buffer, at, _STAMINA), match["stamina"][0, i])
    at = put_spaced(buffer, at, match["effort"][0, i])
    at = put_spaced(buffer, at, match["recovery"][0, i])
    if version >= 4:
        at = put_spaced(buffer, at, match["capacity"][0, i])
    if match["enabled"][0, i] and match["focus_side"][0, i] != NO_SIDE:
        at = put_text(buffer, at, _FOCUS)
        buffer[at] = _L if match["focus_side"][0, i] == LEFT else _R
        at = put_spaced_int(buffer, at + 1, match["focus_unum"][0, i])
    at = put_text(buffer, at, _COUNTS)
    for k in range(N_COUNTERS if version >= 5 else N_COUNTERS - 1):
        at = put_spaced_int(buffer, at, match["counts"][0, i, k])
    buffer[at] = _CLOSE
    buffer[at + 1] = _CLOSE
    return at + 2


@kernel
def write_show(match: NDArray[np.void], params: NDArray[np.void], version: int, head: Buffer, buffer: Buffer) -> int:
    """Write a frame.

    Parameters
    ----------
    match : ndarray of MATCH, shape (1,)
    params : ndarray of PARAMS, shape (1,)
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
    at = put_int(buffer, put_text(buffer, 0, _SHOW), match["time"][0])
    if head.size > 1:
        at = put_text(buffer, at, head)
    at = put_text(buffer, at, _BALL)
    at = _put_pair(buffer, at, match["ball_pos"][0])
    at = _put_pair(buffer, at, match["ball_vel"][0])
    buffer[at] = _CLOSE
    at += 1
    for i in range(N_PLAYERS):
        at = _put_player(match, params, i, version, buffer, at)
    buffer[at] = _CLOSE
    return at + 1


def monitor_head(mode: int, teams: tuple[str, str], score: tuple[int, int]) -> str:
    """Return play mode and teams as in frames for monitors."""
    return f" (pm {mode}) (tm {teams[0] or 'null'} {teams[1] or 'null'} {score[0]} {score[1]})"


def message(time: int, board: int, text: str) -> str:
    """Return a ``(msg ...)`` for text monitors and logs."""
    return f'(msg {time} {board} "{text}")'


# --- JSON --------------------
def _plain(value: float) -> float | int:
    """Return the number that ``%g`` prints, whole ones as integers."""
    number = float(f"{value:g}")
    return int(number) if number.is_integer() else number


def _rounded(value: float, step: float = _LENGTH) -> float | int:
    return _plain(quantize(float(value), step))


def _json_player(match: NDArray[np.void], params: NDArray[np.void], i: int) -> dict[str, object]:
    row = match[0]
    player: dict[str, object] = {
        "side": "l" if i < MAX_PLAYERS else "r",
        "unum": i % MAX_PLAYERS + 1,
        "type": int(row["type"][i]),
        "state": int(state_flags(match, i)),
        "x": _rounded(row["pos"][i, 0]),
        "y": _rounded(row["pos"][i, 1]),
        "vx": _rounded(row["vel"][i, 0]),
        "vy": _rounded(row["vel"][i, 1]),
        "body": _rounded(row["body"][i] * RAD, _ANGLE),
        "neck": _rounded(row["neck"][i] * RAD, _ANGLE),
    }
    if row["arm_expires"][i] > 0:
        player |= {"px": _rounded(row["arm_pos"][i, 0]), "py": _rounded(row["arm_pos"][i, 1])}
    player |= {
        "vq": "h" if row["quality"][i] == HIGH else "l",
        "vw": _rounded(view_angle(match, params, i), _ANGLE),
        "fdist": _rounded(row["focus_dist"][i]),
        "fdir": _rounded(row["focus_dir"][i] * RAD, _ANGLE),
        "stamina": _plain(row["stamina"][i]),
        "effort": _plain(row["effort"][i]),
        "recovery": _plain(row["recovery"][i]),
        "capacity": _plain(row["capacity"][i]),
    }
    if row["enabled"][i] and row["focus_side"][i] != NO_SIDE:
        player |= {"fside": "l" if row["focus_side"][i] == LEFT else "r", "fnum": int(row["focus_unum"][i])}
    return player | dict(zip(_COUNT_KEYS, map(int, row["counts"][i]), strict=True))


_COUNT_KEYS = (
    "kick", "dash", "turn", "catch", "move", "turn_neck", "change_view", "say", "tackle", "pointto", "attentionto",
    "change_focus",
)  # fmt: skip


def _json_time(match: NDArray[np.void]) -> dict[str, object]:
    stopped = int(match["stopped"][0])
    time: dict[str, object] = {"time": int(match["time"][0])}
    return time | ({"stime": stopped} if stopped > 0 else {})


def json_show(match: NDArray[np.void], params: NDArray[np.void], mode: str, teams: tuple[str, str]) -> str:
    """Return a frame of monitor version -1; ``teams`` are the names, empty where there is none."""
    row = match[0]
    frame: dict[str, object] = {
        **_json_time(match),
        "mode": mode,
        "team": {side: {"name": teams[k] or None, "score": int(row["score"][k])} for k, side in enumerate("lr")},
        "ball": {
            "x": _rounded(row["ball_pos"][0]),
            "y": _rounded(row["ball_pos"][1]),
            "vx": _rounded(row["ball_vel"][0]),
            "vy": _rounded(row["ball_vel"][1]),
        },
        "players": [_json_player(match, params, i) for i in range(N_PLAYERS)],
    }
    return json.dumps({"show": frame}, separators=(",", ":"))


def json_message(match: NDArray[np.void], board: int, text: str) -> str:
    """Return a message for monitors of version -1."""
    return json.dumps({"msg": _json_time(match) | {"board": board, "message": text}}, separators=(",", ":"))
