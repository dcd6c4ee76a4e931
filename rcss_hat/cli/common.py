"""What the subcommands share: options, progress, and errors without tracebacks."""

from __future__ import annotations

import contextlib
import errno
import functools
import os
import secrets
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

import click
from click.core import ParameterSource
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from rcss_hat.keepaway.report import INTERRUPTED as INTERRUPTED
from rcss_hat.keepaway.report import Episode
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.params import PROFILES
from rcss_hat.schema import did_you_mean
from rcss_hat.system.files import check_target, named

if TYPE_CHECKING:
    from rcss_hat.hat.policy import TeamPolicy
    from rcss_hat.hat.taker_policy import TakerPolicy

POLICIES = "hold, random, hand, a decision list, a run, module:object, or a model (.zip, .joblib, .pkl, .skops)."
"""What names a policy of keepers, for the help of options."""
F = TypeVar("F", bound=Callable[..., Any])
SERVER, TRAINER = "server", "trainer"
"""Who referees."""
LINE_S = 30.0
"""Seconds between two lines of progress where there is no terminal for a bar."""


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


def typed_settings() -> frozenset[str]:
    """Which settings of the task the user has typed (see `rcss_hat.keepaway.conditions.SETTINGS`)."""
    context = click.get_current_context()
    names = {"region": "field", "vision": "vision", "profile": "profile"}
    default = (ParameterSource.DEFAULT, ParameterSource.DEFAULT_MAP, None)
    return frozenset(setting for name, setting in names.items() if context.get_parameter_source(name) not in default)


def packed(kind: type[Any]) -> Callable[[F], F]:
    """Hand a command its options as one object: a ``kind``, whose fields are named as the options are."""
    names = [field.name for field in fields(kind)]

    def decorate(function: F) -> F:
        @functools.wraps(function)
        def wrapper(*args: Any, **kwargs: Any) -> Any:
            return function(*args, options=kind(**{name: kwargs.pop(name) for name in names}), **kwargs)

        return cast(F, wrapper)

    return decorate


def drawn(seed: int | None) -> int:
    """Return the seed that was given, or one drawn anew."""
    return secrets.randbelow(2**31) if seed is None else seed


def named_policy(spec: str, task: Task, seed: int, option: str, also: str = "") -> TeamPolicy:
    """Return the policy of keepers that an option names; ``also``: what else the option takes.

    Raises
    ------
    click.BadParameter
        When there is none.
    """
    from rcss_hat.hat.policy import PolicyError, load_policy

    try:
        return load_policy(spec, task.keepers, task.takers, seed, task)
    except PolicyError as error:
        raise click.BadParameter(f"{error}{also}", param_hint=option) from error


def named_takers(spec: str, task: Task, seed: int, option: str) -> TakerPolicy | None:
    """Return the policy of takers that an option names; None for the hand-coded one.

    Raises
    ------
    click.BadParameter
        When there is none.
    """
    from rcss_hat.hat.taker_policy import PolicyError, load_taker_policy

    try:
        return load_taker_policy(spec, task, seed)
    except PolicyError as error:
        raise click.BadParameter(str(error), param_hint=option) from error


def say(message: str) -> None:
    """Tell the user on stderr what is going on."""
    click.echo(message, err=True)


def shown(update: Callable[[float], None]) -> Callable[[Sequence[Episode], int], None]:
    """Return what tells a progress bar how many episodes of a match have ended."""

    def show(ended: Sequence[Episode], cycle: int) -> None:
        if ended:
            update(ended[-1].number)

    return show


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


class OneOf(click.Choice[str]):
    """One of some names; what a wrong one may have been is suggested."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the name."""
        try:
            return super().convert(value, param, ctx)
        except click.BadParameter as problem:
            near = did_you_mean(str(value), map(str, self.choices))
            self.fail(problem.message.removesuffix(".") + near, param, ctx)


class Target(click.Path):
    """A file, or a folder of files, that a command will write: refused before anything is done where it cannot be."""

    def __init__(self, folder: bool = False) -> None:
        super().__init__(file_okay=not folder, dir_okay=folder, path_type=Path)
        self.folder = folder

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path after trying the place it is in."""
        path = Path(os.fsdecode(super().convert(value, param, ctx)))
        try:
            check_target(path, self.folder)
        except OSError as problem:
            raise click.ClickException(str(problem)) from problem
        return path


def deliver(text: str, *files: tuple[Path | None, Callable[[Path], object]]) -> None:
    """Print a result, then write what was asked for in files.

    What cannot be printed or written is said, and keeps nothing else from being printed and written; then the command
    ends with exit code 1.

    Parameters
    ----------
    text : str
    *files : (Path or None, callable)
        A file, and what writes it; None: not asked for.
    """
    problems = []
    try:
        click.echo(text)
    except OSError as problem:
        silence_stdout()
        problems.append("" if problem.errno == errno.EPIPE else f"the result was not printed: {problem.strerror}")
    for path, write in files:
        if path is None:
            continue
        try:
            with named(path):
                write(path)
        except OSError as problem:
            problems.append(str(problem))
    for line in filter(None, problems):
        click.echo(f"Error: {line}", err=True)
    if problems:
        sys.exit(1)


def silence_stdout() -> None:
    """Print no more: who listened is gone, or the disk behind it is full, and the end of the program would trip."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


class _Lines:
    """Progress as a line on stderr now and then, for whoever reads it later or through a pipe."""

    def __init__(self, label: str, total: float | None, unit: str) -> None:
        self.label, self.total, self.unit = label, total, unit
        self.completed, self.note, self.begun = 0.0, "", time.monotonic()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._repeat, daemon=True)

    def __enter__(self) -> Callable[..., None]:
        self._say()
        self._thread.start()
        return self._update

    def __exit__(self, *error: object) -> None:
        self._over.set()
        self._thread.join()
        self._say()

    def _update(self, completed: float, note: str = "") -> None:
        self.completed, self.note = completed, note

    def _repeat(self) -> None:
        while not self._over.wait(LINE_S):
            self._say()

    def _say(self) -> None:
        of = "" if self.total is None else f" of {self.total:g}"
        note = f", {self.note}" if self.note else ""
        seconds = time.monotonic() - self.begun
        with contextlib.suppress(OSError):
            click.echo(f"{self.label}: {self.completed:.4g}{of} {self.unit}{note} ({seconds:.0f} s)", err=True)


@contextmanager
def progress_bar(
    label: str, total: float | None, unit: str = "episodes", hide: bool = False
) -> Iterator[Callable[..., None]]:
    """Show a bar on stderr, or a line now and then where that is no terminal; yields ``update(completed, note="")``."""
    console = Console(stderr=True)
    if not hide and not console.is_terminal:
        with _Lines(label, total, unit) as tell:
            yield tell
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn(f"{unit} {{task.fields[note]}}"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console, disable=hide, transient=True) as bars:
        bar = bars.add_task(label, total=total, note="")

        def update(completed: float, note: str = "") -> None:
            bars.update(bar, completed=completed, note=note)

        yield update
