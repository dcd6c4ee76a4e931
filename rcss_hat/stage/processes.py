"""The same match with one process per player, as the original players run."""

from __future__ import annotations

import asyncio
import contextlib
import multiprocessing
import os
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from multiprocessing.connection import Connection as Pipe
from typing import Any, NamedTuple

from rcss_hat.hat.policy import TeamPolicy, load_policy
from rcss_hat.keepaway.decision import PolicyFailed
from rcss_hat.keepaway.endings import Endings, Evidence, Span
from rcss_hat.keepaway.session import KeepawayPlayer
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.protocol.params import Value
from rcss_hat.stage.client import PlayerClient
from rcss_hat.stage.connection import ServerGone
from rcss_hat.stage.crew import OnHeard, Seat
from rcss_hat.stage.joining import take_place
from rcss_hat.stage.survey import KEEPERS, TAKERS, WrongServer
from rcss_hat.system.workers import end_with

PATIENCE = 120.0
"""Seconds for a process to import, compile and connect."""
PARTING = 2.0
"""Seconds for a process to say goodbye and end."""
EVERY, EVERY_S = 100, 1.0
"""Cycles, and seconds, after which a player's process tells how far it is: slow cycles are no standstill."""
_DIED = "died"


class PlayerDied(ServerGone):
    """A player's process ended by itself."""


class News(NamedTuple):
    """What a player's process tells the mirror of him."""

    told: dict[str, Value] | None
    mode: str
    stopped_by: str
    first_cycle: int
    cycle: int
    missed: int
    known: int
    ends: list[tuple[int, bool]]
    evidence: Evidence


@dataclass(slots=True)
class Mirror:
    """What a player in another process has heard."""

    team: str
    told: dict[str, Value] = field(default_factory=dict)
    mode: str = ""
    stopped_by: str = ""
    first_cycle: int = 0
    cycle: int = 0
    missed: int = 0
    episodes: list[tuple[int, bool]] = field(default_factory=list)
    evidence: Evidence = ([], [])

    def take(self, news: News) -> None:
        """Take what is new: parameters where there are any, and the ends of episodes from number ``known`` on."""
        self.evidence = news.evidence
        self.told = self.told if news.told is None else news.told
        self.mode, self.stopped_by, self.missed = news.mode, news.stopped_by, news.missed
        self.first_cycle, self.cycle = news.first_cycle, news.cycle
        self.episodes[news.known :] = news.ends


def _is_news(mirror: Mirror | None, player: KeepawayPlayer) -> bool:
    """Tell whether something is worth a word to the parent: more than that another cycle has begun."""
    return (
        mirror is None
        or len(player.episodes) > len(mirror.episodes)
        or player.endings.evidence() != mirror.evidence
        or (player.mode, player.stopped_by) != (mirror.mode, mirror.stopped_by)
        or player.cycle - mirror.cycle >= EVERY
    )


def _agreed(mirrored: list[tuple[int, bool]], heard: list[tuple[int, bool]]) -> int:
    """From where on a mirror's list of ends is out of date: one that was late is filed in its place."""
    if mirrored == heard[: len(mirrored)]:
        return len(mirrored)
    return next(k for k, (old, new) in enumerate(zip(mirrored, heard, strict=False)) if old != new)


# --- in a player's process --------------------------------------------------------------------------------------------
async def _orders(pipe: Pipe) -> asyncio.Queue[Any]:
    """Return a queue of what the parent says; None when it says no more, because it is gone."""
    loop = asyncio.get_running_loop()
    queue: asyncio.Queue[Any] = asyncio.Queue()

    def listen() -> None:
        try:
            while True:
                loop.call_soon_threadsafe(queue.put_nowait, pipe.recv())
        except (EOFError, OSError, RuntimeError):
            if not loop.is_closed():
                loop.call_soon_threadsafe(queue.put_nowait, None)

    threading.Thread(target=listen, daemon=True).start()
    return queue


async def _live(pipe: Pipe, player: KeepawayPlayer, host: str, port: int, seat: Seat) -> None:
    """Do what the parent says until it says to leave, or is gone."""
    orders = await _orders(pipe)
    client = PlayerClient(player, host, port)
    pipe.send(("ready",))
    playing: asyncio.Task[None] | None = None
    ordered = asyncio.create_task(orders.get())
    try:
        while True:
            await asyncio.wait({ordered, playing} if playing else {ordered}, return_when=asyncio.FIRST_COMPLETED)
            if playing is not None and playing.done():
                return playing.result()
            order = ordered.result()
            if order is None or order[0] == "leave":
                return None
            if order[0] == "take":
                await take_place(client, host, port, seat, order[1])
                pipe.send(("taken", player.told))
            else:
                client.on_message = _reporter(pipe)
                playing = asyncio.create_task(client.run())
            ordered = asyncio.create_task(orders.get())
    finally:
        if playing is not None:
            playing.cancel()
            await asyncio.gather(playing, return_exceptions=True)
        await client.close()


def _reporter(pipe: Pipe, clock: Callable[[], float] = time.monotonic) -> Callable[[KeepawayPlayer], None]:
    """Return what tells the parent's mirror of a player."""
    mirror: Mirror | None = None
    told_at = clock()

    def report(player: KeepawayPlayer) -> None:
        nonlocal mirror, told_at
        now = clock()
        if now - told_at < EVERY_S and not _is_news(mirror, player):
            return
        told_at = now
        known = 0 if mirror is None else _agreed(mirror.episodes, player.episodes)
        told = player.told if mirror is None else None
        news = News(
            told, player.mode, player.stopped_by, player.first_cycle, player.cycle, player.missed, known,
            player.episodes[known:], player.endings.evidence(),
        )  # fmt: skip
        mirror = mirror or Mirror(player.team)
        mirror.take(news)
        pipe.send(("heard", news))

    return report


