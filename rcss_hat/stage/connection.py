"""One UDP client of a soccer server, over asyncio-dgram.

The server answers the first datagram from a new port and speaks from there ever after. The socket is therefore open
to all at first and connected to that port once the first reply has come, so that a server that is gone is noticed
(the operating system reports "connection refused") and strangers' datagrams are dropped.
"""

from __future__ import annotations

import asyncio
import socket
from types import TracebackType
from typing import Any

import asyncio_dgram
from asyncio_dgram.aio import DatagramServer

from rcss_hat.protocol.errors import one_line

RECEIVE_BUFFER = 1 << 20


class ServerGone(ConnectionError):
    """The server does not answer, or stopped to; the message is one printable line."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


def received(datagram: tuple[Any, Any]) -> tuple[bytes, tuple[str, int]]:
    """Return what a stream's ``recv()`` gave, with the types of an internet socket."""
    data, address = datagram
    return bytes(data), (str(address[0]), int(address[1]))


class Connection:
    """A datagram connection to a server.

    Parameters
    ----------
    host, port : str, int
        Where the server takes first datagrams.
    name : str
        Who we are, for messages: ``"keeper 1"``; empty: they begin without.
    """

    def __init__(self, host: str, port: int, name: str) -> None:
        self.server = (host, port)
        self.name = name
        self._subject = f"{name}: " if name else ""
        self._socket: socket.socket | None = None
        self._stream: DatagramServer | None = None

    async def open(self, first: bytes, *, attempts: int = 60, pause: float = 0.25) -> bytes:
        r"""Send the first datagram until the server answers.

        Parameters
        ----------
        first : bytes
            Complete datagram, for example ``b"(init keepers (version 11))\0"``.
        attempts, pause : int, float
            How often, and seconds between.

        Returns
        -------
        bytes
            The server's first reply.

        Raises
        ------
        ServerGone
            When no answer came.
        """
        host, port = self.server
        try:
            infos = await asyncio.get_running_loop().getaddrinfo(host, port, type=socket.SOCK_DGRAM)
        except socket.gaierror as error:
            raise ServerGone(f"{self._subject}the host {host!r} is not known ({error.strerror})") from error
        family, _, _, _, address = infos[0]
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        self._socket.bind(("", 0))
        stream = await asyncio_dgram.from_socket(self._socket)
        assert isinstance(stream, DatagramServer)  # not connected yet
        self._stream = stream
        try:
            reply, sender = await self._ask(stream, first, address, attempts, pause)
        except BaseException:
            self.close()
            raise
        self._socket.connect(sender)
        self.server = sender
        return reply

    async def _ask(
        self, stream: DatagramServer, first: bytes, address: Any, attempts: int, pause: float
    ) -> tuple[bytes, tuple[str, int]]:
        """Send the first datagram until its address's host answers; returns the reply and where it came from."""
        for _ in range(attempts):
            await stream.send(first, address)
            try:
                async with asyncio.timeout(pause):
                    reply, sender = received(await stream.recv())
            except TimeoutError:
                continue
            except OSError:
                await asyncio.sleep(pause)
                continue
            if sender[0] == address[0]:
                return reply, sender
        host, port = self.server
        raise ServerGone(
            f"{self._subject}no server answers at {host}:{port} (waited {attempts * pause:.0f} s); is it running there?"
        )

    async def receive(self) -> bytes:
        """Wait for the next datagram.

        Raises
        ------
        ServerGone
            When the server's port was closed.
        """
        assert self._stream is not None, "open() comes first"
        try:
            data, _ = await self._stream.recv()
        except (OSError, asyncio_dgram.TransportClosed) as error:
            raise ServerGone(f"{self._subject}the server at {self.server[0]}:{self.server[1]} is gone") from error
        return bytes(data)

    async def send(self, data: bytes) -> None:
        """Send one complete datagram (with its final NUL)."""
        assert self._stream is not None, "open() comes first"
        try:
            await self._stream.send(data, self.server)
        except (OSError, asyncio_dgram.TransportClosed) as error:
            raise ServerGone(f"{self._subject}the server at {self.server[0]}:{self.server[1]} is gone") from error

    def send_now(self, data: bytes) -> None:
        """Send one complete datagram from a timer, where nothing can be awaited; a lost server is noticed later."""
        assert self._socket is not None, "open() comes first"
        try:
            self._socket.send(data)
        except OSError:
            return

    def close(self) -> None:
        """Close the socket."""
        if self._stream is not None:
            self._stream.close()
            self._stream = None

    async def __aenter__(self) -> Connection:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
