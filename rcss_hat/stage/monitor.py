"""Watch who is on the field and start a match, as a monitor would; readiness is what the server shows, not a delay."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable

from rcss_hat.protocol import messages
from rcss_hat.protocol.commands import ChangeMode, DispBye, DispInit, DispStart, datagram
from rcss_hat.protocol.params import Value
from rcss_hat.protocol.session import KNOWN
from rcss_hat.stage.connection import Connection, ServerGone
from rcss_hat.stage.survey import PLAY_ON, Look, look_at

NUL = b"\0"
_PARAMETERS = b"(server_param "
KICK_OFFS, PAUSE = 10, 1.0
"""How often a match is started that does not begin, and after how many seconds each: the word may be lost."""
_KNOWN = b"(error %s)" % KNOWN.encode()
MONITOR_VERSION, OLD_VERSION = 4, 1
"""Servers of the time of 11.1 know only binary frames; all know those of version 1."""


class Monitor:
    """A monitor that looks who is there, kicks off, ends the match where that is to be, and leaves.

    A monitor slows down a server in synch mode, so it does not stay longer than it must.

    Parameters
    ----------
    host, port : str, int

    Attributes
    ----------
    old : bool
        The server is older than 14, where a monitor's ``(dispstart)`` kicks off soccer even in Keepaway mode; it
        starts Keepaway by itself when ``keepaway_start`` seconds have gone by.
    told : dict of str to Value
        The server's parameters; empty where it does not tell monitors.
    """

    def __init__(self, host: str, port: int) -> None:
        self.connection = Connection(host, port, "monitor")
        self.old = False
        self.told: dict[str, Value] = {}

    async def connect(self) -> None:
        """Connect to the server, as a monitor of an old version where it knows no other.

        Raises
        ------
        ServerGone
            When no server answers, or it takes no monitor.
        """
        host, port = self.connection.server
        reply = await self.connection.open(datagram(DispInit(MONITOR_VERSION)))
        if reply.startswith(b"(error") and not reply.startswith(_KNOWN):
            self.old = True
            self.connection.close()
            self.connection = Connection(host, port, self.connection.name)
            reply = await self.connection.open(datagram(DispInit(OLD_VERSION)))
        if reply.startswith(b"(error") and not reply.startswith(_KNOWN):
            raise ServerGone(f"monitor: the server at {host}:{port} refuses: {reply.rstrip(NUL).decode('latin-1')}")
        self._listen(reply)

    def _listen(self, data: bytes) -> Look | None:
        """Take in what the server tells; returns what a frame shows."""
        if data.startswith(_PARAMETERS):
            event = messages.parse(data)
            if isinstance(event, messages.ServerParam):
                self.told = dict(event.values)
        return look_at(data)

    async def look(self, good: Callable[[Look], bool] = lambda look: True, patience: float = 20.0) -> Look:
        """Wait for a frame that shows what is wanted; by default for any.

        Raises
        ------
        ServerGone
            When the server shows nothing, or went.
        TimeoutError
            When it does not show what is wanted.
        """
        last: Look | None = None
        try:
            async with asyncio.timeout(patience):
                while True:
                    last = self._listen(await self.connection.receive()) or last
                    if last is not None and good(last):
                        return last
        except TimeoutError:
            if last is not None:
                raise
        host, port = self.connection.server
        raise ServerGone(f"monitor: the server at {host}:{port} shows nothing (waited {patience:.0f} s)")

    async def kick_off(self) -> None:
        """Start the match, and see that it begins.

        Raises
        ------
        ServerGone
            When it does not begin, or the server went.
        """
        for _ in range(KICK_OFFS):
            await self.connection.send(datagram(DispStart()))
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(PAUSE):
                    while not self._has_begun(await self.connection.receive()):
                        pass
                    return
        host, port = self.connection.server
        raise ServerGone(f"the server at {host}:{port} does not begin the match, {KICK_OFFS} times asked")

    def _has_begun(self, data: bytes) -> bool:
        look = self._listen(data)
        return look is not None and (look.mode == PLAY_ON or look.mode.startswith("kick_off_"))

    async def end_match(self, patience: float = 5.0) -> None:
        """End the match for everybody; a server in auto mode then exits.

        Raises
        ------
        ServerGone
            When the server does not obey: it does so with ``server::coach_w_referee=1``.
        """
        await self.connection.send(datagram(ChangeMode("time_over")))
        try:
            async with asyncio.timeout(patience):
                while True:
                    reply = await self.connection.receive()
                    if b"(ok change_mode)" in reply:
                        return
                    if b"(error " in reply:
                        break
        except TimeoutError:
            pass
        host, port = self.connection.server
        raise ServerGone(
            f"monitor: the server at {host}:{port} does not let a monitor end the match; it must run with "
            "server::coach_w_referee=1"
        )

    async def leave(self) -> None:
        """Disconnect."""
        await self.connection.send(datagram(DispBye()))
        self.connection.close()
