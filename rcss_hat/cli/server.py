"""``rcss-hat server``: a server with Keepaway options, real or fake."""

from __future__ import annotations

import asyncio
import sys
from dataclasses import dataclass
from pathlib import Path

import click

from rcss_hat.cli.common import SERVER, TRAINER, Target, fail, packed, plain_errors, task_options
from rcss_hat.cli.places import server_pace
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.place import FAKE, Place


@dataclass(frozen=True)
class Options:
    """What ``server`` is told, beside the task."""

    real: bool
    executable: str | None
    port: int
    seed: int | None
    folder: Path
    real_time: bool
    speed: float
    referee: str


@click.command()
@click.option(
    "--real/--fake", "real", default=False, help="An rcssserver executable, or the stand-in.  [default: fake]"
)
@click.option("--executable", default=None, help="The rcssserver to start.  [default: the one on PATH]")
@click.option("--port", type=click.IntRange(1, 65533), default=6000, show_default=True)
@click.option("--seed", type=click.IntRange(0), default=None, help="Of the fake server.")
@click.option("--folder", type=Target(folder=True), default=Path(), help="Where logs go.")
@click.option("--real-time", is_flag=True, help="100 ms cycles instead of synch mode.")
@click.option("--speed", type=click.FloatRange(0.1, 5), default=1.0, help="With --real-time: times real time.")
@click.option(
    "--referee",
    type=click.Choice([SERVER, TRAINER]),
    default=SERVER,
    show_default=True,
    help="Who referees: trainer leaves it to one who connects ('rcss-hat referee').",
)
@task_options
@packed(Options)
def server(task: Task, options: Options) -> None:
    """Run a real or fake rcssserver with Keepaway options until Ctrl-C.

    \b
    Example:
      rcss-hat server --fake --port 6000 --seed 1
      rcss-hat server --real --executable ./rcssserver --real-time
    """
    from rcss_hat.stage.options import REFEREED_BY_TRAINER
    from rcss_hat.stage.servers import ServerFailed, ServerProcess, find_executable

    if options.speed != 1.0 and not options.real_time:
        raise click.UsageError("--speed needs --real-time; in synch mode a server is as fast as its clients")
    pace = server_pace(Place(FAKE), options.speed) if options.real_time else {"synch_mode": True}
    found = None
    if options.real or options.executable:
        found = find_executable(options.executable)
        if found is None:
            fail(f"no executable {options.executable or 'rcssserver'!r} was found; give --executable PATH, or --fake")
    whistle = REFEREED_BY_TRAINER if options.referee == TRAINER else {}
    options.folder.mkdir(parents=True, exist_ok=True)

    async def run() -> None:
        process = ServerProcess(
            task,
            options.seed,
            found,
            options.folder.resolve(),
            port=options.port,
            **pace,
            **whistle,
        )
        async with process:
            await process.answers()
            click.echo(f"{'rcssserver' if found else 'fake rcssserver'} answers on port {options.port}", err=True)
            if process.random_seed is not None:
                click.echo(f"random seed: {process.random_seed}", err=True)
            await process.ended()

    with plain_errors(ServerFailed):
        try:
            asyncio.run(run())
        except KeyboardInterrupt:
            click.echo("stopped", err=True)
            sys.exit(0)
