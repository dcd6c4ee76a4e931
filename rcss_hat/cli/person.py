"""A person demonstrates, in the browser or in the terminal, in the arena or on a server in real time."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from rcss_hat.stage.stages import Stage
    from rcss_hat.viewer.audience import Audience, Source
    from rcss_hat.viewer.demonstrator import Demonstrator
    from rcss_hat.viewer.room import Manner

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


@dataclass(frozen=True)
class Screen:
    """What a person plays on, and how fast."""

    speed: float
    terminal: bool
    port: int
    open_browser: bool
    manner: Manner | None = None
    public_url: str | None = None


def play_by_hand(stage: Stage, demonstrator: Demonstrator, screen: Screen) -> None:
    """Let a person play until enough episodes are recorded, or the person stops."""
    from rcss_hat.viewer.stage_game import StageGame

    try:
        if stage.waits:
            game = StageGame(stage, demonstrator, screen.speed, COUNTDOWN)
            asyncio.run(_show(game, demonstrator, screen))
        else:
            asyncio.run(_beside_server(stage, demonstrator, screen))
    except KeyboardInterrupt:
        if not demonstrator.finished:
            raise
    finally:
        demonstrator.close()


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


async def _beside_server(stage: Stage, demonstrator: Demonstrator, screen: Screen) -> None:
    """Show the server's match and play in it, from when the person is there."""
    from rcss_hat.stage.stages import Part
    from rcss_hat.viewer.live import MonitorSource

    assert stage.address is not None
    there = asyncio.Event()
    demonstrator.on_arrival = there.set
    source = _OnceThere(MonitorSource(*stage.address, demonstrator.insight, TITLE, patience=180.0), there)

    async def play_once_there() -> None:
        await there.wait()
        # Until the person has enough; that others end the match is a failure.
        await stage.run(Part(10**9, None, demonstrator.ended, demonstrator.decided))

    playing = asyncio.create_task(play_once_there())
    showing = asyncio.create_task(_show(source, demonstrator, screen))
    try:
        await asyncio.wait({playing, showing}, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for work in (showing, playing):
            work.cancel()
            with suppress(asyncio.CancelledError):
                await work
    if demonstrator.finished:
        stage.report.stopped_on_purpose()


async def _show(source: Source, demonstrator: Demonstrator, screen: Screen) -> None:
    over = asyncio.Event()
    demonstrator.on_finished = over.set
    if screen.terminal:
        from rcss_hat.viewer.terminal import Terminal

        demonstrator.person(True)
        await _until(over, asyncio.create_task(Terminal(source, demonstrator).run()))
        return
    from rcss_hat.viewer.server import serve

    served = await serve(
        source,
        demonstrator,
        port=screen.port,
        open_browser=screen.open_browser,
        manner=screen.manner,
        public_url=screen.public_url,
    )
    async with served as viewer:
        click.echo(f"Demonstrate at {viewer.url}", err=True)
        click.echo("Play begins with the start key on the page. Ctrl-C ends; finished episodes are kept.", err=True)
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
