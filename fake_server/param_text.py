"""Which parameters clients of each version are told (19.0.0, src/initsender.cpp and src/heteroplayer.cpp)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fake_server.player_param import PlayerParams
from rcss_hat.protocol.json_text import json_text
from rcss_hat.protocol.messages import PlayerParam, PlayerType, ServerParam
from rcss_hat.protocol.params import SERVER_PARAMETERS, ServerParams
from rcss_hat.simulation.player_types import PLAYER_TYPE

EVERYTHING = 999
"""Version of clients that are told all there is: monitors and game logs."""

_COACH_MESSAGE_SINCE = 11
"""First version of clients that 11.1 tells ``coach_msg_file``; 19 tells it to monitors only."""
_N_FIELDS = ((14, 11), (18, 14), (19, 25))
"""Clients below each version are told so many fields of a player type; the others all."""


def server_param(params: ServerParams, version: int) -> str:
    """Return ``(server_param ...)`` for clients of a protocol version, or for `EVERYTHING`."""
    if version >= EVERYTHING:
        return ServerParam(values={p.name: params[p.name] for p in SERVER_PARAMETERS}).to_text()
    told = dict(params.for_version(version))
    if params.profile == "11.1" and version >= _COACH_MESSAGE_SINCE:
        told["coach_msg_file"] = params["coach_msg_file"]
    return ServerParam(values=dict(sorted(told.items()))).to_text()


def player_param(params: PlayerParams, version: int) -> str:
    """Return ``(player_param ...)`` for clients of a protocol version, or for `EVERYTHING`."""
    return PlayerParam(values=dict(params.for_version(version))).to_text()


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
    fields = {name: float(types[name][number]) for name in names[:count]}
    return PlayerType(id=number, values={"id": number, **fields}).to_text()


def all_params(params: ServerParams, player_params: PlayerParams, types: NDArray[np.void], version: int) -> list[str]:
    """Return what follows an init reply: server_param, player_param and every player_type."""
    return [
        server_param(params, version),
        player_param(player_params, version),
        *(player_type(types, number, version) for number in range(len(types))),
    ]


def json_params(params: ServerParams, player_params: PlayerParams, types: NDArray[np.void]) -> list[str]:
    """Return the same messages for monitors and game logs in JSON."""
    settings = {parameter.name: params[parameter.name] for parameter in SERVER_PARAMETERS}
    messages: list[dict[str, object]] = [
        {"server_param": settings},
        {"player_param": dict(player_params.for_version(EVERYTHING))},
    ]
    for number in range(len(types)):
        fields = {name: float(types[name][number]) for name in PLAYER_TYPE.names or ()}
        messages.append({"player_type": {"id": number, **fields}})
    return [json_text(message) for message in messages]