def _run_player(pipe: Pipe, task: Task, host: str, port: int, seed: int, policy: str, seat: Seat) -> None:
    """Body of a player's process."""
    end_with(os.getppid())
    side, number = seat
    if side == 0:
        team = load_policy(policy, task.keepers, task.takers, seed, task)
        team.warm_up()
        decide, ended = team(number - 1)
        player = KeepawayPlayer(KEEPERS, task.keepers, task.takers, seed, decide, ended, team.hold_cycles)
    else:
        player = KeepawayPlayer(TAKERS, task.keepers, task.takers, seed, None)
    player.prepare()
    with contextlib.suppress(KeyboardInterrupt, BrokenPipeError):  # the parent has been told to stop, or is gone
        try:
            asyncio.run(_live(pipe, player, host, port, seat))
        except WrongServer as error:
            pipe.send(("refused", str(error)))
        except (ServerGone, RemoteProtocolError, PolicyFailed) as error:
            pipe.send(("failed", str(error)))


# --- in the parent's --------------------------------------------------------------------------------------------------
class ProcessCrew:
    """Players in processes of their own; they end when this one does.

    Parameters
    ----------
    task : Task
    host, port : str, int
    seed : int
    policy : TeamPolicy
        Of the keepers; every process loads it again.
    """

    def __init__(self, task: Task, host: str, port: int, seed: int, policy: TeamPolicy) -> None:
        self.seats: list[Seat] = [(0, k + 1) for k in range(task.keepers)] + [(1, k + 1) for k in range(task.takers)]
        self.mirrors = [Mirror((KEEPERS, TAKERS)[side]) for side, _ in self.seats]
        self.first = Mirror(KEEPERS)
        self.endings = Endings()
        context = multiprocessing.get_context("spawn")
        self._pipes: list[Pipe] = []
        self._processes: list[Any] = []
        for seat in self.seats:
            ours, theirs = context.Pipe()
            arguments = (theirs, task, host, port, seed, policy.spec, seat)
            process = context.Process(target=_run_player, args=arguments, daemon=True)
            process.start()
            theirs.close()
            self._pipes.append(ours)
            self._processes.append(process)

    @property
    def missed(self) -> int:
        """Cycles in which some player could not answer in time."""
        return sum(mirror.missed for mirror in self.mirrors)

    def unheard(self) -> list[Span]:
        """Between which cycles an episode ended that nobody was told of."""
        for mirror in self.mirrors:
            self.endings.learn(mirror.evidence)
        return self.endings.unheard()

    def learn(self, k: int) -> None:
        """Let the mirror of the first player know what that of player ``k`` has taken; of ends, from anybody."""
        first, mirror = self.first, self.mirrors[k]
        if k == 0:
            first.told, first.mode, first.stopped_by = mirror.told, mirror.mode, mirror.stopped_by
            first.first_cycle, first.cycle = mirror.first_cycle, mirror.cycle
        if len(mirror.episodes) != len(first.episodes) or k == 0:
            for end, taken in mirror.episodes:
                self.endings.add(end, taken)
            first.episodes = [(end, self.endings.taken(end)) for end in self.endings.cycles]

    async def prepare(self) -> None:
        """Wait until everybody has compiled."""
        for k in range(len(self.seats)):
            await self._word(k, PATIENCE)

    async def take(self, k: int, known: bool) -> None:
        """Let player ``k`` take its seat."""
        self._pipes[k].send(("take", known))
        self.mirrors[k].told = (await self._word(k, PATIENCE))[1]
        self.learn(k)

    async def _word(self, k: int, patience: float | None) -> tuple[Any, ...]:
        """Wait for the next word of a player."""
        try:
            there = await asyncio.to_thread(self._pipes[k].poll, patience)
            message: tuple[Any, ...] = self._pipes[k].recv() if there else (_DIED, f"silent for {patience:.0f} s")
        except (EOFError, OSError):
            self._processes[k].join(1.0)
            message = (_DIED, f"exit code {self._processes[k].exitcode}")
        if message[0] == _DIED:
            raise PlayerDied(f"the process of player {k + 1} died ({message[1]})")
        if message[0] == "refused":
            raise WrongServer(str(message[1]))
        if message[0] == "failed":
            raise ServerGone(str(message[1]))
        return message

    def start(self, on_heard: OnHeard) -> list[asyncio.Task[None]]:
        """Let everybody play."""
        for pipe in self._pipes:
            pipe.send(("play",))
        return [asyncio.create_task(self._follow(k, on_heard), name=f"player {k + 1}") for k in range(len(self.seats))]

    async def _follow(self, k: int, on_heard: OnHeard) -> None:
        """Keep a mirror up to date."""
        mirror = self.mirrors[k]
        while True:
            try:
                message = await self._word(k, 0.5)
            except PlayerDied:
                if self._processes[k].is_alive():
                    continue  # it only had nothing to say
                raise
            mirror.take(message[1])
            self.learn(k)
            on_heard(self.first)

    async def leave(self) -> None:
        """Let everybody say goodbye, and end the processes."""
        for pipe in self._pipes:
            try:
                pipe.send(("leave",))
            except OSError:
                continue
        for process in self._processes:
            await asyncio.to_thread(process.join, PARTING)
            if process.is_alive():
                process.terminate()
        for process in self._processes:
            process.join(PARTING)
