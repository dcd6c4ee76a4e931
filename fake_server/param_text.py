"""Parameter messages: server_param, player_param, player_type (19.0.0, src/initsender.cpp and src/heteroplayer.cpp)."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from fake_server.player_param import PlayerParams
from fake_server.simulation.player_types import PLAYER_TYPE
from rcss_hat.protocol.params import SERVER_PARAMETERS, ServerParams, Value

EVERYTHING = 999
"""Version of clients that are told all there is: monitors and game logs."""

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
    return _message("server_param", params.for_version(version))


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
