"""The worker processes of a server, in which games are played: started, listened to, and started anew when they end."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import msgspec

from rcss_hat.studies.journal import Event
from rcss_hat.studies.spec import Close, Enter, GameSpec, Hear, Leave, Longer, Open, Order

MAX_LINE = 2**22
"""Bytes of a line of a worker."""
PAUSE = 1.0
"""Seconds before a worker that ended is started again."""
FAREWELL = 15.0
"""Seconds that workers get to put games away."""


class Player(Protocol):
    """Whose game is played in a worker."""

    name: str

    def happened(self, event: Event) -> None:
        """Take an event of the game, without ``utc``."""

    def lost(self) -> None:
        """Take note that the worker has ended, and the game with it."""


@dataclass(slots=True, eq=False)
class _Worker:
    process: asyncio.subprocess.Process
    players: dict[str, Player]
    ready: asyncio.Event


class Pool:
    """Worker processes.

    Parameters
    ----------
    size : int
    deliver : callable
        Told (page, text) of every message for a page.
    say : callable
        Told what people who run the server should know.
    """

    def __init__(self, size: int, deliver: Callable[[int, str], None], say: Callable[[str], None]) -> None:
        self._size, self._deliver, self._say = size, deliver, say
        self._workers: list[_Worker | None] = [None] * size
        self._keepers: list[asyncio.Task[None]] = []
        self._closing = False

    async def start(self) -> None:
        """Start all workers, and wait until they are ready: the first one compiles where that was not done before."""
        await self._begin(0)
        await asyncio.gather(*(self._begin(k) for k in range(1, self._size)))

    async def _begin(self, k: int) -> None:
        begun = asyncio.Event()
        keeper = asyncio.create_task(self._keep(k, begun))
        self._keepers.append(keeper)
        ready = asyncio.create_task(begun.wait())
        await asyncio.wait({ready, keeper}, return_when=asyncio.FIRST_COMPLETED)
        ready.cancel()
        if keeper.done():
            keeper.result()
            raise RuntimeError("the processes in which games are played end as soon as they begin")

    async def close(self) -> None:
        """Let all games be put away, and end the workers."""
        self._closing = True
        for worker in filter(None, self._workers):
            assert worker.process.stdin is not None
            worker.process.stdin.close()
        if self._keepers:
            await asyncio.wait(self._keepers, timeout=FAREWELL)
        for worker in filter(None, self._workers):
            with contextlib.suppress(ProcessLookupError):
                worker.process.kill()
        if self._keepers:
            await asyncio.wait(self._keepers, timeout=FAREWELL)  # each sees its process end
        for keeper in self._keepers:
            keeper.cancel()
        await asyncio.gather(*self._keepers, return_exceptions=True)

    # -- games --------------------------------------------------------------------------------------------------------
    async def open(self, player: Player, spec: GameSpec) -> None:
        """Begin a game in the worker that has the fewest; waits for one that runs."""
        while not any(self._workers):
            await asyncio.sleep(0.1)
        worker = min(filter(None, self._workers), key=lambda w: len(w.players))
        worker.players[player.name] = player
        self._tell(worker, Open(spec))

    def enter(self, name: str, page: int) -> None:
        """Tell the game that a page has connected."""
        self._order(name, Enter(name, page))

    def leave(self, name: str, page: int) -> None:
        """Tell it that a page has gone."""
        self._order(name, Leave(name, page))

    def hear(self, name: str, page: int, text: str) -> None:
        """Tell it what a page says."""
        self._order(name, Hear(name, page, text))

    def longer(self, name: str, games: int) -> None:
        """Let more games be played: so many in all."""
        self._order(name, Longer(name, games))

    def end(self, name: str) -> None:
        """End a game."""
        self._order(name, Close(name))

    def _order(self, name: str, order: Order) -> None:
        for worker in self._workers:
            if worker is not None and name in worker.players:
                self._tell(worker, order)

    def _tell(self, worker: _Worker, order: Order) -> None:
        assert worker.process.stdin is not None
        if not worker.process.stdin.is_closing():
            worker.process.stdin.write(msgspec.json.encode(order) + b"\n")

    # -- workers ------------------------------------------------------------------------------------------------------
    async def _keep(self, k: int, begun: asyncio.Event) -> None:
        """Run a worker, and again when it ends."""
        while not self._closing:
            process = await asyncio.create_subprocess_exec(
                sys.executable, "-m", "rcss_hat.studies.worker",
                stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE, limit=MAX_LINE,
                start_new_session=True,  # Ctrl-C is the server's, which then lets the workers put games away
                env={**os.environ, "PYTHONWARNINGS": "ignore"},
            )  # fmt: skip
            worker = _Worker(process, {}, asyncio.Event())
            try:
                await self._listen(k, worker, begun)
            finally:
                self._workers[k] = None
                with contextlib.suppress(ProcessLookupError):
                    process.kill()
            await process.wait()
            players, worker.players = list(worker.players.values()), {}
            for player in players:
                player.lost()
            if self._closing or not begun.is_set():
                return
            self._say(f"A process in which games are played ended ({process.returncode}); it is started again.")
            await asyncio.sleep(PAUSE)

    async def _listen(self, k: int, worker: _Worker, begun: asyncio.Event) -> None:
        assert worker.process.stdout is not None
        while line := await worker.process.stdout.readline():
            if not line.endswith(b"\n"):
                return
            kind, rest = line[:1], line[1:]
            if kind == b"R":
                self._workers[k] = worker
                begun.set()
            elif kind == b"P":
                page, _, text = rest.rstrip(b"\n").partition(b" ")
                self._deliver(int(page), text.decode())
            elif kind == b"E":
                name, _, text = rest.partition(b" ")
                self._event(worker, name.decode(), json.loads(text))

    def _event(self, worker: _Worker, name: str, event: dict[str, Any]) -> None:
        player = worker.players.get(name)
        if player is None:
            return
        if event["event"] in ("over", "crashed"):
            del worker.players[name]
        if event["event"] == "crashed":
            self._say(f"{name}: {event['what']}")
            player.lost()
        else:
            player.happened(event)
