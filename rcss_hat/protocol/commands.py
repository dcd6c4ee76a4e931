"""Everything a client may send, and how servers read it.

Each command is a small frozen record. `serialize` and `datagram` check and spell commands; `action_to_bytes` does it
fast for the usual ones. The ``parse_*`` functions read them as a server does, with all its oddities.
"""

from __future__ import annotations

from rcss_hat.protocol._action_bytes import action_to_bytes
from rcss_hat.protocol._monitor_commands import (
    DispBye,
    DispCard,
    DispDiscard,
    DispFoul,
    DispInit,
    DispPlayer,
    DispStart,
)
from rcss_hat.protocol._other_parsers import (
    Refusal,
    parse_init,
    parse_monitor_command,
    parse_trainer_command,
    parse_trainer_init,
)
from rcss_hat.protocol._player_commands import (
    AttentionTo,
    Bye,
    Catch,
    ChangeFocus,
    ChangeView,
    Clang,
    Command,
    Compression,
    Dash,
    DashLegs,
    Done,
    Ear,
    GaussianSee,
    Init,
    Kick,
    LongKick,
    Move,
    PointTo,
    Reconnect,
    Say,
    Score,
    SenseBody,
    SynchSee,
    Tackle,
    Turn,
    TurnNeck,
)
from rcss_hat.protocol._player_parser import parse_commands
from rcss_hat.protocol._trainer_commands import (
    ChangeMode,
    ChangePlayerType,
    CheckBall,
    Eye,
    Look,
    MoveBall,
    MovePlayer,
    Recover,
    Start,
    TeamNames,
    TrainerEar,
    TrainerInit,
    TrainerSay,
)
from rcss_hat.protocol.errors import LocalProtocolError

MAX_DATAGRAM = 8192
"""Bytes of the largest datagram, either way, with its NUL."""

__all__ = [
    "MAX_DATAGRAM", "AttentionTo", "Bye", "Catch", "ChangeFocus", "ChangeMode", "ChangePlayerType", "ChangeView",
    "CheckBall", "Clang", "Command", "Compression", "Dash", "DashLegs", "DispBye", "DispCard", "DispDiscard",
    "DispFoul", "DispInit", "DispPlayer", "DispStart", "Done", "Ear", "Eye", "GaussianSee", "Init", "Kick",
    "LongKick", "Look", "Move", "MoveBall", "MovePlayer", "PointTo", "Reconnect", "Recover", "Refusal", "Say",
    "Score", "SenseBody", "Start", "SynchSee", "Tackle", "TeamNames", "TrainerEar", "TrainerInit", "TrainerSay",
    "Turn", "TurnNeck", "action_to_bytes", "datagram", "parse_commands", "parse_init", "parse_monitor_command",
    "parse_trainer_command", "parse_trainer_init", "serialize",
]  # fmt: skip


def serialize(command: Command) -> bytes:
    """Return a command as the server reads it, without NUL.

    Raises
    ------
    LocalProtocolError
        When an argument is illegal; says what would be right.
    """
    return command.to_bytes()


def datagram(*commands: Command) -> bytes:
    """Put commands into one datagram, in their order.

    Raises
    ------
    LocalProtocolError
        When a command is illegal, needs a datagram of its own, or when there is none or too much.
    """
    if not commands:
        raise LocalProtocolError("a datagram needs at least one command")
    for command in commands:
        if command.alone and len(commands) > 1:
            raise LocalProtocolError(f"{type(command).__name__} needs a datagram of its own")
    data = b"".join([command.to_bytes() for command in commands]) + b"\0"
    if len(data) > MAX_DATAGRAM:
        raise LocalProtocolError(f"a datagram has at most {MAX_DATAGRAM} bytes, this one has {len(data)}")
    return data
