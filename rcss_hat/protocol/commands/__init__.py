"""Everything a client may send, and how servers read it.

Each command is a small frozen record. `serialize` and `datagram` check and spell commands; `action_to_bytes` does it
fast for the usual ones. The ``parse_*`` functions read them as a server does, with all its oddities.
"""

from __future__ import annotations

from rcss_hat.protocol.commands import joining, monitor, player, trainer
from rcss_hat.protocol.commands.action import action_to_bytes
from rcss_hat.protocol.commands.joining import *  # noqa: F403
from rcss_hat.protocol.commands.monitor import *  # noqa: F403
from rcss_hat.protocol.commands.player import *  # noqa: F403
from rcss_hat.protocol.commands.table import Command
from rcss_hat.protocol.commands.trainer import *  # noqa: F403
from rcss_hat.protocol.commands.values import Refusal
from rcss_hat.protocol.errors import LocalProtocolError

MAX_DATAGRAM = 8192
"""Bytes of the largest datagram, either way, with its NUL."""

__all__ = ["MAX_DATAGRAM", "Command", "Refusal", "action_to_bytes", "datagram", "serialize"]
__all__ += joining.__all__ + monitor.__all__ + player.__all__ + trainer.__all__


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
