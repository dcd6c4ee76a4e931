"""The shell around one sans-IO player: its connection and its clock."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Callable

from rcss_hat.keepaway.session import KeepawayPlayer
from rcss_hat.protocol import messages
from rcss_hat.protocol.commands import Bye, Init, Score, datagram
from rcss_hat.team.connection import Connection, ServerGone

PROTOCOL_VERSION = 11
SILENCE = 2.0
"""Seconds without a word from the server after which we ask whether it is there."""
PATIENCE = 9.0
"""Seconds of silence after which the server counts as gone (as the UT Austin players')."""


class PlayerClient:
    """Runs one player against a server.

    Parameters
    ----------
    player : KeepawayPlayer
    host, port : str, int
    on_message : callable, optional
        Called after every datagram the player took; for progress.
    """

    def __init__(
        self, player: KeepawayPlayer, host: str, port: int, on_message: Callable[[KeepawayPlayer], None] | None = None
    ) -> None:
        self.player = player
        self.connection = Connection(host, port, player.team)
        self.on_message = on_message
        self._last_heard = time.monotonic()
        self._timer: asyncio.TimerHandle | None = None
        self._waiting_in = -1  # the cycle the timer was set in
        self._failure: BaseException | None = None
        self._main: asyncio.Task[None] | None = None

    async def connect(self, attempts: int = 60) -> None:
        """Initialise and read the parameters the server sends with its reply."""
        first = datagram(Init(self.player.team, PROTOCOL_VERSION))
        reply = await self.connection.open(first, attempts=attempts)
        self.player.initialised(messages.parse(reply))
        self.connection.name = self.player.name

    async def run(self) -> None:
        """Play until cancelled.

        Raises
        ------
        ServerGone
            When the server stopped to answer.
        RemoteProtocolError
            When it sent something malformed.
        """
        self._main = asyncio.current_task()
        watch = asyncio.create_task(self._watch())
        try:
            await self._play()
        except asyncio.CancelledError:
            if self._failure is not None:
                raise self._failure from None
            raise
        finally:
            watch.cancel()
            if self._timer is not None:
                self._timer.cancel()

    async def _play(self) -> None:
        player, connection = self.player, self.connection
        while True:
            data = await connection.receive()
            self._last_heard = time.monotonic()
            for answer in player.receive(data):
                await connection.send(answer)
            if not player.synch:
                self._schedule()
            if self.on_message is not None:
                self.on_message(player)

    def _schedule(self) -> None:
        wait = self.player.wait()
        if wait is None:
            return
        if self._timer is not None:
            if wait > 0.0 and self._waiting_in == self.player.cycle:
                return  # another message of the cycle does not put it off
            self._timer.cancel()
            self._timer = None
        if wait <= 0.0:
            self._decide()
        else:
            self._waiting_in = self.player.cycle
            self._timer = asyncio.get_running_loop().call_later(wait, self._decide)

    def _decide(self) -> None:
        self._timer = None
        for answer in self.player.deadline():
            self.connection.send_now(answer)

    async def _watch(self) -> None:
        """Notice a server that died without a word."""
        while True:
            await asyncio.sleep(SILENCE / 4)
            silent = time.monotonic() - self._last_heard
            try:
                if silent > PATIENCE:
                    host, port = self.connection.server
                    raise ServerGone(
                        f"{self.player.name}: the server at {host}:{port} has been silent for {silent:.0f} s"
                    )
                if silent > SILENCE:
                    await self.connection.send(datagram(Score()))
            except ServerGone as error:
                self._failure = error
                if self._main is not None:
                    self._main.cancel()
                return

    async def close(self) -> None:
        """Say goodbye and close."""
        with contextlib.suppress(ServerGone, AssertionError):
            await self.connection.send(datagram(Bye()))
        self.connection.close()
