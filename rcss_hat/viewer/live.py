"""A running server, watched as a monitor."""

from __future__ import annotations

import asyncio
import contextlib
import socket
from typing import Any

import asyncio_dgram
from asyncio_dgram.aio import DatagramServer

from rcss_hat.protocol import messages
from rcss_hat.protocol.commands import DispBye, DispInit, datagram
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.viewer.audience import Audience, WatchError
from rcss_hat.viewer.narrator import Insight, Narrator
from rcss_hat.viewer.shows import read, setup_of, snapshot_of, team_names

MONITOR_VERSION = 4
RECEIVE_BUFFER = 1 << 20
PATIENCE = 10.0
"""Seconds that a server may take to answer, or to be silent, before it counts as gone."""
RETRY = 0.25
"""Seconds between attempts to connect."""
Address = tuple[Any, ...]


class MonitorSource:
    """A server that is watched through the monitor protocol (text, versions 3 to 5).

    Parameters
    ----------
    host, port : str, int
        Where the server takes first datagrams.
    insight : Insight, optional
        What is known of the keepers' minds.
    title : str, optional
        What people are told they watch.
    patience : float
        Seconds to wait for the server.
    stay : bool
        Wait for the server to come back when it has gone, instead of ending with an error.
    """

    def __init__(
        self,
        host: str,
        port: int,
        insight: Insight | None = None,
        title: str | None = None,
        patience: float = PATIENCE,
        stay: bool = False,
    ) -> None:
        self.host, self.port, self.insight = host, port, insight
        self.title = title or f"{host}:{port}"
        self.patience, self.stay = patience, stay

    def command(self, name: str, value: float) -> bool:
        """Refuse: a running match cannot be stopped by those who watch."""
        return False

    async def run(self, audience: Audience) -> None:
        """Connect and show every frame.

        Raises
        ------
        WatchError
            When no server answers, it refuses, or it has gone.
        """
        audience.notice(f"Waiting for the server at {self.host}:{self.port}.")
        await self._session(audience)
        while True:
            audience.notice(f"The server at {self.host}:{self.port} has gone; waiting for it to come back.")
            try:
                await self._session(audience)
            except WatchError:
                await asyncio.sleep(RETRY)

    async def _session(self, audience: Audience) -> None:
        """Watch from connecting to the server's end; returns only when we are to stay."""
        stream, server, first = await self._connect()
        session = _Session(self, audience)
        try:
            session.take(first)
            while True:
                try:
                    async with asyncio.timeout(self.patience):
                        data, _ = await stream.recv()
                except TimeoutError:
                    break
                except (OSError, asyncio_dgram.TransportClosed):
                    break
                session.take(bytes(data))
        finally:
            await _leave(stream, server)
        if not self.stay:
            raise WatchError(f"the server at {self.host}:{self.port} has gone")

    async def _connect(self) -> tuple[DatagramServer, Address, bytes]:
        """Greet the server until it answers, then listen only to the port it answered from."""
        loop = asyncio.get_running_loop()
        try:
            infos = await loop.getaddrinfo(self.host, self.port, type=socket.SOCK_DGRAM)
        except socket.gaierror as error:
            raise WatchError(f"the host {self.host!r} is not known ({error.strerror})") from error
        family, _, _, _, address = infos[0]
        end = socket.socket(family, socket.SOCK_DGRAM)
        end.setblocking(False)
        end.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        end.bind(("", 0))
        stream = await asyncio_dgram.from_socket(end)
        assert isinstance(stream, DatagramServer)
        greeting = datagram(DispInit(MONITOR_VERSION))
        give_up = loop.time() + self.patience
        try:
            while loop.time() < give_up:
                await stream.send(greeting, address)
                try:
                    async with asyncio.timeout(RETRY):
                        reply, sender = await stream.recv()
                except TimeoutError:
                    continue
                except OSError:
                    await asyncio.sleep(RETRY)
                    continue
                if isinstance(sender, tuple) and sender[0] == address[0]:
                    end.connect(sender)
                    return stream, sender, bytes(reply)
        except BaseException:
            stream.close()
            raise
        stream.close()
        raise WatchError(
            f"no server answers at {self.host}:{self.port} (waited {self.patience:.0f} s); is it running there?"
        )


async def _leave(stream: DatagramServer, server: Address) -> None:
    """Say goodbye, so that the server need not find out, and close."""
    with contextlib.suppress(OSError, asyncio_dgram.TransportClosed):
        await stream.send(datagram(DispBye()), server)
    stream.close()


class _Session:
    """One stay at one server: from its parameters to its last frame."""

    def __init__(self, source: MonitorSource, audience: Audience) -> None:
        self.source, self.audience = source, audience
        self.params: messages.ServerParam | None = None
        self.narrator: Narrator | None = None

    def take(self, data: bytes) -> None:
        """Take a datagram; what is neither parameters nor a frame is nothing to see."""
        try:
            event = read(data)
        except RemoteProtocolError as error:
            self.audience.notice(f"A message could not be read: {error}")
            return
        if isinstance(event, messages.Show):
            self._show(event)
        elif isinstance(event, messages.ServerParam):
            self.params = event
        elif isinstance(event, messages.Error):
            raise WatchError(
                f"the server at {self.source.host}:{self.source.port} refuses a monitor of version "
                f"{MONITOR_VERSION}: {event.text}"
            )

    def _show(self, show: messages.Show) -> None:
        teams = team_names(show.team)
        if self.narrator is None or self.narrator.setup.teams != teams:
            self._set_up(teams)
        assert self.narrator is not None
        frame, ended = self.narrator.tell(snapshot_of(show, "play_on"))
        self.audience.frame(frame)
        if ended is not None:
            self.audience.episode(ended)

    def _set_up(self, teams: tuple[str, str]) -> None:
        setup = setup_of(self.params, self.source.title, teams)
        if self.narrator is None:
            self.narrator = Narrator(setup, self.source.insight)
            self.audience.episodes([])
            self.audience.notice("")
        self.narrator.setup = setup
        self.audience.setup(setup, live=True)
