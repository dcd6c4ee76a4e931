"""Monitors' frames and messages of version -1, and those of game logs, as JSON (19.0.0, src/serializermonitor.cpp)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import RAD
from rcss_hat.numeric.wire import quantize
from rcss_hat.protocol.json_text import json_text
from rcss_hat.protocol.messages.frame import COUNTERS
from rcss_hat.protocol.messages.show import ANGLE, LENGTH
from rcss_hat.protocol.records import HIGH, LEFT, MAX_PLAYERS, NO_SIDE


def _rounded(value: float, step: float = LENGTH) -> float:
    return float(quantize(float(value), step))


def _json_player(frame: NDArray[np.void], i: int, flags: int, view_angle: float, to_monitor: bool) -> dict[str, object]:
    row = frame[0]
    player: dict[str, object] = {
        "side": "l" if i < MAX_PLAYERS else "r",
        "unum": i % MAX_PLAYERS + 1,
        "type": int(row["type"][i]),
        "state": flags,
        "x": _rounded(row["pos"][i, 0]),
        "y": _rounded(row["pos"][i, 1]),
        "vx": _rounded(row["vel"][i, 0]),
        "vy": _rounded(row["vel"][i, 1]),
        "body": _rounded(row["body"][i] * RAD, ANGLE),
        "neck": _rounded(row["neck"][i] * RAD, ANGLE),
    }
    if row["arm_expires"][i] > 0:
        player |= {"px": _rounded(row["arm_pos"][i, 0]), "py": _rounded(row["arm_pos"][i, 1])}
    player |= {
        "vq": "h" if row["quality"][i] == HIGH else "l",
        "vw": _rounded(view_angle, ANGLE),
    }
    if to_monitor:
        player |= {
            "fdist": _rounded(row["focus_dist"][i]),
            "fdir": _rounded(row["focus_dir"][i] * RAD, ANGLE),
        }
    player |= {name: float(row[name][i]) for name in ("stamina", "effort", "recovery", "capacity")}
    if row["enabled"][i] and row["focus_side"][i] != NO_SIDE:
        player |= {"fside": "l" if row["focus_side"][i] == LEFT else "r", "fnum": int(row["focus_unum"][i])}
    if to_monitor:  # and nothing of how often he has done what
        return player
    return player | dict(zip(COUNTERS, map(int, row["counts"][i]), strict=True))


def json_time(frame: NDArray[np.void]) -> dict[str, object]:
    """Return cycle and, while the frame is stopped, the step of the stoppage."""
    stopped = int(frame["stopped"][0])
    time: dict[str, object] = {"time": int(frame["time"][0])}
    return time | ({"stime": stopped} if stopped > 0 else {})


def json_team(frame: NDArray[np.void], teams: tuple[str, str]) -> dict[str, object]:
    """Return names, null where there is no team, and score."""
    score = frame["score"][0].tolist()
    return {side: {"name": teams[k] or None, "score": score[k]} for k, side in enumerate("lr")}


def json_show(
    frame: NDArray[np.void],
    flags: NDArray[np.int64],
    view_angles: NDArray[np.float64],
    mode: str | None = None,
    teams: tuple[str, str] = ("", ""),
) -> str:
    """Return a frame of monitor version -1, or of a game log.

    Parameters
    ----------
    frame : ndarray of a record of the match, shape (1,)
        See `frame`.
    flags, view_angles : ndarray, shape (22,)
        Every player's state; degrees.
    mode : str, optional
        Play mode; None for a game log, whose frames hold no mode, teams and focus points.
    teams : tuple of str
        Names, empty where there is none.
    """
    row = frame[0]
    head = {} if mode is None else {"mode": mode, "team": json_team(frame, teams)}
    told: dict[str, object] = {
        **json_time(frame),
        **head,
        "ball": {
            "x": _rounded(row["ball_pos"][0]),
            "y": _rounded(row["ball_pos"][1]),
            "vx": _rounded(row["ball_vel"][0]),
            "vy": _rounded(row["ball_vel"][1]),
        },
        "players": [
            _json_player(frame, i, int(flags[i]), float(view_angles[i]), mode is not None)
            for i in range(2 * MAX_PLAYERS)
        ],
    }
    return json_text({"show": told})


def json_message(frame: NDArray[np.void], board: int, text: str) -> str:
    """Return a message for monitors of version -1 and for game logs."""
    return json_text({"msg": json_time(frame) | {"board": board, "message": text}})
