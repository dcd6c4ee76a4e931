"""Everything a server may say: one kind of event per kind of message, and `parse`."""

from __future__ import annotations

from rcss_hat.protocol._event_parsers import parse
from rcss_hat.protocol._events import (
    BallState,
    ChangePlayerType,
    Error,
    Event,
    Fullstate,
    FullstatePlayer,
    GlobalPlayer,
    Hear,
    Init,
    InitOk,
    Msg,
    Ok,
    OkCheckBall,
    OkClang,
    OkCompression,
    OkTeamNames,
    PlayerParam,
    PlayerType,
    PlayMode,
    Reconnect,
    Score,
    See,
    SeeGlobal,
    SenseBody,
    ServerParam,
    Show,
    ShowPlayer,
    Team,
    Think,
    Unknown,
    Warning,
)

__all__ = [
    "BallState", "ChangePlayerType", "Error", "Event", "Fullstate", "FullstatePlayer", "GlobalPlayer", "Hear", "Init",
    "InitOk", "Msg", "Ok", "OkCheckBall", "OkClang", "OkCompression", "OkTeamNames", "PlayMode", "PlayerParam",
    "PlayerType", "Reconnect", "Score", "See", "SeeGlobal", "SenseBody", "ServerParam", "Show", "ShowPlayer", "Team",
    "Think", "Unknown", "Warning", "parse",
]  # fmt: skip
