"""The shell around one sans-IO player: its connection and its clock."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass

from rcss_hat.keepaway.session import DONE, KeepawayPlayer
from rcss_hat.keepaway.whereabouts import Whereabouts
from rcss_hat.protocol.commands import Bye, Score, datagram
from rcss_hat.protocol.session import Handshake
from rcss_hat.stage.connection import Connection, ServerGone

PROTOCOL_VERSION = 11
SILENCE = 2.0
"""Seconds without a word from the server after which we ask whether it is there."""
PATIENCE = 9.0
"""Seconds of silence after which the server counts as gone (as the UT Austin players')."""
JOINS, GOODBYES, PARTING = 6, 3, 0.1
"""How often a player joins again when part of the greeting was lost; how often it then says goodbye, since that may be
lost, too, and after how many seconds each."""


@dataclass(frozen=True, slots=True)
class Patience:
    """How long a player waits for a server's greeting; all in seconds.

    Attributes
    ----------
    again : float
        Until it asks again a server that has said nothing.
    late : float
        After the server's first word, until what has not come of the greeting counts as lost.
    looking : float
        For a look at where it stands, when it was not told its number. It sees once in two cycles, which last 1.25 s
        (5 s on a patient server) while other players are still joining.
    """

    again: float = 0.25
    late: float = 0.6
    looking: float = 12.0


class PlayerClient:
    """Runs one player against a server.

    Parameters
    ----------
    player : KeepawayPlayer
    host, port : str, int
    on_message : callable, optional
        Called after every datagram that told the player more than what there is to see and what team mates say.
    """

    def __init__(
        self, player: KeepawayPlayer, host: str, port: int, on_message: Callable[[KeepawayPlayer], None] | None = None
    ) -> None:
        self.player = player
        self._host, self._port = host, port
        self.connection = Connection(host, port, player.team)
        self.on_message = on_message
        self._heard = False  # something, since the watch looked last
        self._timer: asyncio.TimerHandle | None = None
        self._waiting_in = -1  # the cycle the timer was set in
        self._over: asyncio.Future[None] | None = None

    async def connect(self, attempts: int = 60, number: int | None = None, patience: Patience = Patience()) -> None:
        """Take a place in the team and hear the server's parameters.

        Parameters
        ----------
        attempts : int
            How often to ask a server that says nothing.
        number : int, optional
            Uniform number of somebody who comes back.
        patience : Patience

        Raises
        ------
        ServerGone
            When no server answers, or the network loses its greeting again and again.
        RemoteProtocolError
            When the server refuses, or says something malformed.
        """
        self.connection.close()
        self.connection = Connection(self._host, self._port, self.player.team)
        for _ in range(JOINS):
            handshake = Handshake(self.player.team, PROTOCOL_VERSION, number)
            handshake.receive(await self.connection.open(handshake.request, attempts=attempts, pause=patience.again))
            if await self._greeted(handshake, patience.late):
                return await self._begin(handshake)
            place = handshake.place
            number = place.unum if place is not None else await self._own_number(handshake, patience.looking)
            await self._part()
        host, port = self.connection.server
        raise ServerGone(
            f"{self.player.team}: the network lost the greeting of the server at {host}:{port}, {JOINS} times"
        )

    async def _greeted(self, handshake: Handshake, late: float) -> bool:
        """Hear the server out; False when part of its greeting did not come."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(late):
                while not handshake.joined:
                    handshake.receive(await self.connection.receive())
        return handshake.joined

    async def _begin(self, handshake: Handshake) -> None:
        assert handshake.place is not None, "it has joined"
        self.player.initialised(handshake.place)
        self.connection.name = self.player.name
        for data in handshake.told():
            for answer in self.player.receive(data):
                await self.connection.send(answer)

    async def _own_number(self, handshake: Handshake, looking: float) -> int:
        """Find out by what this player sees which number the server has given it."""
        self.player.troubled = True
        where = Whereabouts(self.player.team)
        waiting = list(handshake.kept)
        try:
            async with asyncio.timeout(looking):
                while handshake.place is None:
                    for data in waiting:
                        if data.startswith(b"(think"):
                            await self.connection.send(DONE)
                        elif (unum := where.unum(data)) is not None:
                            return unum
                    waiting = [await self.connection.receive()]
                    handshake.receive(waiting[0])
                return handshake.place.unum  # it was late, not lost
        except TimeoutError:
            await self._part()
            raise ServerGone(
                f"{self.player.team}: the network lost the reply to init, and the player cannot see which number it has"
            ) from None

    async def _part(self) -> None:
        """Leave a server that is to be joined again, from a new address."""
        self.player.troubled = True
        for _ in range(GOODBYES):
            with contextlib.suppress(ServerGone):
                await self.connection.send(datagram(Bye()))
            await asyncio.sleep(PARTING)
        self.connection.close()
        self.connection = Connection(self._host, self._port, self.player.team)

    async def run(self) -> None:
        """Play until cancelled.

        Raises
        ------
        ServerGone
            When the server stopped to answer.
        RemoteProtocolError
            When it sent something malformed.
        PolicyFailed
            When a policy in Python did not answer with an action.
        """
        self._over = asyncio.get_running_loop().create_future()
        watch = asyncio.create_task(self._watch())
        self.connection.listen(self._take, self._fail)
        try:
            await self._over
        except asyncio.CancelledError:
            if self._over.done() and not self._over.cancelled():
                self._over.result()  # what went wrong comes first
            raise
        finally:
            self.connection.deaf()
            watch.cancel()
            if self._timer is not None:
                self._timer.cancel()

    def _take(self, data: bytes) -> None:
        player = self.player
        self._heard = True
        for answer in player.receive(data):
            self.connection.send_now(answer)
        if not player.synch or player.troubled:
            self._schedule()
        if player.news and self.on_message is not None:
            player.news = False
            self.on_message(player)

    def _schedule(self) -> None:
        wait = self.player.wait()
        if wait is None:
            return
        if self._timer is not None:
            if wait > 0.0 and self._waiting_in == self.player.cycle and not self.player.synch:
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
        try:
            answers = self.player.deadline()
        except Exception as error:  # the event loop, which called this, would only write it down
            return self._fail(error)
        for answer in answers:
            self.connection.send_now(answer)
        if self.player.synch:
            self._schedule()  # the answer may be lost, too

    async def _watch(self) -> None:
        """Notice a server that died without a word."""
        last_heard = time.monotonic()
        while True:
            await asyncio.sleep(SILENCE / 4)
            if self._heard:
                self._heard, last_heard = False, time.monotonic()
            silent = time.monotonic() - last_heard
            if silent > PATIENCE:
                host, port = self.connection.server
                gone = f"{self.player.name}: the server at {host}:{port} has been silent for {silent:.0f} s"
                return self._fail(ServerGone(gone))
            if silent > SILENCE:
                self.connection.send_now(datagram(Score()))

    def _fail(self, error: Exception) -> None:
        if self._over is not None and not self._over.done():
            self._over.set_exception(error)

    async def close(self) -> None:
        """Say goodbye and close."""
        with contextlib.suppress(ServerGone, AssertionError):
            for _ in range(GOODBYES if self.player.troubled else 1):
                await self.connection.send(datagram(Bye()))
        self.connection.close()
