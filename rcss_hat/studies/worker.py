"""A process in which some participants' games are played: ``python -m rcss_hat.studies.worker``.

It is told what to do on its standard input and answers on its standard output, see `rcss_hat.studies.spec`. When the
input ends, because the server has ended by whatever means, every game is put away and the process ends.
"""

from __future__ import annotations

import asyncio
import json
import os
import sys
from typing import Any

import msgspec

from rcss_hat.hat.policy import load_policy, python_policy
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.place import ARENA, Place
from rcss_hat.stage.stages import Part, open_stage
from rcss_hat.studies.spec import Close, Enter, GameSpec, Hear, Leave, Longer, Open, Order
from rcss_hat.studies.table import Table
from rcss_hat.viewer.browser import Browser
from rcss_hat.viewer.frames import Setup
from rcss_hat.viewer.narrator import make_frame
from rcss_hat.viewer.stage_reel import snapshot_of

MAX_LINE = 2**20
"""Bytes of an order."""
FAREWELL = 10.0
"""Seconds to put games away when the server has gone."""
_orders = msgspec.json.Decoder(Order)


class Worker:
    """Plays games, and passes on between them and the server.

    Parameters
    ----------
    out : asyncio.StreamWriter
        To the server.
    """

    def __init__(self, out: asyncio.StreamWriter) -> None:
        self._out = out
        self._tables: dict[str, Table] = {}
        self._tasks: dict[str, asyncio.Task[None]] = {}
        self._senders: dict[int, asyncio.Task[None]] = {}

    async def obey(self, lines: asyncio.StreamReader) -> None:
        """Do what is told until nobody is there to tell."""
        while line := await lines.readline():
            if line.endswith(b"\n"):
                await self._do(_orders.decode(line))
        for table in self._tables.values():
            table.close()
        if self._tasks:
            await asyncio.wait(self._tasks.values(), timeout=FAREWELL)  # not for ever: the disk may be full

    async def _do(self, order: Order) -> None:
        table = self._tables.get(order.spec.participant if isinstance(order, Open) else order.participant)
        match order:
            case Open(spec):
                assert table is None
                self._open(spec)
            case Enter(participant, page) if table is not None:
                browser = Browser(self._deliver(page), participant)
                self._senders[page] = asyncio.create_task(_quietly(browser))
                table.enter(page, browser)
            case Leave(_, page):
                if page in self._senders:
                    self._senders.pop(page).cancel()
                if table is not None:
                    table.leave(page)
            case Hear(_, page, text) if table is not None:
                table.hear(page, text)
            case Longer(_, games) if table is not None:
                table.longer(games)
            case Close() if table is not None:
                table.close()

    def _open(self, spec: GameSpec) -> None:
        def emit(event: dict[str, Any]) -> None:
            self._out.write(f"E{spec.participant} {json.dumps(event)}\n".encode())

        table = self._tables[spec.participant] = Table(spec, emit)

        async def play() -> None:
            try:
                await table.run()
            except Exception as problem:  # of one game, which must not end the others'
                emit({"ms": 0, "event": "crashed", "step": spec.step, "what": f"{type(problem).__name__}: {problem}"})
                raise
            finally:
                del self._tables[spec.participant], self._tasks[spec.participant]

        self._tasks[spec.participant] = asyncio.create_task(play())

    def _deliver(self, page: int) -> Any:
        async def deliver(text: str) -> None:
            self._out.write(f"P{page} {text}\n".encode())
            await self._out.drain()

        return deliver


def _warm_up() -> None:
    """Compile or load everything that a game needs, so that nobody's pictures stop when somebody else begins."""
    task = Task()
    load_policy("hold", task.keepers, task.takers, 0).warm_up()
    policy = python_policy(lambda state, info: 0, task.keepers, task.takers, "person")
    setup, frames = Setup.from_params("", task.params()), list[Any]()
    with open_stage(Place(ARENA), task, 0, policy) as stage:
        stage.play(Part(None, 60, lambda episodes, cycle: None, lambda decision: None, frames.append))
    for frame in frames:
        json.dumps(make_frame(snapshot_of(frame), setup, 0, 0))


async def _quietly(browser: Browser) -> None:
    try:
        await browser.send()
    except ConnectionError:
        return  # nobody is there to tell


async def main() -> None:
    """Run until the standard input ends."""
    # What is printed by accident must not come between the lines for the server.
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb", buffering=0)
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    loop = asyncio.get_running_loop()
    lines = asyncio.StreamReader(limit=MAX_LINE)
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(lines), sys.stdin.buffer)
    transport, protocol = await loop.connect_write_pipe(asyncio.streams.FlowControlMixin, answers)
    out = asyncio.StreamWriter(transport, protocol, None, loop)
    await asyncio.to_thread(_warm_up)
    out.write(b"R\n")
    await Worker(out).obey(lines)


if __name__ == "__main__":
    asyncio.run(main())
