"""Teams on a server: connect everybody, kick off, count episodes, stop, and say what happened."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable

from rcss_hat.keepaway.decision import KeeperPolicy, hold_cycles_of
from rcss_hat.keepaway.report import OUT, TAKEN, Episode, RunReport
from rcss_hat.keepaway.session import KeepawayPlayer
from rcss_hat.keepaway.task import Task
from rcss_hat.numeric.aside import aside
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.team.client import PlayerClient
from rcss_hat.team.connection import ServerGone
from rcss_hat.team.kickoff import Referee
from rcss_hat.team.refereeing import WrongServer
from rcss_hat.team.servers import ServerFailed, ServerProcess
from rcss_hat.team.trainer import TrainerClient, unless_one_fails

COMPILING = 180.0
"""Seconds a server of ours may take to answer for the first time: it may have to compile."""
KEEPERS, TAKERS = "keepers", "takers"
Progress = Callable[[int, int], None]
"""Told (episodes finished, cycle) after every episode."""


def never(cycle: int, status: int, reward: float, state: object) -> int:
    """Policy of those who are never asked."""
    raise AssertionError("takers take no decisions")


def cycles_played(player: KeepawayPlayer) -> int:
    """Cycles since a player took part; the end of an episode is heard before the cycle's sense_body."""
    last = player.episodes[-1][0] if player.episodes else 0
    return max(0, max(player.cycle, last) - player.first_cycle)


def check_keepaway(player: KeepawayPlayer) -> None:
    """Raise WrongServer when the match that has begun is not Keepaway."""
    if player.mode.startswith("kick_off_"):
        raise WrongServer(
            "the server has kicked off soccer, not Keepaway; start it with server::keepaway=1 (one older than 14 with "
            "server::keepaway_start=SECONDS too), or with server::coach=1 for --referee trainer"
        )


class Match:
    """Players in this process on one server.

    Parameters
    ----------
    task : Task
    host, port : str, int
    seed : int
        Of the players' own randomness.
    keepers : callable or None
        Policy of the keepers; None: they are not ours.
    takers : bool
        Whether the takers are ours.
    episodes : int or None
        Stop after so many; None: play until cancelled.
    progress : callable, optional

    Attributes
    ----------
    on_episode : callable or None
        Called with every finished episode, before its successor's first decision of this team's first player.
    """

    def __init__(
        self,
        task: Task,
        host: str,
        port: int,
        seed: int,
        keepers: KeeperPolicy | None,
        takers: bool = True,
        episodes: int | None = None,
        progress: Progress | None = None,
    ) -> None:
        self.task, self.host, self.port, self.seed = task, host, port, seed
        self.episodes, self.progress = episodes, progress
        self.players: list[KeepawayPlayer] = []
        if keepers is not None:
            hold_cycles = hold_cycles_of(keepers)
            for number in range(task.keepers):
                decide, ended = keepers(number)
                self.players.append(
                    KeepawayPlayer(KEEPERS, task.keepers, task.takers, seed, decide, ended, hold_cycles)
                )
        if takers:
            self.players += [KeepawayPlayer(TAKERS, task.keepers, task.takers, seed, never) for _ in range(task.takers)]
        self.clients = [PlayerClient(player, host, port) for player in self.players]
        self.started: float | None = None
        self._finished = asyncio.Event()
        self._counted = 0
        self.on_episode: Callable[[Episode], None] | None = None

    def finished_episodes(self) -> list[Episode]:
        """Episodes as the first player heard them end; the reasons are what that player believed."""
        ends = self.players[0].episodes if self.players else []
        starts = [self.players[0].first_cycle, *(end for end, _ in ends)] if ends else []
        return [
            Episode(number + 1, starts[number], end, TAKEN if taken else OUT)
            for number, (end, taken) in enumerate(ends[: self.episodes])
        ]

    @property
    def cycles(self) -> int:
        """Cycles played since the first player took part."""
        return cycles_played(self.players[0])

    @property
    def missed(self) -> int:
        """Cycles in which some player could not answer in time."""
        return sum(player.missed for player in self.players)

    async def _until_finished(self) -> None:
        await self._finished.wait()

    def _heard(self, player: KeepawayPlayer) -> None:
        check_keepaway(player)
        n = len(player.episodes)
        if n > self._counted:
            self._counted = n
            if self.on_episode is not None and (self.episodes is None or n <= self.episodes):
                self.on_episode(self.finished_episodes()[-1])
            if self.progress is not None:
                self.progress(n, cycles_played(player))
            if self.episodes is not None and n >= self.episodes:
                self._finished.set()

    async def connect(self) -> None:
        """Compile, then connect everybody in order: keepers first, for the server gives the left side to them."""
        await aside(self.players[0].prepare)
        try:
            for client in self.clients:
                await client.connect()
        except BaseException:
            for client in self.clients:
                client.connection.close()
            raise
        self.clients[0].on_message = self._heard

    async def play(
        self, kick_off: bool, server: ServerProcess | None = None, trainer: TrainerClient | None = None
    ) -> None:
        """Play until the number of episodes is reached.

        Parameters
        ----------
        kick_off : bool
            Start the match as a monitor would.
        server : ServerProcess, optional
            Watched: when it ends, so does the match.
        trainer : TrainerClient, optional
            Starts and referees the match instead of the server.

        Raises
        ------
        ServerGone, ServerFailed, WrongServer, RemoteProtocolError
            What ended the match early, naming who noticed.
        """
        tasks = [asyncio.create_task(client.run(), name=client.player.name) for client in self.clients]
        tasks.append(asyncio.create_task(self._until_finished(), name="episodes"))
        if server is not None:
            tasks.append(asyncio.create_task(server.ended(), name="server"))
        referee = Referee(self.host, self.port)
        try:
            if trainer is not None:
                await trainer.connect()
                tasks.append(asyncio.create_task(trainer.run(), name="trainer"))
                await unless_one_fails(trainer.wait_for_start(), tasks)
            elif kick_off:
                await referee.connect()
                await referee.wait_for(self.task.keepers, self.task.takers)
                if not (referee.old and self.players[0].params.number("keepaway_start") >= 0):
                    await referee.kick_off()
                await referee.leave()
            self.started = time.monotonic()
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            for client in self.clients:
                await client.close()
            referee.connection.close()
            if trainer is not None:
                trainer.close()


