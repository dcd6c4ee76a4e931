"""Watch who is on the field and start a match, as a monitor would; readiness is what the server shows, not a delay."""

from __future__ import annotations

import asyncio
import re

from rcss_hat.protocol.commands import DispBye, DispInit, DispStart, datagram
from rcss_hat.team.connection import Connection, ServerGone

MONITOR_VERSION = 4
_PLAYER = re.compile(rb"\(\(([lr]) \d+\) \d+ (0x[0-9a-f]+|0) ")


class Referee:
    """A monitor that waits until the teams are complete, kicks off, and leaves.

    A monitor slows down a server in synch mode, so it does not stay longer than it must.

    Parameters
    ----------
    host, port : str, int
    """

    def __init__(self, host: str, port: int) -> None:
        self.connection = Connection(host, port, "monitor")

    async def connect(self) -> None:
        """Connect to the server.

        Raises
        ------
        ServerGone
            When no server answers.
        """
        await self.connection.open(datagram(DispInit(MONITOR_VERSION)))

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
                    data = await self.connection.receive()
                    if data.startswith(b"(show"):
                        sides = [side for side, state in _PLAYER.findall(data) if state != b"0"]
                        left, right = sides.count(b"l"), sides.count(b"r")
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
