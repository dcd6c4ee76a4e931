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


def test_a_program_ends_although_work_goes_on() -> None:
    """As with a second Ctrl-C: whoever does not wait for the thread to stop is not held up by it."""
    began, ended = threading.Event(), []

    async def leave() -> None:
        task = asyncio.create_task(aside(busy(began, ended)))
        while not began.is_set():
            await asyncio.sleep(0.001)
        task.cancel()
        await asyncio.sleep(0)
        task.cancel()

    asyncio.run(leave())
