"""Parameter messages: server_param, player_param, player_type (19.0.0, src/initsender.cpp and src/heteroplayer.cpp)."""

from __future__ import annotations

import json
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from fake_server.player_param import PlayerParams
from fake_server.simulation.player_types import PLAYER_TYPE
from rcss_hat.protocol.params import SERVER_PARAMETERS, ServerParams, Value

EVERYTHING = 999
"""Version of clients that are told all there is: monitors and game logs."""

_COACH_MESSAGE_SINCE = 11
"""First version of clients that 11.1 tells ``coach_msg_file``; 19 tells it to monitors only."""
_N_FIELDS = ((14, 11), (18, 14), (19, 25))
"""Clients below each version are told so many fields of a player type; the others all."""


def _value(value: Value) -> str:
    if isinstance(value, str):
        return f'"{value}"'
    return f"{value:g}" if isinstance(value, float) else f"{int(value)}"


def _message(name: str, pairs: Iterable[tuple[str, Value]]) -> str:
    return f"({name} " + "".join(f"({key} {_value(value)})" for key, value in pairs) + ")"


def server_param(params: ServerParams, version: int) -> str:
    """Return ``(server_param ...)`` for clients of a protocol version, or for `EVERYTHING`."""
    if version >= EVERYTHING:
        return _message("server_param", ((p.name, params[p.name]) for p in SERVER_PARAMETERS))
    told = dict(params.for_version(version))
    if params.profile == "11.1" and version >= _COACH_MESSAGE_SINCE:
        told["coach_msg_file"] = params["coach_msg_file"]
    return _message("server_param", sorted(told.items()))


def player_param(params: PlayerParams, version: int) -> str:
    """Return ``(player_param ...)`` for clients of a protocol version, or for `EVERYTHING`."""
    return _message("player_param", params.for_version(version))


def player_type(types: NDArray[np.void], number: int, version: int) -> str:
    """Return ``(player_type ...)``.

    Parameters
    ----------
    types : ndarray of PLAYER_TYPE
    number : int
        Which of them.
    version : int
        Protocol version of the client, or `EVERYTHING`.
    """
    names = PLAYER_TYPE.names or ()
    count = next((count for below, count in _N_FIELDS if version < below), len(names))
    fields = ((name, float(types[name][number])) for name in names[:count])
    return _message("player_type", [("id", number), *fields])


def all_params(params: ServerParams, player_params: PlayerParams, types: NDArray[np.void], version: int) -> list[str]:
    """Return what follows an init reply: server_param, player_param and every player_type."""
    return [
        server_param(params, version),
        player_param(player_params, version),
        *(player_type(types, number, version) for number in range(len(types))),
    ]


def json_params(params: ServerParams, player_params: PlayerParams, types: NDArray[np.void]) -> list[str]:
    """Return the same messages for monitors that read JSON."""
    settings = {parameter.name: params[parameter.name] for parameter in SERVER_PARAMETERS}
    messages: list[dict[str, object]] = [
        {"server_param": {name: _plain(value) for name, value in settings.items()}},
        {"player_param": {name: _plain(value) for name, value in player_params.for_version(EVERYTHING)}},
    ]
    for number in range(len(types)):
        fields = {name: _plain(float(types[name][number])) for name in PLAYER_TYPE.names or ()}
        messages.append({"player_type": {"id": number, **fields}})
    return [json.dumps(message, separators=(",", ":")) for message in messages]


def _plain(value: Value) -> Value:
    """Return a number as ``%g`` prints it, whole ones as integers."""
    if not isinstance(value, float):
        return value
    printed = float(f"{value:g}")
    return int(printed) if printed.is_integer() else printed
