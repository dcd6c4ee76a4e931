"""Watch who is on the field and start a match, as a monitor would; readiness is what the server shows, not a delay."""

from __future__ import annotations

import asyncio
import re
import struct

from rcss_hat.protocol.commands import DispBye, DispInit, DispStart, datagram
from rcss_hat.team.connection import Connection, ServerGone

NUL = b"\0"
MONITOR_VERSION, OLD_VERSION = 4, 1
"""Servers of the time of 11.1 know only binary frames; all know those of version 1."""
_PLAYER = re.compile(rb"\(\(([lr]) \d+\) \d+ (0x[0-9a-f]+|0) ")
_OLD_SHOW, _OLD_SIZE = b"\0\1", 2052
_OLD_PLAYERS = struct.Struct(">" + "2h8x" * 22)
_OLD_FIRST = 52
"""Offset of the first player in a frame of version 1; state and side come first in each of the 22 entries."""


def sides_present(frame: bytes) -> tuple[int, int] | None:
    """Count the players of the left and the right side in a monitor's frame; None for other messages."""
    if frame.startswith(b"(show"):
        sides = [side for side, state in _PLAYER.findall(frame) if state != b"0"]
        return sides.count(b"l"), sides.count(b"r")
    if frame.startswith(_OLD_SHOW) and len(frame) >= _OLD_SIZE:
        words = _OLD_PLAYERS.unpack_from(frame, _OLD_FIRST)
        sides = [side for state, side in zip(words[::2], words[1::2], strict=True) if state != 0]
        return sides.count(1), sides.count(-1)
    return None


class Referee:
    """A monitor that waits until the teams are complete, kicks off, and leaves.

    A monitor slows down a server in synch mode, so it does not stay longer than it must.

    Parameters
    ----------
    host, port : str, int

    Attributes
    ----------
    old : bool
        The server is older than 14, where a monitor's ``(dispstart)`` kicks off soccer even in Keepaway mode; it
        starts Keepaway by itself when ``keepaway_start`` seconds have gone by.
    """

    def __init__(self, host: str, port: int) -> None:
        self.connection = Connection(host, port, "monitor")
        self.old = False

    async def connect(self) -> None:
        """Connect to the server, as a monitor of an old version where it knows no other.

        Raises
        ------
        ServerGone
            When no server answers, or it takes no monitor.
        """
        host, port = self.connection.server
        reply = await self.connection.open(datagram(DispInit(MONITOR_VERSION)))
        if reply.startswith(b"(error"):
            self.old = True
            self.connection.close()
            self.connection = Connection(host, port, self.connection.name)
            reply = await self.connection.open(datagram(DispInit(OLD_VERSION)))
        if reply.startswith(b"(error"):
            raise ServerGone(f"monitor: the server at {host}:{port} refuses: {reply.rstrip(NUL).decode('latin-1')}")

    async def wait_for(self, keepers: int, takers: int, patience: float = 60.0) -> None:
        """Wait until so many players are on the field.

        Parameters
        ----------
        keepers, takers : int
            Players of the left and the right side.
        patience : float
            Seconds.

        Raises
        ------
        ServerGone
            When they did not come, or the server went.
        """
        left = right = 0
        try:
            async with asyncio.timeout(patience):
                while left < keepers or right < takers:
                    left, right = sides_present(await self.connection.receive()) or (left, right)
        except TimeoutError:
            raise ServerGone(
                f"waited {patience:.0f} s for {keepers} keepers and {takers} takers; {left} and {right} came"
            ) from None

    async def kick_off(self) -> None:
        """Start the match."""
        await self.connection.send(datagram(DispStart()))

    async def leave(self) -> None:
        """Disconnect."""
        await self.connection.send(datagram(DispBye()))
        self.connection.close()
