"""One UDP client of a soccer server.

The server answers the first datagram from a new port and speaks from there ever after. The socket is therefore open
to all at first and connected to that port once the first reply has come, so that a server that is gone is noticed
(the operating system reports "connection refused") and strangers' datagrams are dropped.

Who waits for one datagram or another awaits `Connection.receive`. Players, who take thousands per second, give a
function instead (`Connection.listen`): it is called with all that have come, without a task, a queue or a future each.
"""

from __future__ import annotations

import asyncio
import contextlib
import select
import socket
from collections.abc import Callable
from types import TracebackType
from typing import Any

from rcss_hat.protocol.errors import one_line

RECEIVE_BUFFER = 1 << 20
LARGEST = 1 << 16
"""No datagram has more bytes."""
AT_A_TIME = 64
"""Datagrams that are taken from one socket before others have their turn; a cycle brings a player about six."""


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
        self._listening = False
        self._late: set[asyncio.Task[None]] = set()

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
        self._socket = opened = socket.socket(family, socket.SOCK_DGRAM)
        opened.setblocking(False)
        opened.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        opened.bind(("", 0))
        try:
            reply, sender = await self._ask(opened, first, address, attempts, pause)
        except BaseException:
            self.close()
            raise
        opened.connect(sender)
        self.server = sender
        return reply

    async def _ask(
        self, opened: socket.socket, first: bytes, address: Any, attempts: int, pause: float
    ) -> tuple[bytes, tuple[str, int]]:
        """Send the first datagram until its address's host answers; returns the reply and where it came from."""
        loop = asyncio.get_running_loop()
        for _ in range(attempts):
            try:
                await loop.sock_sendto(opened, first, address)
                async with asyncio.timeout(pause):
                    reply, sender = received(await loop.sock_recvfrom(opened, LARGEST))
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

    def _gone(self) -> ServerGone:
        return ServerGone(f"{self._subject}the server at {self.server[0]}:{self.server[1]} is gone")

    async def receive(self) -> bytes:
        """Wait for the next datagram.

        Raises
        ------
        ServerGone
            When the server's port was closed.
        """
        assert self._socket is not None, "open() comes first"
        try:
            return await asyncio.get_running_loop().sock_recv(self._socket, LARGEST)
        except OSError as error:
            raise self._gone() from error

    def arrived(self, patience: float = 0.0) -> list[bytes]:
        """Return all that has come; wait for something so many seconds at most, while everything else stands still.

        Raises
        ------
        ServerGone
            When the server's port was closed.
        """
        assert self._socket is not None, "open() comes first"
        if patience > 0.0:
            select.select([self._socket], [], [], patience)
        came: list[bytes] = []
        try:
            while True:
                came.append(self._socket.recv(LARGEST))
        except BlockingIOError:
            return came
        except OSError as error:
            raise self._gone() from error

    def listen(self, take: Callable[[bytes], None], fail: Callable[[Exception], None]) -> None:
        """Have a function called with every datagram from now on, instead of awaiting `receive`.

        Parameters
        ----------
        take : callable
            Given every datagram.
        fail : callable
            Given what `take` raises, or ServerGone when the server's port was closed; nothing is taken any more then.
        """
        assert self._socket is not None, "open() comes first"
        receive = self._socket.recv

        def read() -> None:
            for _ in range(AT_A_TIME):
                try:
                    data = receive(LARGEST)
                except BlockingIOError:
                    return
                except OSError:
                    self.deaf()
                    return fail(self._gone())
                try:
                    take(data)
                except Exception as error:
                    self.deaf()
                    fail(error)
                if not self._listening:
                    return

        self._listening = True
        asyncio.get_running_loop().add_reader(self._socket, read)

    def deaf(self) -> None:
        """Undo `listen`."""
        if self._listening and self._socket is not None:
            self._listening = False
            asyncio.get_running_loop().remove_reader(self._socket)

    async def send(self, data: bytes) -> None:
        """Send one complete datagram (with its final NUL)."""
        assert self._socket is not None, "open() comes first"
        try:
            await asyncio.get_running_loop().sock_sendall(self._socket, data)
        except OSError as error:
            raise self._gone() from error

    def send_now(self, data: bytes) -> None:
        """Send one complete datagram where nothing can be awaited; a lost server is noticed later."""
        assert self._socket is not None, "open() comes first"
        try:
            self._socket.send(data)
        except BlockingIOError:  # the network cannot take it at once
            late = asyncio.get_running_loop().create_task(self._send_late(data))
            self._late.add(late)
            late.add_done_callback(self._late.discard)
        except OSError:
            return

    async def _send_late(self, data: bytes) -> None:
        with contextlib.suppress(ServerGone, AssertionError):
            await self.send(data)

    def close(self) -> None:
        """Close the socket."""
        self.deaf()
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    async def __aenter__(self) -> Connection:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
