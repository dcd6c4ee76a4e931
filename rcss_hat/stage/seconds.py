"""One rcssserver per second: those that start in the same one draw the same noise."""

from __future__ import annotations

import asyncio
import contextlib
import getpass
import tempfile
import time
from collections.abc import AsyncIterator, Callable
from pathlib import Path

from filelock import AsyncFileLock

_LONGEST_S = 5.0
"""Seconds that a record may lie ahead: what is further ahead was written before the clock was set."""


def record_path() -> Path:
    """Return the file in which this machine's servers of this user say in which second they started."""
    with contextlib.suppress(OSError, KeyError, ImportError):
        return Path(tempfile.gettempdir()) / f"rcss-hat-{getpass.getuser()}-server-second"
    return Path(tempfile.gettempdir()) / "rcss-hat-server-second"


@contextlib.asynccontextmanager
async def second_of_its_own() -> AsyncIterator[Callable[[int], None]]:
    """Wait for a second in which no server has started; nobody else starts one until the block ends.

    Yields
    ------
    callable
        To be told the second (of `time.time`) that the server says it started in.
    """
    path = record_path()
    async with AsyncFileLock(f"{path}.lock"):
        last = _last(path)
        while last - _LONGEST_S < time.time() < last + 1:
            await asyncio.sleep(0.02)
        yield lambda second: _record(path, second)


def _last(path: Path) -> int:
    try:
        return int(path.read_text(encoding="ascii"))
    except (OSError, ValueError):  # none has started yet, or the file is damaged: nothing is known
        return 0


def _record(path: Path, second: int) -> None:
    with contextlib.suppress(OSError):  # a full disk is no reason not to play
        path.write_text(str(second), encoding="ascii")
