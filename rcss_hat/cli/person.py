"""A person demonstrates, in the browser or in the terminal, in the arena or on a server in real time."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import TYPE_CHECKING

import click

from rcss_hat.cli.common import ARENA, tell_of_compilation
from rcss_hat.keepaway.report import RunReport
from rcss_hat.keepaway.task import Task

if TYPE_CHECKING:
    from rcss_hat.hat.demonstration_writer import DemonstrationWriter
    from rcss_hat.team.servers import ServerProcess
    from rcss_hat.viewer.audience import Audience, Source
    from rcss_hat.viewer.demonstration import Demonstration

ACTION_NAMES = {"hold": 0, **{f"pass{k}": k for k in range(1, 11)}}
TITLE = "demonstration"
COUNTDOWN = 3
"""Seconds to get ready in the arena."""


def parse_actions(text: str | None, keepers: int) -> tuple[int, ...]:
    """Read what the person may do, such as ``hold,pass1``; None: everything.

    Raises
    ------
    ValueError
        Naming the actions there are.
    """
    if text is None:
        return tuple(range(keepers))
    known = [name for name, action in ACTION_NAMES.items() if action < keepers]
    names = [name.strip().lower() for name in text.split(",")]
    for name in names:
        if name not in known:
            raise ValueError(f"there is no action {name!r}; with {keepers} keepers there are {', '.join(known)}")
    return tuple(ACTION_NAMES[name] for name in names)


def demonstrate_by_hand(
    report: RunReport,
    task: Task,
    stage: str | tuple[str, int],
    seed: int,
    writer: DemonstrationWriter,
    episodes: int,
    speed: float,
    actions: tuple[int, ...],
    terminal: bool,
    port: int,
    open_browser: bool,
    server: ServerProcess | None,
) -> None:
    """Let a person play until the file holds ``episodes`` episodes, or the person stops."""
    from rcss_hat.viewer.controls import KeyChannel
    from rcss_hat.viewer.demonstration import Demonstration

    demonstration = Demonstration(KeyChannel(actions), writer, episodes)
    try:
        with suppress(KeyboardInterrupt):
            if stage == ARENA:
                source = _arena(task, seed, demonstration, speed)
                asyncio.run(_show(source, demonstration, terminal, port, open_browser))
            else:
                asyncio.run(_on_server(report, task, stage, seed, demonstration, terminal, port, open_browser, server))
    finally:
        demonstration.close()
        if server is not None:
            server.clean()


def _arena(task: Task, seed: int, demonstration: Demonstration, speed: float) -> Source:
    from rcss_hat.hat.brains import EXTERNAL, fixed_brains
    from rcss_hat.hat.policy import TeamPolicy
    from rcss_hat.viewer.arena_game import ArenaGame

    brains = fixed_brains(EXTERNAL, task.keepers, seed)
    policy = TeamPolicy("person", brains, task.keepers, task.takers)
    return ArenaGame(task, seed, policy, demonstration, speed, COUNTDOWN)


class _OnceThere:
    """A source that begins when the person is there."""

    def __init__(self, source: Source, there: asyncio.Event) -> None:
        self._source, self._there = source, there

    def command(self, name: str, value: float) -> bool:
        """Pass it on."""
        return self._source.command(name, value)

    async def run(self, audience: Audience) -> None:
        """Wait, then show."""
        await self._there.wait()
        await self._source.run(audience)


async def _on_server(
    report: RunReport,
    task: Task,
    stage: str | tuple[str, int],
    seed: int,
    demonstration: Demonstration,
    terminal: bool,
    port: int,
    open_browser: bool,
    server: ServerProcess | None,
) -> None:
    from rcss_hat.team.match import play
    from rcss_hat.viewer.live import MonitorSource

    tell_of_compilation("rcss_hat.keepaway.agent")
    address = stage if isinstance(stage, tuple) else None
    host, udp_port = address or (server.host, server.port)  # type: ignore[union-attr]
    there = asyncio.Event()
    demonstration.on_arrival = there.set
    source = _OnceThere(MonitorSource(host, udp_port, demonstration.insight, TITLE, patience=180.0), there)

    async def play_once_there() -> None:
        await there.wait()
        await play(report, task, seed, demonstration, 10**9, server, address)

    playing = asyncio.create_task(play_once_there())
    showing = asyncio.create_task(_show(source, demonstration, terminal, port, open_browser))
    try:
        await asyncio.wait({playing, showing}, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for work in (showing, playing):
            work.cancel()
            with suppress(asyncio.CancelledError):
                await work
    if demonstration.finished and report.failure == "interrupted":
        report.failure = None


async def _show(source: Source, demonstration: Demonstration, terminal: bool, port: int, open_browser: bool) -> None:
    over = asyncio.Event()
    demonstration.on_finished = over.set
    if terminal:
        from rcss_hat.viewer.terminal import Terminal

        demonstration.person(True)
        screen = asyncio.create_task(Terminal(source, demonstration).run())
        await _until(over, screen)
        return
    from rcss_hat.viewer.server import serve

    async with await serve(source, demonstration, port=port, open_browser=open_browser) as viewer:
        click.echo(f"Demonstrate at {viewer.url}", err=True)
        click.echo("Play begins when the page is open. Ctrl-C ends; finished episodes are kept.", err=True)
        await _until(over, asyncio.create_task(viewer.wait()))


async def _until(over: asyncio.Event, screen: asyncio.Task[None]) -> None:
    """Wait for the end of the demonstration or of the screen, whichever comes first."""
    finished = asyncio.create_task(over.wait())
    try:
        await asyncio.wait({finished, screen}, return_when=asyncio.FIRST_COMPLETED)
        if screen.done():
            screen.result()
    finally:
        for task in (finished, screen):
            task.cancel()
        await asyncio.gather(finished, screen, return_exceptions=True)
