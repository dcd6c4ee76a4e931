"""``rcss-hat watch``: look at a server, a match or a game log, in a browser or in the terminal."""

from __future__ import annotations

import asyncio
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rcss_hat.cli.common import POLICIES, drawn, named_policy, packed, plain_errors, say, task_options
from rcss_hat.cli.places import Where, server_pace
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.place import FAKE, Place
from rcss_hat.stage.terms import Terms

if TYPE_CHECKING:
    from rcss_hat.keepaway.report import RunReport
    from rcss_hat.stage.stages import Part, Stage
    from rcss_hat.viewer.audience import Source

LOG_SUFFIXES = (".rcg", ".rcg.gz")


STUDY = "study"


class Watched(Where):
    """What can be watched: a place, a game log, or a trial of an experiment."""

    name = "watched"

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        """Show what can be given."""
        return f"{super().get_metavar(param, ctx)}|FILE.rcg|{STUDY}"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the place, or the path of a log."""
        if isinstance(value, Path) or value == STUDY:
            return value
        if isinstance(value, str) and (value.endswith(LOG_SUFFIXES) or Path(value).is_file()):
            if not Path(value).is_file():
                self.fail(f"there is no game log {value!r}", param, ctx)
            return Path(value)
        return super().convert(value, param, ctx)


@dataclass(frozen=True)
class Options:
    """What ``watch`` is told, beside the task."""

    watched: Place | Path | str
    trial: str | None
    keepers: str
    episodes: int
    seed: int | None
    speed: float
    port: int
    open_browser: bool
    terminal: bool
    executable: str | None


@click.command()
@click.argument("trial", required=False, metavar="[DIR[:CONDITION/NN]]")
@click.option("--on", "watched", type=Watched(), default=FAKE, show_default=True, help="What to watch.")
@click.option(
    "--keepers", default="hand", show_default=True, help=f"In matches started here (not HOST:PORT, FILE): {POLICIES}"
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
@packed(Options)
def watch(task: Task, options: Options) -> None:
    """Watch a server, a match or a game log in the browser.

    A running server is watched as a monitor would; fake, real and arena start a match to be watched. The page listens
    on this machine only, and only to who has the link with the token. Ctrl-C ends it.

    --on study watches a trial of an experiment that is running on servers: DIR is its folder.

    \b
    Example:
      rcss-hat watch --on localhost:6000
      rcss-hat watch --on arena --keepers hand --seed 1
      rcss-hat watch --on 20250101-keepers_0-vs-takers_0.rcg --terminal
      rcss-hat watch --on study results/real:no-prior-real/00
    """
    from rcss_hat.viewer.audience import WatchError
    from rcss_hat.viewer.live import MonitorSource

    if (options.watched == STUDY) != (options.trial is not None):
        raise click.UsageError("an experiment's trial is watched with: --on study DIR:CONDITION/NN")
    with plain_errors(WatchError, RuntimeError), suppress(KeyboardInterrupt), ExitStack() as opened:
        match: Match | None = None
        watched = _running(options.trial) if options.trial is not None else options.watched
        assert not isinstance(watched, str)
        if isinstance(watched, Path):
            source: Source = _recorded(watched, options.speed)
        elif watched.address:
            server_pace(watched, options.speed)
            source = MonitorSource(*watched.address, stay=True)
        else:
            source, match = _match(task, watched, options, opened)
        asyncio.run(_show(source, match, options))
        if match is not None:
            click.echo(match.report.to_text(), err=True)


def _running(text: str) -> Place:
    """Return the server that a trial of an experiment is being played on."""
    from rcss_hat.experiments.venue import NotRunning, running_match

    folder, colon, trial = text.rpartition(":")
    if not colon or not Path(folder).is_dir():
        folder, trial = text, ""
    try:
        name, place = running_match(Path(folder), trial)
    except NotRunning as problem:
        raise click.UsageError(str(problem)) from problem
    say(f"{name} is played at {place}; while it is watched it goes more slowly")
    return place


def _recorded(path: Path, speed: float) -> Source:
    from rcss_hat.viewer.playback import Playback
    from rcss_hat.viewer.recording import read_recording

    recording = read_recording(path)
    if recording.cut:
        say(f"{path}: {recording.cut}; its {len(recording.scenes)} frames up to there are shown")
    if recording.skipped:
        say(f"{recording.skipped} line{'s' * (recording.skipped > 1)} of {path} could not be read")
    return Playback(recording, speed)


@dataclass(frozen=True)
class Match:
    """A match that is played while it is watched."""

    stage: Stage
    part: Part

    @property
    def report(self) -> RunReport:
        """What happened in it."""
        return self.stage.report

    async def play(self) -> None:
        """Play it to its end."""
        await self.stage.run(self.part)


def _match(task: Task, place: Place, options: Options, opened: ExitStack) -> tuple[Source, Match | None]:
    """Return what shows a match of ours, and the match where showing it does not play it."""
    from rcss_hat.stage.stages import Part, open_stage
    from rcss_hat.viewer.live import MonitorSource
    from rcss_hat.viewer.narrator import Insight
    from rcss_hat.viewer.playback import Playback
    from rcss_hat.viewer.stage_reel import StageReel
    from rcss_hat.viewer.values import values_of

    seed = drawn(options.seed)
    policy = named_policy(options.keepers, task, seed, "--keepers")
    terms = Terms(say=say, pace=server_pace(place, options.speed))
    stage = opened.enter_context(open_stage(replace(place, executable=options.executable), task, seed, policy, terms))
    if stage.waits:  # played ahead of the picture, which can be stopped and sought
        return Playback(StageReel(stage, options.episodes, values_of(policy)), options.speed), None
    assert stage.address is not None
    insight = Insight(values_of(policy))
    title = f"{place.title}, {policy.spec}, {task.size}"
    source = MonitorSource(*stage.address, insight, title, patience=60.0, stay=False)
    return source, Match(stage, Part(options.episodes, on_decision=insight.decided))


async def _show(source: Source, match: Match | None, options: Options) -> None:
    """Show a source until it ends, its match ends, or the person leaves."""
    playing = asyncio.create_task(match.play()) if match is not None else None
    try:
        if options.terminal:
            from rcss_hat.viewer.terminal import Terminal

            await Terminal(source).run()
        else:
            await _show_page(source, playing, options)
    finally:
        if playing is not None:
            playing.cancel()
            with suppress(asyncio.CancelledError):
                await playing


async def _show_page(source: Source, playing: asyncio.Task[None] | None, options: Options) -> None:
    from rcss_hat.viewer.server import serve

    async with await serve(source, port=options.port, open_browser=options.open_browser) as viewer:
        click.echo(f"Watch at {viewer.url}  (Ctrl-C ends)", err=True)
        waiting = asyncio.create_task(viewer.wait())
        try:
            await asyncio.wait({waiting, *([playing] if playing else [])}, return_when=asyncio.FIRST_COMPLETED)
            if waiting.done():
                waiting.result()
        finally:
            waiting.cancel()
