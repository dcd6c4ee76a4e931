"""How far a compilation is: which kernels there are to compile, and which have been."""

from __future__ import annotations

import importlib
import subprocess
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import Any

from numba.core import event
from numba.core.dispatcher import Dispatcher

from rcss_hat.numeric.cache_folders import is_cached

EVERY_S = 5.0
"""Seconds between two words on how far a compilation is."""


def name_of(kernel: Any) -> str:
    """Return the full name of a kernel."""
    return f"{kernel.py_func.__module__}.{kernel.py_func.__qualname__}"


def called_by(*kernels: Any) -> set[str]:
    """Return the names of some kernels and of all kernels that they call, directly or not.

    Parameters
    ----------
    kernels
        What the decorators of `rcss_hat.numeric.jit` returned.
    """
    found, waiting = set[str](), [kernel for kernel in kernels if isinstance(kernel, Dispatcher)]
    while waiting:
        kernel = waiting.pop()
        if name_of(kernel) not in found:
            found.add(name_of(kernel))
            waiting += _named_in(kernel.py_func)
    return found


def _named_in(function: Any) -> Iterator[Any]:
    """Yield the kernels that a function names, as they are or as attributes of modules."""
    names, where = function.__code__.co_names, function.__globals__
    values = [where.get(name) for name in names]
    for module in [value for value in values if isinstance(value, ModuleType)]:
        values += [getattr(module, name, None) for name in names]
    yield from (value for value in values if isinstance(value, Dispatcher))


class Compilation(event.Listener):
    """What is compiled from now on, here and in processes that tell of it.

    Parameters
    ----------
    wanted : set of str
        Names of all there is to compile.
    """

    def __init__(self, wanted: set[str]) -> None:
        self.wanted, self.compiled = wanted, set[str]()

    def on_start(self, event: Any) -> None:
        """Do nothing: numba compiles a kernel inside of that of its caller."""

    def on_end(self, event: Any) -> None:
        """Take note that this process has compiled a kernel."""
        self.compiled.add(name_of(event.data["dispatcher"]))

    def __str__(self) -> str:
        return f"{len(self.compiled & self.wanted)} of {len(self.wanted)} kernels compiled"


_open: list[Compilation] = []
_WANTED = "+"


def _kernels_of(modules: Iterable[str]) -> set[str]:
    """Names of the kernels that modules have, and of all that these call."""
    return called_by(*(value for module in modules for value in vars(importlib.import_module(module)).values()))


class _Told(event.Listener):
    def on_start(self, event: Any) -> None:
        pass

    def on_end(self, event: Any) -> None:
        print(name_of(event.data["dispatcher"]), flush=True)


def tell_parent(*modules: str) -> None:
    """Print what there is to compile of some modules, and what is compiled from now on, for `listen_to`."""
    for name in _kernels_of(modules):
        print(f"{_WANTED}{name}", flush=True)
    event.register("numba:compile", _Told())


def listen_to(other: subprocess.Popen[str]) -> threading.Thread:
    """Take note of what another process compiles, in a thread that ends with its output; see `tell_parent`."""

    def listen() -> None:
        assert other.stdout is not None
        for line in other.stdout:
            name = line.strip()
            for compilation in _open:
                (compilation.wanted if name.startswith(_WANTED) else compilation.compiled).add(name.lstrip(_WANTED))

    listener = threading.Thread(target=listen, daemon=True)
    listener.start()
    return listener


@contextmanager
def compiling(say: Callable[[str], None], what: str, *modules: str) -> Iterator[None]:
    """Say what takes so long, and every few seconds how far it is, when some modules' kernels were never compiled here.

    Parameters
    ----------
    say : callable
    what : str
        What is compiled, for people.
    modules : str
        They are imported when they have to be compiled.
    """
    if is_cached(*modules):
        yield
        return
    say(f"Compiling {what} (once per version, up to a minute) ...")
    compilation, over = Compilation(_kernels_of(modules)), threading.Event()

    def repeat() -> None:
        while not over.wait(EVERY_S):
            say(f"  {compilation}")

    voice = threading.Thread(target=repeat, daemon=True)
    event.register("numba:compile", compilation)
    _open.append(compilation)
    voice.start()
    try:
        yield
    finally:
        over.set()
        _open.remove(compilation)
        event.unregister("numba:compile", compilation)
        voice.join()
