"""A trainer that referees Keepaway over UDP."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Coroutine, Iterable

from rcss_hat.keepaway.conditions import pace_text, physics_text
from rcss_hat.keepaway.report import INTERRUPTED, Episode, RunReport
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.errors import LocalProtocolError, RemoteProtocolError
from rcss_hat.stage.connection import Connection, ServerGone
from rcss_hat.stage.refereeing import KeepawayTrainer, WrongServer

SILENCE_BEFORE, SILENCE = 60.0, 9.0
"""Seconds without a word from the server, before and during the match, after which it counts as gone."""


class TrainerClient:
    """Runs a trainer against a server.

    Parameters
    ----------
    task : Task
    host, port : str, int
        The server's port for trainers (``coach_port``).
    seed : int
        Of the places at which episodes begin.
    on_episode : callable, optional
        Told every episode when it has ended.
    """

    def __init__(
        self, task: Task, host: str, port: int, seed: int, on_episode: Callable[[Episode], None] | None = None
    ) -> None:
        self.trainer = KeepawayTrainer(task, seed)
        self.connection = Connection(host, port, "trainer")
        self.on_episode = on_episode
        self._started = asyncio.Event()

    async def connect(self, attempts: int = 20) -> None:
        """Take the trainer's place.

        Raises
        ------
        ServerGone, WrongServer, RemoteProtocolError
            When there is no server, or it takes no trainer.
        """
        try:
            reply = await self.connection.open(self.trainer.first_datagram(), attempts=attempts)
        except ServerGone as error:
            raise ServerGone(f"{error} (old servers listen for trainers only with server::coach=1)") from None
        for answer in self.trainer.initialised(reply):
            await self.connection.send(answer)

    async def run(self) -> None:
        """Referee until cancelled.

        Raises
        ------
        ServerGone, WrongServer, RemoteProtocolError
            When the server stopped to answer, or answers what ends the match.
        """
        counted = 0
        while True:
            patience = SILENCE if self.trainer.started else SILENCE_BEFORE
            try:
                async with asyncio.timeout(patience):
                    data = await self.connection.receive()
            except TimeoutError:
                raise ServerGone(f"trainer: the server has been silent for {patience:.0f} s") from None
            try:
                answers = self.trainer.receive(data)
            except LocalProtocolError as error:
                raise WrongServer(f"the trainer cannot name a player of this match: {error}") from None
            for answer in answers:
                await self.connection.send(answer)
            if self.trainer.started:
                self._started.set()
            for episode in self.trainer.episodes[counted:]:
                counted += 1
                if self.on_episode is not None:
                    self.on_episode(episode)

    async def wait_for_start(self, patience: float = 60.0) -> None:
        """Wait until both teams are complete and the match has been started; `run` must be under way.

        Raises
        ------
        ServerGone
            When not everybody came.
        """
        try:
            async with asyncio.timeout(patience):
                await self._started.wait()
        except TimeoutError:
            task, (left, right) = self.trainer.task, self.trainer.present
            raise ServerGone(
                f"waited {patience:.0f} s for {task.keepers} keepers and {task.takers} takers; {left} and {right} came"
            ) from None

    def close(self) -> None:
        """Close the socket, which is how a trainer leaves."""
        self.connection.close()


async def unless_one_fails(waiting: Coroutine[object, object, None], tasks: Iterable[asyncio.Task[None]]) -> None:
    """Wait for something, or raise what ends one of some tasks before it has happened."""
    wanted = asyncio.create_task(waiting)
    try:
        await asyncio.wait([wanted, *tasks], return_when=asyncio.FIRST_COMPLETED)
        for task in (*tasks, wanted):
            if task.done():
                task.result()
    finally:
        wanted.cancel()
        await asyncio.gather(wanted, return_exceptions=True)


async def referee_match(
    report: RunReport,
    task: Task,
    seed: int,
    address: tuple[str, int],
    episodes: int | None,
    on_episode: Callable[[Episode], None],
    patience: float = 600.0,
) -> None:
    """Referee somebody else's players on a running server, and fill a report.

    Parameters
    ----------
    report : RunReport
        Filled in place; whatever ends the match early is its ``failure``.
    task : Task
    seed : int
        Of the places at which episodes begin.
    address : (str, int)
        Where the server listens for trainers.
    episodes : int or None
        Stop after so many; None: when cancelled.
    on_episode : callable
        Told every episode.
    patience : float
        Seconds to wait for the players.
    """
    enough = asyncio.Event()
    counted: list[Episode] = []

    def count(episode: Episode) -> None:
        if episodes is None or episode.number <= episodes:
            counted.append(episode)
            on_episode(episode)
        if episode.number == episodes:
            enough.set()

    client = TrainerClient(task, *address, seed, count)
    running: asyncio.Task[None] | None = None
    begun: float | None = None
    try:
        await client.connect()
        running = asyncio.create_task(client.run())
        await unless_one_fails(client.wait_for_start(patience), [running])
        begun = time.monotonic()
        await unless_one_fails(_event(enough), [running])
    except (ServerGone, WrongServer, RemoteProtocolError) as error:
        report.end_early(error)
    except asyncio.CancelledError:
        report.end_early(INTERRUPTED)
    finally:
        wall_s = time.monotonic() - begun if begun is not None else 0.0
        report.played(counted, client.trainer.cycle - client.trainer.begun, wall_s)
        if client.trainer.told:
            report.told(task, physics_text(client.trainer.told), pace_text(client.trainer.told))
        if running is not None:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)
        client.close()


async def _event(event: asyncio.Event) -> None:
    await event.wait()
