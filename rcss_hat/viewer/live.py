"""A running server, watched as a monitor."""

from __future__ import annotations

import asyncio
import contextlib

from rcss_hat.protocol import messages
from rcss_hat.protocol.commands import DispBye, DispInit, datagram
from rcss_hat.protocol.errors import RemoteProtocolError, one_line
from rcss_hat.protocol.session import KNOWN
from rcss_hat.stage.connection import Connection, ServerGone
from rcss_hat.viewer.audience import Audience, WatchError
from rcss_hat.viewer.frames import Setup
from rcss_hat.viewer.narrator import Insight, Narrator
from rcss_hat.viewer.shows import read, setup_of, snapshot_of

MONITOR_VERSION = 4
PATIENCE = 10.0
"""Seconds that a server may take to answer, or to be silent, before it counts as gone."""
RETRY = 0.25
"""Seconds between attempts to connect."""


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
        connection = Connection(self.host, self.port, "")
        try:
            first = await connection.open(
                datagram(DispInit(MONITOR_VERSION)), attempts=max(1, round(self.patience / RETRY)), pause=RETRY
            )
        except ServerGone as error:
            raise WatchError(str(error)) from error
        session = _Session(self, audience)
        try:
            session.take(first)
            while True:
                try:
                    async with asyncio.timeout(self.patience):
                        data = await connection.receive()
                except (TimeoutError, ServerGone):
                    break
                session.take(data)
        finally:
            await _leave(connection)
        if not self.stay:
            raise WatchError(f"the server at {self.host}:{self.port} has gone")


async def _leave(connection: Connection) -> None:
    """Say goodbye, so that the server need not find out, and close."""
    with contextlib.suppress(ServerGone):
        await connection.send(datagram(DispBye()))
    connection.close()


class _Session:
    """One stay at one server: from its parameters to its last frame."""

    def __init__(self, source: MonitorSource, audience: Audience) -> None:
        self.source, self.audience = source, audience
        self.params: messages.ServerParam | None = None
        self.narrator: Narrator | None = None
        self._names: tuple[str, str] | None = None

    def take(self, data: bytes) -> None:
        """Take a datagram; what is neither parameters nor a frame is nothing to see.

        A server that took long to answer says of every further greeting that it knows us: no refusal.
        """
        try:
            event = read(data)
        except RemoteProtocolError as error:
            self.audience.notice(f"A message could not be read: {error}")
            return
        if isinstance(event, messages.Show):
            self._show(event)
        elif isinstance(event, messages.ServerParam):
            self.params = event
        elif isinstance(event, messages.Error) and event.text != KNOWN:
            raise WatchError(
                f"the server at {self.source.host}:{self.source.port} refuses a monitor of version "
                f"{MONITOR_VERSION}: {one_line(event.text)}"
            )

    def _show(self, show: messages.Show) -> None:
        names = None if show.team is None else (show.team.left, show.team.right)
        if self.narrator is None or self._names != names:
            self._names = names
            self._set_up(setup_of(self.params, self.source.title, show.team))
        assert self.narrator is not None
        frame, ended = self.narrator.tell(snapshot_of(show, "play_on"))
        self.audience.frame(frame)
        if ended is not None:
            self.audience.episode(ended)

    def _set_up(self, setup: Setup) -> None:
        if self.narrator is None:
            self.narrator = Narrator(setup, self.source.insight)
            self.audience.episodes([])
            self.audience.notice("")
        self.narrator.setup = setup
        self.audience.setup(setup, live=True)
