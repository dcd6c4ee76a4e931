"""How one player of ours takes a uniform number: a new one, or one that somebody has left."""

from __future__ import annotations

import asyncio
import socket
from typing import Any

from rcss_hat.protocol.commands import Command, DispBye, DispFoul, DispInit, datagram
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.stage.client import PlayerClient
from rcss_hat.stage.connection import ServerGone
from rcss_hat.stage.monitor import Monitor
from rcss_hat.stage.survey import WrongServer

OUTSIDE = 33.5
"""Where (m from the middle, across) a foul puts the ball: on the pitch, outside of any region, which is 64 m wide at
most, and opposite to the side where players wait who come back."""
_LEFT = 1
_OLD_MONITOR = 1
_IN_PLAY = "cannot_reconnect_while_playon"
TRIES, PAUSE = 20, 0.25
"""How often a monitor asks to join, and seconds to wait for an answer."""
RETURNS = 100
"""How often a number is asked for again. On a busy machine a server that plays on by itself may come in between."""


class Whistle:
    """A monitor that stops play by calling a foul, so that players who left can come back.

    It is of version 1, for these may send to the port at which players join: what comes there is read in order, so
    that not even a step of the simulation, in which a server with ``keepaway_start`` plays on by itself, lies between
    the foul and a player's ``(reconnect ...)`` that was sent right behind it (19.0.0, src/stadium.cpp,
    udp_recv_message).

    Parameters
    ----------
    host, port : str, int
    """

    def __init__(self, host: str, port: int) -> None:
        self._where = (host, port)
        self._socket: socket.socket | None = None
        self._address: Any = None

    async def open(self) -> None:
        """Join as a monitor.

        Raises
        ------
        ServerGone
            When no server answers.
        """
        loop = asyncio.get_running_loop()
        host, port = self._where
        try:
            infos = await loop.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
        except socket.gaierror as error:
            raise ServerGone(f"monitor: the host {host!r} is not known ({error.strerror})") from error
        family, _, _, _, self._address = infos[0]
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        for _ in range(TRIES):
            self._say(DispInit(_OLD_MONITOR))
            try:
                async with asyncio.timeout(PAUSE):
                    await loop.sock_recv(self._socket, 4096)
                return
            except (OSError, TimeoutError):
                continue
        self.close()
        raise ServerGone(f"monitor: no server answers at {host}:{port}")

    def _say(self, command: Command) -> None:
        assert self._socket is not None, "open() comes first"
        self._socket.sendto(datagram(command), self._address)

    def blow(self) -> None:
        """Stop play, and put the ball where an episode ends as soon as play goes on."""
        self._say(DispFoul(0.0, OUTSIDE, _LEFT))

    def close(self) -> None:
        """Leave."""
        if self._socket is not None:
            self._say(DispBye())
            self._socket.close()
            self._socket = None


async def take_place(client: PlayerClient, host: str, port: int, seat: tuple[int, int], known: bool) -> None:
    """Take a seat for a player.

    Parameters
    ----------
    client : PlayerClient
        Connected afterwards.
    host, port : str, int
    seat : (int, int)
        Side (0 left, 1 right) and uniform number.
    known : bool
        The number was given before: it is taken up again.

    Raises
    ------
    WrongServer
        When somebody else is joining at the same time.
    ServerGone, RemoteProtocolError
        When the server does not answer, or refuses.
    """
    side, number = seat
    if not known:
        await client.connect()
        given = client.player.unum
        if given == number:
            return
        await client.close()
        if others := await _others(host, port, side, number, given):
            raise WrongServer(
                f"somebody else is joining at {host}:{port} ({client.player.team} {_list(others)}): wait until they "
                "leave, or use another server"
            )
    await _come_back(client, host, port, number)


async def _others(host: str, port: int, side: int, number: int, given: int) -> set[int]:
    """Who has taken numbers of a side that are not ours: ours are those below the wanted one."""
    monitor = Monitor(host, port)
    try:
        await monitor.connect()
        present = (await monitor.look()).present[side]
        await monitor.leave()
    finally:
        monitor.connection.close()
    return set(present) - set(range(1, number)) - {given}


def _list(numbers: set[int]) -> str:
    return ", ".join(map(str, sorted(numbers)))


async def _come_back(client: PlayerClient, host: str, port: int, number: int) -> None:
    whistle = Whistle(host, port)
    await whistle.open()
    try:
        for _ in range(RETURNS):
            whistle.blow()
            try:
                await client.connect(number=number)
            except RemoteProtocolError as error:
                if _IN_PLAY not in str(error):
                    raise
                await asyncio.sleep(0.0)
            else:
                return
    finally:
        whistle.close()
    raise ServerGone(f"{client.player.team} {number}: the server at {host}:{port} does not let a player come back")
