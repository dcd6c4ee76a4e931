"""What the subcommands share: options, progress, and errors without tracebacks."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar, cast

import click
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.params import PROFILES

F = TypeVar("F", bound=Callable[..., Any])
ARENA, FAKE, REAL = "arena", "fake", "real"
SERVER, TRAINER = "server", "trainer"
"""Who referees."""
INTERRUPTED = "interrupted"


def task_options(function: F) -> F:
    """Add ``--size --field --vision --profile``; the command receives ``task``."""

    @click.option("--size", default="3v2", show_default=True, help="Keepers and takers.")
    @click.option(
        "--field", "region", default=None, help="Region in metres, e.g. 20x20.  [default: usual for the size]"
    )
    @click.option("--vision", default=360, show_default=True, help="View angle in degrees: 360 or 90.")
    @click.option("--profile", type=click.Choice(PROFILES), default=PROFILES[0], show_default=True, help="Physics of.")
    @functools.wraps(function)
    def wrapper(*args: Any, size: str, region: str | None, vision: int, profile: str, **kwargs: Any) -> Any:
        try:
            task = Task.parse(size, region, vision, profile)
        except ValueError as error:
            raise click.UsageError(str(error)) from error
        return function(*args, task=task, **kwargs)

    return cast(F, wrapper)


class Stage(click.ParamType):
    """Where to play: ``fake``, ``arena``, ``real`` or ``HOST:PORT``."""

    name = "stage"

    def __init__(self, *words: str) -> None:
        self.words = words

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        """Show what can be given."""
        return "|".join((*self.words, "HOST:PORT"))

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str | tuple[str, int]:
        """Return a word, or (host, port)."""
        if value in self.words or isinstance(value, tuple):
            known: str | tuple[str, int] = value
            return known
        host, colon, port = str(value).rpartition(":")
        if colon and host and port.isdigit() and 0 < int(port) < 65536:
            return host, int(port)
        self.fail(f"{value!r} is none of {', '.join(self.words)}, and not HOST:PORT, for example localhost:6000")


def stage_text(stage: str | tuple[str, int]) -> str:
    """Write a stage as it was given."""
    return stage if isinstance(stage, str) else f"{stage[0]}:{stage[1]}"


def tell_of_compilation(module: str) -> None:
    """Say on stderr what takes so long when the kernels of a module were never compiled here."""
    from rcss_hat.numeric.jit import is_cached

    if not is_cached(module):
        click.echo("Compiling the players and the simulation (once per installation, about a minute) ...", err=True)


def fail(message: str, code: int = 1) -> None:
    """Say what went wrong on stderr and exit."""
    click.echo(f"Error: {message}", err=True)
    sys.exit(code)


@contextmanager
def plain_errors(*kinds: type[Exception]) -> Iterator[None]:
    """Turn expected failures into one line and exit code 1."""
    try:
        yield
    except OSError as error:
        fail(str(error))
    except kinds as error:
        fail(str(error))


@contextmanager
def progress_bar(
    label: str, total: float | None, unit: str = "episodes", hide: bool = False
) -> Iterator[Callable[..., None]]:
    """Show a bar on stderr; yields ``update(completed, note="")``."""
    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn(f"{unit} {{task.fields[note]}}"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console, disable=hide or not console.is_terminal, transient=True) as bars:
        bar = bars.add_task(label, total=total, note="")

        def update(completed: float, note: str = "") -> None:
            bars.update(bar, completed=completed, note=note)

        yield update