def _as_logged(episode: Episode, server: ServerProcess | None, trainer: TrainerClient | None) -> Episode:
    """Return an episode that a player heard end as who referees it has logged it."""
    if trainer is not None:
        return next((e for e in trainer.trainer.episodes if e.number == episode.number), episode)
    logged = server.episodes() if server is not None else []
    return next((e for e in logged if e.number == episode.number and e.end == episode.end), episode)


def refereed(
    heard: list[Episode], server: ServerProcess | None, trainer: TrainerClient | None, episodes: int | None
) -> list[Episode]:
    """Return the episodes as the referee knows them; as the players heard them where nobody else does."""
    logged = server.episodes() if server is not None and trainer is None else []
    if trainer is not None:
        logged = trainer.trainer.episodes
    logged = logged[:episodes]
    return logged if len(logged) >= len(heard) else heard


async def play(
    report: RunReport,
    task: Task,
    seed: int,
    keepers: KeeperPolicy,
    episodes: int,
    server: ServerProcess | None,
    address: tuple[str, int] | None,
    progress: Progress | None = None,
    on_episode: Callable[[Episode], None] | None = None,
    trainer: TrainerClient | None = None,
) -> None:
    """Play both teams, on a server of our own or on one that runs already, and fill a report.

    Nothing is lost when the match ends early: the report then holds all finished episodes and what went wrong.

    Parameters
    ----------
    report : RunReport
        Filled in place.
    task, seed, keepers, episodes, progress
        See `Match`.
    server : ServerProcess, optional
        Started and stopped here.
    address : (str, int), optional
        Of a running server; used when ``server`` is None.
    on_episode : callable, optional
        Called with every finished episode; its reason is the server's where the server is ours.
    trainer : TrainerClient, optional
        Referees instead of the server.
    """
    host, port = (server.host, server.port) if server is not None else address or ("127.0.0.1", 6000)
    match = Match(task, host, port, seed, keepers, True, episodes, progress)
    if on_episode is not None:
        match.on_episode = lambda episode: on_episode(_as_logged(episode, server, trainer))
    try:
        if server is not None:
            await server.start()
            await server.answers(COMPILING)
        await match.connect()
        await match.play(kick_off=True, server=server, trainer=trainer)
    except (ServerGone, ServerFailed, WrongServer, RemoteProtocolError) as error:
        report.failure = str(error)
    except asyncio.CancelledError:
        report.failure = "interrupted"
    finally:
        report.wall_s = time.monotonic() - match.started if match.started else 0.0
        report.episodes = match.finished_episodes()
        report.cycles = match.cycles
        report.missed = match.missed
        if server is not None:
            await server.stop()
        report.episodes = refereed(report.episodes, server, trainer, episodes)


async def play_team(
    report: RunReport,
    task: Task,
    seed: int,
    keepers: KeeperPolicy | None,
    episodes: int | None,
    address: tuple[str, int],
    kick_off: bool,
    progress: Progress | None = None,
) -> None:
    """Play one team on a running server: the keepers, or (``keepers`` None) the takers, and fill a report.

    The takers join when a monitor shows all keepers, for the first team to connect gets the left side.
    """
    host, port = address
    match = Match(task, host, port, seed, keepers, keepers is None, episodes, progress)
    try:
        if keepers is None:
            referee = Referee(host, port)
            await referee.connect()
            await referee.wait_for(task.keepers, 0, patience=600.0)
            await referee.leave()
        await match.connect()
        await match.play(kick_off)
    except (ServerGone, RemoteProtocolError) as error:
        report.failure = str(error)
    except asyncio.CancelledError:
        report.failure = "interrupted"
    finally:
        report.wall_s = time.monotonic() - match.started if match.started else 0.0
        report.episodes = match.finished_episodes()
        report.cycles, report.missed = match.cycles, match.missed
