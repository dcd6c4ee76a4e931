"""``rcss-hat watch``: look at a server, a match or a game log, in a browser or in the terminal."""

from __future__ import annotations

import asyncio
import secrets
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rcss_hat.cli.common import ARENA, FAKE, REAL, Stage, plain_errors, task_options, tell_of_compilation
from rcss_hat.keepaway.report import RunReport
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.params import Value

if TYPE_CHECKING:
    from rcss_hat.hat.policy import TeamPolicy
    from rcss_hat.viewer.audience import Source
    from rcss_hat.viewer.live import MonitorSource

LOG_SUFFIXES = (".rcg", ".rcg.gz")


class Watched(click.ParamType):
    """What can be watched: a stage, or a game log."""

    name = "watched"
    _stage = Stage(FAKE, ARENA, REAL)

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        """Show what can be given."""
        return f"{self._stage.get_metavar(param, ctx)}|FILE.rcg"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> str | tuple[str, int] | Path:
        """Return a word, (host, port), or the path of a log."""
        if isinstance(value, Path):
            return value
        if isinstance(value, str) and (value.endswith(LOG_SUFFIXES) or Path(value).is_file()):
            if not Path(value).is_file():
                self.fail(f"there is no game log {value!r}", param, ctx)
            return Path(value)
        return self._stage.convert(value, param, ctx)


@click.command()
@click.option("--on", "stage", type=Watched(), default=FAKE, show_default=True, help="What to watch.")
@click.option(
    "--keepers", default="hand", show_default=True, help="Policy in matches started here (not HOST:PORT, FILE)."
)
@click.option("--episodes", type=click.IntRange(1), default=100, show_default=True, help="Length of such a match.")
@click.option("--seed", type=click.IntRange(0), default=None, help="Of such a match (fake and arena).")
@click.option(
    "--speed",
    type=click.FloatRange(0.1, 100),
    default=1.0,
    show_default=True,
    help="Arena and log: at first; servers started here: at most 5.",
)
@click.option("--port", type=click.IntRange(0, 65535), default=0, show_default=True, help="Of the page; 0: any.")
@click.option("--open/--no-open", "open_browser", default=True, help="Open the page by itself.")
@click.option("--terminal", is_flag=True, help="Watch in this terminal instead of a browser.")
@click.option("--executable", default=None, help="The rcssserver for --on real.  [default: the one on PATH]")
@task_options
def watch(
    task: Task,
    stage: str | tuple[str, int] | Path,
    keepers: str,
    episodes: int,
    seed: int | None,
    speed: float,
    port: int,
    open_browser: bool,
    terminal: bool,
    executable: str | None,
) -> None:
    """Watch a server, a match or a game log in the browser.

    A running server is watched as a monitor would; fake, real and arena start a match to be watched. The page listens
    on this machine only, and only to who has the link with the token. Ctrl-C ends it.

    \b
    Example:
      rcss-hat watch --on localhost:6000
      rcss-hat watch --on arena --keepers hand --seed 1
      rcss-hat watch --on 20250101-keepers_0-vs-takers_0.rcg --terminal
    """
    from rcss_hat.viewer.audience import WatchError

    with plain_errors(WatchError, RuntimeError), suppress(KeyboardInterrupt):
        source, match = _source(task, stage, keepers, episodes, seed, speed, executable)
        asyncio.run(_show(source, match, port, open_browser, terminal))


