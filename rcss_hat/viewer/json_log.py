"""Game logs in JSON, as rcssserver 17 to 19 write them with ``server::game_log_version=-1``: one entry a line.

The lines are ``[``, then ``{"version":"19.0.0"},``, ``{"server_param":{...}},``, ``{"playmode":{...}},``,
``{"team":{...}},``, ``{"show":{...}},`` and others, at the end ``]``. Each is read into the same event as its sister in
a text log. (19.0.0, src/dispsender.cpp, DispSenderLoggerJSON)
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from rcss_hat.inputs import FileFormatError, item, load_json, whole
from rcss_hat.protocol import messages

OPENING = b"["
BEGIN = b'{"version":'
"""How a JSON log's first line begins, and its second."""
_NUMBER = (int, float)
# Players who are not on the field: of state 0, mostly most of the 22.
_ABSENT = re.compile(
    rb'\{"side":"[lr]","unum":\d+,"type":\d+,"state":0,[^{}]*(?:\{[^{}]*\}[^{}]*)*?\},?(?=\{"side"|\])'
)
_COUNTS = (
    "kick", "dash", "turn", "catch", "move", "turn_neck", "change_view", "say", "tackle", "pointto", "attentionto",
    "change_focus",
)  # fmt: skip


def read_json_line(line: bytes) -> messages.Event | None:
    """Read a line of a JSON log; None for what a viewer does not need.

    Raises
    ------
    FileFormatError
        When it is malformed.
    """
    text = line.strip().removesuffix(b",")
    kind = next((kind for kind in _READERS if text.startswith(b'{"' + kind.encode() + b'":')), None)
    if kind is None:
        return None
    try:
        content = load_json(_ABSENT.sub(b"", text).replace(b"},]", b"}]").decode("utf-8"))
    except UnicodeDecodeError as error:
        raise FileFormatError(f"not UTF-8 text (byte {error.start})") from error
    return _READERS[kind](item(content, kind, dict))


def _server_param(content: dict[str, Any]) -> messages.Event:
    values = {name: int(value) if isinstance(value, bool) else value for name, value in content.items()}
    if not all(isinstance(value, int | float | str) for value in values.values()):
        raise FileFormatError("a server parameter must be a number, a word, true or false")
    return messages.ServerParam(values=values)


def _play_mode(content: dict[str, Any]) -> messages.Event:
    return messages.PlayMode(time=whole(content, "time"), mode=item(content, "mode", str))


def _team(content: dict[str, Any]) -> messages.Event:
    left, right = item(content, "l", dict), item(content, "r", dict)
    names = [item(side, "name", (str, type(None))) or "null" for side in (left, right)]
    scores = [whole(side, "score") for side in (left, right)]
    return messages.Team(
        left=names[0], right=names[1], left_score=scores[0], right_score=scores[1], time=whole(content, "time")
    )


def _show(content: dict[str, Any]) -> messages.Event:
    ball = item(content, "ball", dict)
    x, y, vx, vy = (float(item(ball, name, _NUMBER, "ball")) for name in ("x", "y", "vx", "vy"))
    players = tuple(_player(entry) for entry in item(content, "players", list))
    return messages.Show(
        time=whole(content, "time"),
        mode=None,
        team=None,
        ball=messages.BallState(x=x, y=y, vx=vx, vy=vy),
        players=players,
    )


def _player(entry: Any) -> messages.ShowPlayer:
    side = item(entry, "side", str)
    if side not in ("l", "r"):
        raise FileFormatError(f"a player's side is l or r, not {side[:10]!r}")
    x, y, vx, vy, body, neck = (float(item(entry, name, _NUMBER)) for name in ("x", "y", "vx", "vy", "body", "neck"))
    stamina, effort, recovery = (float(item(entry, name, _NUMBER)) for name in ("stamina", "effort", "recovery"))
    return messages.ShowPlayer(
        side=side,
        unum=whole(entry, "unum", low=1, high=11),
        player_type=whole(entry, "type"),
        state=whole(entry, "state", high=2**32),
        x=x,
        y=y,
        vx=vx,
        vy=vy,
        body=body,
        neck=neck,
        arm=None,
        quality=item(entry, "vq", str),
        view_angle=float(item(entry, "vw", _NUMBER)),
        focus_point=None,
        stamina=stamina,
        effort=effort,
        recovery=recovery,
        capacity=float(item(entry, "capacity", _NUMBER)),
        attention=None,
        counts=tuple(whole(entry, name) if name in entry else 0 for name in _COUNTS),
    )


_READERS: dict[str, Callable[[dict[str, Any]], messages.Event]] = {
    "show": _show,
    "playmode": _play_mode,
    "team": _team,
    "server_param": _server_param,
}
