"""Teams on a server: see who is there, connect everybody, kick off, count episodes, stop, and say what happened."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable

from rcss_hat.keepaway.decision import KeeperPolicy, PolicyFailed
from rcss_hat.keepaway.endings import Span
from rcss_hat.keepaway.report import INTERRUPTED, Episode, RunReport
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.stage.connection import ServerGone
from rcss_hat.stage.crew import Crew, LocalCrew
from rcss_hat.stage.gathering import Gathering
from rcss_hat.stage.monitor import Monitor
from rcss_hat.stage.place import Address
from rcss_hat.stage.servers import ServerFailed, ServerProcess
from rcss_hat.stage.stoppage import MatchOver, check_keepaway, stopped
from rcss_hat.stage.survey import (
    BEFORE_KICK_OFF,
    WrongServer,
)
from rcss_hat.stage.tally import NOT_YET, Heard, Tally
from rcss_hat.stage.terms import Terms, reminding
from rcss_hat.stage.trainer import TrainerClient, unless_one_fails

COMPILING = 180.0
"""Seconds a server of ours may take to answer for the first time: it may have to compile."""
FOR_EVERYBODY, FOR_KICK_OFF = 60.0, 600.0
"""Seconds to wait for everybody: of who kicks off, and of who does not."""
STANDSTILL, GLANCE = 30.0, 1.0
"""Seconds without a cycle after which a match counts as dead; seconds between two looks at a team that is not ours."""
OnEpisode = Callable[[Episode], None]
FAILURES = (ServerGone, ServerFailed, WrongServer, RemoteProtocolError, PolicyFailed)
"""What ends a match early."""


class Match:
    """Players of ours on one server.

    Parameters
    ----------
    task : Task
    address : (str, int)
        Host and port.
    seed : int
        Of the players' own randomness.
    keepers : callable or None
        Policy of the keepers; None: they are not ours.
    takers : bool
        Whether the takers are ours.
    episodes : int or None
        Stop after so many; None: play until cancelled.
    terms : Terms, optional
    crew : Crew, optional
        Who plays, instead of players in this process.

    Attributes
    ----------
    gathering : Gathering
        Knows the server, and what it plays.
    on_episode : callable or None
        Called with every finished episode, before its successor's first decision of this team's first player.
    """

    def __init__(
        self,
        task: Task,
        address: Address,
        seed: int,
        keepers: KeeperPolicy | None,
        takers: bool = True,
        episodes: int | None = None,
        terms: Terms | None = None,
        crew: Crew | None = None,
    ) -> None:
        self.address, self.episodes = address, episodes
        self.crew: Crew = crew or LocalCrew(task, *address, seed, keepers, takers, terms.orders if terms else None)
        self.started: float | None = None
        self.ended: float | None = None
        self.on_episode: OnEpisode | None = None
        self._tally = Tally(self.crew.first, episodes)
        self.gathering = Gathering(self.crew, task, *address, terms or Terms())
        self._finished = asyncio.Event()
        self._counted = 0
        self._last_complete = 0

    # -- what happened ------------------------------------------------------------------------------------------------
    def finished_episodes(self) -> list[Episode]:
        """Episodes as the first player heard them end; the reasons are what that player believed."""
        return self._tally.episodes()

    @property
    def cycles(self) -> int:
        """Cycles played since the first episode began."""
        return self._tally.cycles

    @property
    def running_since(self) -> int | None:
        """Cycle in which the running episode began, the first player having heard of it; None while none counts."""
        return self._tally.running_since

    @property
    def missed(self) -> int:
        """Cycles in which some player could not answer in time."""
        return self.crew.missed

    def unheard(self) -> list[Span]:
        """Where, within the episodes that count, one ended without a word to any of our players."""
        counted = self.finished_episodes()
        return [span for span in self.crew.unheard() if any(_holds(episode, span) for episode in counted)]

    @property
    def wall_s(self) -> float:
        """Seconds of play."""
        if self.started is None:
            return 0.0
        return (time.monotonic() if self.ended is None else self.ended) - self.started

    def _heard(self, player: Heard) -> None:
        check_keepaway(player)
        self.gathering.agree(player.told)  # an old server tells only players
        n = self._tally.finished
        if n > self._counted:
            self._counted = n
            if self.on_episode is not None and (self.episodes is None or n <= self.episodes):
                self.on_episode(self.finished_episodes()[-1])
            if self.episodes is not None and n >= self.episodes:
                self._finished.set()
        if player.stopped_by and self._tally.begun and not self._finished.is_set():
            raise stopped(player, self.gathering.where)

    async def connect(self, refereed: bool = False) -> None:
        """Compile, look who is on the server, then connect everybody in order.

        Parameters
        ----------
        refereed : bool
            By a trainer of ours, instead of the server.

        Raises
        ------
        WrongServer
            When our players cannot play there; says what would be right.
        ServerGone, RemoteProtocolError
            When no server answers, or it refuses somebody.
        """
        self.gathering.refereed = refereed
        await self.crew.prepare()
        try:
            await self.gathering.join()
        except BaseException:
            await self._leave()
            raise
        if not self.gathering.untouched:
            self._tally.after = NOT_YET  # what was going on is nothing of ours

    # -- playing ------------------------------------------------------------------------------------------------------
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
        tasks = [*self.crew.start(self._heard), asyncio.create_task(self._until_finished(), name="episodes")]
        if server is not None:
            tasks.append(asyncio.create_task(server.ended(), name="server"))
        try:
            if trainer is not None:
                await trainer.connect()
                tasks.append(asyncio.create_task(trainer.run(), name="trainer"))
                await unless_one_fails(trainer.wait_for_start(), tasks)
                self._tally.start = trainer.trainer.start
                await self.gathering.monitor.leave()
            else:
                await unless_one_fails(self._begin(kick_off), tasks)
            self.started = time.monotonic()
            tasks.append(asyncio.create_task(self._watch_clock(), name="clock"))
            if not all(self.gathering.ours):
                tasks.append(asyncio.create_task(self._watch_others(), name="others"))
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        finally:
            self.ended = time.monotonic()
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            try:
                await self._end_for_all()
            finally:
                await self._leave()
                if trainer is not None:
                    trainer.close()

    async def _end_for_all(self) -> None:
        """End the match where that is ours to do, before we leave: without us no episode is to be played or logged."""
        if not (self.gathering.terms.ends_match and self._finished.is_set()):
            return
        monitor = Monitor(*self.address)
        try:
            await monitor.connect()
            await monitor.end_match()
        finally:
            monitor.connection.close()

    async def _leave(self) -> None:
        await self.crew.leave()
        self.gathering.monitor.connection.close()

    async def _until_finished(self) -> None:
        await self._finished.wait()

    async def _begin(self, kick_off: bool) -> None:
        """Wait until everybody is there, and nobody else; start the match where that is ours to do; leave.

        A monitor slows down a server in synch mode, so it does not stay longer than it must.
        """
        look = await self.gathering.everybody(FOR_EVERYBODY if kick_off else FOR_KICK_OFF)
        if self._tally.after is not None or look.mode != BEFORE_KICK_OFF:
            self._tally.after = look.cycle
        self._last_complete = look.cycle
        starts_itself = self.gathering.monitor.old and float(self.gathering.told.get("keepaway_start", -1)) >= 0
        if kick_off and look.mode != "play_on" and not starts_itself:
            await self.gathering.monitor.kick_off()
        await self.gathering.monitor.leave()

    async def _watch_clock(self) -> None:
        """Notice a server that answers, but does not go on."""
        step = float(self.gathering.told.get("simulator_step", 100)) / 1000.0
        patience = max(STANDSTILL, 10.0 * step)
        while True:
            cycle = self.crew.first.cycle
            await asyncio.sleep(patience)
            if self.crew.first.mode == BEFORE_KICK_OFF:
                self.gathering.terms.say(f"waiting for the kick-off at {self.gathering.where} (--kick-off) ...")
            elif self.crew.first.cycle == cycle:
                where = self.gathering.where
                raise ServerGone(f"the server at {where} stands still in cycle {cycle} for {patience:.0f} s")

    async def _watch_others(self) -> None:
        """Notice that the team that is not ours is not complete any more; episodes since the last look do not count."""
        task, where = self.gathering.task, self.gathering.where
        theirs, size = (1, task.takers) if self.gathering.ours[0] else (0, task.keepers)
        while True:
            await asyncio.sleep(GLANCE)
            monitor = Monitor(*self.address)
            try:
                await monitor.connect()
                look = await monitor.look()
                await monitor.leave()
            finally:
                monitor.connection.close()
            there = look.counts[theirs]
            if there != size:
                self._tally.until = self._last_complete
                name = ("keepers", "takers")[theirs]
                raise MatchOver(
                    f"{there} of {size} {name} are left at {where} (cycle {look.cycle}); episodes count up to cycle "
                    f"{self._last_complete}, when all were there"
                )
            self._last_complete = look.cycle


def _holds(episode: Episode, span: Span) -> bool:
    """Tell whether what happened between two cycles may have happened during an episode."""
    return episode.start < span[1] and span[0] < episode.end


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


async def play_match(
    report: RunReport,
    match: Match,
    server: ServerProcess | None = None,
    trainer: TrainerClient | None = None,
    kick_off: bool = True,
    on_episode: OnEpisode | None = None,
) -> None:
    """Play a match to its end and fill a report; what ends it early is the report's failure.

    Nothing is lost when the match ends early: the report then holds all finished episodes and what went wrong.

    Parameters
    ----------
    report : RunReport
        Filled in place.
    match : Match
    server : ServerProcess, optional
        Started and stopped here; without one the match is on a running server.
    trainer : TrainerClient, optional
        Referees instead of the server.
    kick_off : bool
        Start the match as a monitor would.
    on_episode : callable, optional
        Called with every finished episode; its reason is the server's where the server is ours.
    """
    if on_episode is not None:
        match.on_episode = lambda episode: on_episode(_as_logged(episode, server, trainer))
    watched: list[asyncio.Task[None]] = []
    try:
        if server is not None:
            await server.start()
            async with reminding(match.gathering.terms.say, lambda: "waiting for the server to start ..."):
                await server.answers(COMPILING)
            watched.append(asyncio.create_task(server.ended()))
        match.gathering.on_agreed = report.told
        match.gathering.led = not kick_off
        await unless_one_fails(match.connect(trainer is not None), watched)
        report.refereed(by_trainer=match.gathering.refereed)
        await match.play(kick_off, server, trainer)
    except MatchOver as error:
        match.gathering.terms.say(str(error))
        report.end_early(error if match.episodes is not None else INTERRUPTED)
    except FAILURES as error:
        report.end_early(error)
    except asyncio.CancelledError:
        report.end_early(INTERRUPTED)
    finally:
        heard = match.finished_episodes()
        for task in watched:
            task.cancel()
        await asyncio.gather(*watched, return_exceptions=True)
        if server is not None:
            await server.stop()
            report.server_seed = server.random_seed
        elif trainer is None and (missing := match.unheard()):
            heard = [episode for episode in heard if not any(_holds(episode, span) for span in missing)]
            report.not_counted(len(missing))
        report.played(refereed(heard, server, trainer, match.episodes), match.cycles, match.wall_s, match.missed)
