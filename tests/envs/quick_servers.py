"""Fake servers in a thread of the tests' process, without the seconds that a process of its own takes to start."""

from __future__ import annotations

import asyncio
import contextlib

from serving import Served, serving

from rcss_hat.keepaway.report import Episode
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.servers import ServerFailed


class QuickServer:
    """What a match wants of a `rcss_hat.stage.servers.ServerProcess`."""

    running: list[QuickServer] = []  # noqa: RUF012 (the test's own)

    def __init__(self, task: Task, seed: int | None) -> None:
        self._stack = contextlib.ExitStack()
        self._served: Served = self._stack.enter_context(serving(task, seed))
        self.host, self.port = self._served.host, self._served.port
        self.random_seed = None if seed is None else str(seed)
        self._died = asyncio.Event()
        self._loop: asyncio.AbstractEventLoop | None = None
        self.running.append(self)

    async def start(self) -> None:
        self._loop = asyncio.get_running_loop()

    async def answers(self, patience: float) -> None:
        pass

    async def ended(self) -> None:
        await self._died.wait()
        raise ServerFailed("the server ended with exit code -9: ")

    def die(self) -> None:
        assert self._loop is not None
        self._loop.call_soon_threadsafe(self._died.set)

    def episodes(self) -> list[Episode]:
        return self._served.episodes()

    async def stop(self) -> None:
        self._stack.close()

    async def __aenter__(self) -> QuickServer:
        await self.start()
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.stop()

    def clean(self) -> None:
        self._stack.close()
        if self in self.running:
            self.running.remove(self)