def _source(
    task: Task,
    stage: str | tuple[str, int] | Path,
    keepers: str,
    episodes: int,
    seed: int | None,
    speed: float,
    executable: str | None,
) -> tuple[Source, _ServerMatch | None]:
    """Return what to show, and the match that has to be played for it."""
    from rcss_hat.cli.stages import server_pace
    from rcss_hat.viewer.live import MonitorSource
    from rcss_hat.viewer.playback import Playback

    if isinstance(stage, Path):
        from rcss_hat.viewer.recording import read_recording

        recording = read_recording(stage)
        if recording.skipped:
            click.echo(f"{recording.skipped} lines of {stage} could not be read", err=True)
        return Playback(recording, speed), None
    if isinstance(stage, tuple):
        server_pace(stage, speed)
        return MonitorSource(*stage, stay=True), None
    seed = secrets.randbelow(2**31) if seed is None else seed
    policy = _policy(keepers, task, seed)
    if stage == ARENA:
        from rcss_hat.viewer.arena_reel import ArenaReel
        from rcss_hat.viewer.values import values_of

        return Playback(ArenaReel(task, seed, policy, episodes, values_of(policy)), speed), None
    tell_of_compilation("rcss_hat.keepaway.agent")
    match = _ServerMatch(task, stage, seed, policy, episodes, executable, server_pace(stage, speed))
    return match.source, match


def _policy(keepers: str, task: Task, seed: int) -> TeamPolicy:
    from rcss_hat.hat.policy import PolicyError, load_policy

    try:
        return load_policy(keepers, task.keepers, task.takers, seed)
    except PolicyError as error:
        raise click.BadParameter(str(error), param_hint="--keepers") from error


class _ServerMatch:
    """A match on a server of our own in real time, to be watched as a monitor."""

    def __init__(
        self,
        task: Task,
        stage: str,
        seed: int,
        policy: TeamPolicy,
        episodes: int,
        executable: str | None,
        pace: dict[str, Value],
    ) -> None:
        from rcss_hat.cli.stages import own_server
        from rcss_hat.viewer.live import MonitorSource
        from rcss_hat.viewer.narrator import Insight
        from rcss_hat.viewer.values import values_of

        self.task, self.seed, self.episodes, self.policy = task, seed, episodes, policy
        self.report = RunReport(stage, policy.spec, "hand", task.size, task.field, task.vision, seed)
        server = own_server(task, seed, stage, executable, synch_mode=False, **pace)
        assert server is not None
        self.server = server
        insight = Insight(values_of(policy))
        self.keepers = insight.of(policy)
        title = f"{'rcssserver' if stage == REAL else 'fake server'}, {policy.spec}, {task.size}"
        self.source: MonitorSource = MonitorSource(
            self.server.host, self.server.port, insight, title, patience=60.0, stay=False
        )

    async def play(self) -> None:
        """Play the match to its end."""
        from rcss_hat.numeric.aside import aside
        from rcss_hat.team.match import play

        await aside(self.policy.warm_up)
        await play(self.report, self.task, self.seed, self.keepers, self.episodes, self.server, None)

    def close(self) -> None:
        """Remove what the server left behind."""
        self.server.clean()


async def _show(source: Source, match: _ServerMatch | None, port: int, open_browser: bool, terminal: bool) -> None:
    """Show a source until it ends, its match ends, or the person leaves."""
    playing = asyncio.create_task(match.play()) if match is not None else None
    try:
        if terminal:
            from rcss_hat.viewer.terminal import Terminal

            await Terminal(source).run()
        else:
            await _show_page(source, playing, port, open_browser)
    finally:
        if playing is not None:
            playing.cancel()
            with suppress(asyncio.CancelledError):
                await playing
        if match is not None:
            match.close()
    if match is not None:
        click.echo(match.report.to_text(), err=True)


async def _show_page(source: Source, playing: asyncio.Task[None] | None, port: int, open_browser: bool) -> None:
    from rcss_hat.viewer.server import serve

    async with await serve(source, port=port, open_browser=open_browser) as viewer:
        click.echo(f"Watch at {viewer.url}  (Ctrl-C ends)", err=True)
        waiting = asyncio.create_task(viewer.wait())
        try:
            await asyncio.wait({waiting, *([playing] if playing else [])}, return_when=asyncio.FIRST_COMPLETED)
            if waiting.done():
                waiting.result()
        finally:
            waiting.cancel()
