"""Work in several processes of this machine, which end when the one that started them is gone."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager
from typing import Any, TypeVar

from joblib import Parallel, delayed
from joblib.externals.loky.process_executor import TerminatedWorkerError

T = TypeVar("T")
LOOK_S = 0.25
"""Seconds between two looks whether the parent is still there."""
_UNHEEDED = "ignore:resource_tracker"
"""In the words of PYTHONWARNINGS: what joblib's process that tidies up says when the parent was killed. It does tidy
up, and nobody can do anything about it."""

_watched: set[int] = set()


class WorkerDied(RuntimeError):
    """A process that worked here was killed; what was in work is lost, what it had returned is not."""


def in_parallel(function: Callable[..., T], work: Iterable[tuple[Any, ...]], processes: int) -> Iterator[T]:
    """Call a function with every one of some arguments, yielding results as they come.

    Parameters
    ----------
    function : callable
        Of the top level of a module.
    work : iterable of tuple
        Taken as processes become free, not all at once.
    processes : int
        1: in this process.

    Yields
    ------
    object
        What the function returned, in any order; what it raises is raised.

    Raises
    ------
    WorkerDied
        When one of the processes was killed; the others are stopped.
    """
    parent = os.getpid()
    parallel = Parallel(n_jobs=processes, return_as="generator_unordered")
    with _quietly():
        results = parallel(delayed(_call)(parent, function, arguments) for arguments in work)
    try:
        with closing(results) as found:
            yield from found
    except TerminatedWorkerError as problem:
        raise WorkerDied("a worker process was killed (by whom, or for lack of memory, is not known)") from problem


@contextmanager
def _quietly() -> Iterator[None]:
    """Let processes that are started meanwhile say nothing of what is `_UNHEEDED`."""
    before = os.environ.get("PYTHONWARNINGS")
    os.environ["PYTHONWARNINGS"] = ",".join(filter(None, (before, _UNHEEDED)))
    try:
        yield
    finally:
        if before is None:
            del os.environ["PYTHONWARNINGS"]
        else:
            os.environ["PYTHONWARNINGS"] = before


def end_with(parent: int) -> None:
    """End this process soon after its parent has ended, by whatever means: nobody would take what it makes.

    Parameters
    ----------
    parent : int
        Process that this one was started by; when it is this one itself, or has been told before, nothing is done.
    """
    if parent == os.getpid() or parent in _watched:
        return
    _watched.add(parent)
    threading.Thread(target=_watch, args=(parent,), name="parent watch", daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(LOOK_S)
    os._exit(1)


def _call(parent: int, function: Callable[..., T], arguments: tuple[Any, ...]) -> T:
    end_with(parent)
    return function(*arguments)
