from __future__ import annotations

import asyncio
import sys
import threading
import time
from collections.abc import Callable

import pytest

from rcss_hat.numeric.aside import aside

LONG = 60.0
"""Seconds that no test waits."""


async def test_the_loop_goes_on_meanwhile() -> None:
    """The work ends only when the loop has let it."""
    allowed = threading.Event()
    asyncio.get_running_loop().call_later(0.01, allowed.set)
    assert await aside(allowed.wait, LONG)


async def test_arguments_results_and_errors_pass() -> None:
    assert await aside(int, "11", base=2) == 3
    with pytest.raises(ValueError, match="invalid literal"):
        await aside(int, "x")


def busy(began: threading.Event, ended: list[str]) -> Callable[[], None]:
    """Work that goes on for ever, and swallows all errors but those that end a program."""

    def work() -> None:
        try:
            while True:
                try:
                    began.set()
                    time.sleep(0.001)
                except Exception:
                    ended.append("swallowed")
        finally:
            ended.append("stopped")

    return work


async def test_work_that_nobody_wants_stops() -> None:
    began, ended = threading.Event(), []
    task = asyncio.create_task(aside(busy(began, ended)))
    while not began.is_set():
        await asyncio.sleep(0.001)
    before = threading.active_count()
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert ended == ["stopped"]
    assert threading.active_count() == before - 1


async def test_who_swallows_the_word_is_told_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules[aside.__module__], "REMIND", 0.02)
    began, told = threading.Event(), []

    def deaf() -> None:
        while len(told) < 3:
            try:
                began.set()
                time.sleep(0.001)
            except BaseException as error:
                told.append(error)

    task = asyncio.create_task(aside(deaf))
    while not began.is_set():
        await asyncio.sleep(0.001)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert [type(error).__name__ for error in told] == ["Unwanted"] * 3


async def test_nothing_is_said_of_it_where_exceptions_cannot_be_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    """The compiler calls back into Python; exceptions there are printed, and go no further."""
    began, said = threading.Event(), []
    monkeypatch.setattr(sys, "unraisablehook", said.append)

    class Callback:
        def __del__(self) -> None:
            while True:
                began.set()
                time.sleep(0.001)

    task = asyncio.create_task(aside(lambda: str(Callback())))
    while not began.is_set():
        await asyncio.sleep(0.001)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert said == []
    assert sys.unraisablehook == said.append


def test_a_program_ends_although_work_goes_on() -> None:
    """Work that never ends by itself does not hold up a program that does not wait for it (a second Ctrl-C)."""
    began, ended = threading.Event(), []

    async def leave() -> None:
        task = asyncio.create_task(aside(busy(began, ended)))
        while not began.is_set():
            await asyncio.sleep(0.001)
        task.cancel()
        await asyncio.sleep(0)
        task.cancel()

    asyncio.run(leave())
