"""One writer at a time: locks on folders and files that end with the process that holds them, however it ends."""

from __future__ import annotations

import contextlib
import datetime
import json
import os
import socket
import sys
import threading
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from filelock import FileLock, Timeout

FOLDER_LOCK = ".lock"
"""Name of the lock of a folder, in it. It is there only while somebody writes, or where he was killed."""


class InUse(OSError):
    """Another process writes there; the message says which."""


@dataclass(slots=True)
class _Held:
    lock: FileLock
    process: int
    count: int = 1


_held: dict[Path, _Held] = {}
_mutex = threading.RLock()


class SoleWriter:
    """The right to write to a folder, or to a file, until `release`, the end of a ``with``, or of the process.

    The operating system keeps the lock, so one whose holder was killed is free. Within a process the right may be
    taken several times; it is kept until it was given up as often.

    Parameters
    ----------
    path : Path
        A folder, made when it is missing; or a file, which need not exist.
    folder : bool, default=True
        Which of the two.
    patience : float, default=0
        Seconds to wait for another process.

    Raises
    ------
    InUse
        When another process has it.
    OSError
        When the place cannot be written to.
    """

    def __init__(self, path: Path, folder: bool = True, patience: float = 0.0) -> None:
        place = path if folder else path.parent
        place.mkdir(parents=True, exist_ok=True)
        key = (place / FOLDER_LOCK if folder else place / f".{path.name}.lock").resolve()
        _take(key, path, patience)
        self.release = weakref.finalize(self, _give_up, key)

    def __enter__(self) -> SoleWriter:
        return self

    def __exit__(self, *error: object) -> None:
        self.release()


@contextmanager
def sole_writer(path: Path, folder: bool = True, patience: float = 0.0) -> Iterator[None]:
    """Hold a `SoleWriter` for as long as a block runs."""
    with SoleWriter(path, folder, patience):
        yield


def _take(key: Path, path: Path, patience: float) -> None:
    with _mutex:
        held = _held.get(key)
        if held is not None and held.process == os.getpid():
            held.count += 1
            return
        # Soft locks, the library's way out where a file system has no locks, would outlive their process.
        lock = FileLock(key, thread_local=False, fallback_to_soft=False, on_acquired=_sign)
        try:
            lock.acquire(timeout=patience)
        except Timeout:
            raise InUse(f"{path} is in use by {_holder(key)}; wait until it ends, or stop it") from None
        _held[key] = _Held(lock, os.getpid())


def _give_up(key: Path) -> None:
    with _mutex:
        held = _held[key]
        if held.process != os.getpid():  # a fork has a copy of the books, but not the right
            return
        held.count -= 1
        if held.count == 0:
            del _held[key]
            with contextlib.suppress(OSError):  # who waits for it sees that the file is gone, and makes a new one
                key.unlink()
            held.lock.release()


def _sign(handle: int) -> None:
    """Write into the lock who holds it; one that cannot be signed, on a full disk, holds all the same."""
    program = Path(sys.argv[0]) if sys.argv else Path()
    name = program.parent.name if program.name == "__main__.py" else program.name
    holder = {
        "process": os.getpid(),
        "host": socket.gethostname(),
        "since": datetime.datetime.now().isoformat(" ", "seconds"),
        "command": " ".join([name, *sys.argv[1:2]]),
    }
    with contextlib.suppress(OSError):
        os.ftruncate(handle, 0)
        os.lseek(handle, 0, os.SEEK_SET)
        os.write(handle, json.dumps(holder).encode())


def _holder(key: Path) -> str:
    try:
        found = json.loads(key.read_text(encoding="utf-8"))
        return (
            f"process {int(found['process'])} on {found['host']!s:.60} since {found['since']!s:.19} "
            f"({found['command']!s:.40})"
        )
    except (OSError, ValueError, KeyError, TypeError):
        return "another process"
