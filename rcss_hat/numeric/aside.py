"""Compiling without making anybody wait: work in a thread beside the event loop, which ends when nobody wants it.

``asyncio.to_thread`` would do but for Ctrl-C: a program waits for such a thread before it ends, and compiling takes a
minute.
"""

from __future__ import annotations

import asyncio
import contextlib
import ctypes
import sys
import threading
from collections.abc import Callable, Iterator
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")
REMIND = 0.5
"""Seconds after which a thread that goes on is told again to stop: it may have swallowed the word."""


class Unwanted(BaseException):
    """Raised in a thread whose work nobody wants any more; no ``except Exception`` on its way holds it up."""


async def aside(work: Callable[P, T], *arguments: P.args, **keywords: P.kwargs) -> T:
    """Run a function in a thread of its own, while the event loop goes on.

    When this is cancelled, the thread is told to stop and waited for. It stops at its next step in Python; a call of
    the compiler's that is under way ends first, which may take seconds.

    Parameters
    ----------
    work : callable
    *arguments, **keywords
        Passed on.

    Returns
    -------
    object
        What the function returns; what it raises is raised.
    """
    loop = asyncio.get_running_loop()
    outcome: asyncio.Future[T] = loop.create_future()

    def tell(result: T | None, error: BaseException | None) -> None:
        if outcome.done():
            return
        if error is not None:
            outcome.set_exception(error)
        else:
            outcome.set_result(result)  # type: ignore[arg-type]

    def run() -> None:
        result, error = None, None
        with contextlib.suppress(Unwanted):
            try:
                result = work(*arguments, **keywords)
            except Unwanted:
                return
            except BaseException as raised:
                error = raised
            with contextlib.suppress(RuntimeError):  # the loop is closed: nobody waited
                loop.call_soon_threadsafe(tell, result, error)

    thread = threading.Thread(target=run, name=getattr(work, "__name__", "aside"), daemon=True)
    thread.start()
    try:
        return await outcome
    except asyncio.CancelledError:
        await _stop(thread)
        raise


async def _stop(thread: threading.Thread) -> None:
    with _unwanted_is_unsaid():
        await _remind(thread)


@contextlib.contextmanager
def _unwanted_is_unsaid() -> Iterator[None]:
    """Say nothing of an `Unwanted` that comes where exceptions are printed, not raised: in the compiler's callbacks."""
    usual = sys.unraisablehook

    def hook(unraisable: sys.UnraisableHookArgs) -> None:
        if unraisable.exc_type is not Unwanted:
            usual(unraisable)

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = usual


async def _remind(thread: threading.Thread) -> None:
    while thread.is_alive():
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread.ident or 0), ctypes.py_object(Unwanted))
        waited = 0.0
        while thread.is_alive() and waited < REMIND:
            await asyncio.sleep(0.01)
            waited += 0.01
