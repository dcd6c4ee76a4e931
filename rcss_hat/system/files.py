"""Files that a person keeps: written whole or not at all, in places that were tried before."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class NotWritten(OSError):
    """A file could not be written; the message names it and what stood in the way."""


def write_text(path: Path, text: str) -> None:
    """Replace a text file (UTF-8) in one step, so that a crash leaves the old one or the new one.

    Parameters
    ----------
    path : Path
        Folders that are missing are made. What is no ordinary file, such as a pipe or ``/dev/stdout``, is written into.
    text : str

    Raises
    ------
    NotWritten
        When the disk is full or the place cannot be written to; the old file is then as it was.
    """
    write_bytes(path, text.encode())


def write_bytes(path: Path, data: bytes) -> None:
    """Replace a file in one step; see `write_text`."""
    with named(path):
        _write(path, data)


def _write(path: Path, data: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.exists() and not path.is_file():
        path.write_bytes(data)
        return
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    temporary = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        temporary.chmod(_usual_mode())
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def append(path: Path, data: bytes) -> None:
    """Append to a file, and see that the disk has it: all of the data, or, when that fails, nothing.

    Raises
    ------
    NotWritten
        When the disk is full or the file cannot be written to; it then has the length it had before.
    """
    with named(path), path.open("ab", buffering=0) as file:
        before = os.fstat(file.fileno()).st_size
        try:
            rest = memoryview(data)
            while rest:
                rest = rest[file.write(rest) :]
            os.fsync(file.fileno())
        except BaseException:
            if path.is_file():
                file.truncate(before)
            raise


class LiveLog:
    """A file that grows while something is played, and does not stop the play where it cannot.

    Parameters
    ----------
    path : Path
        Begun anew.
    head : str
        What it begins with.

    Raises
    ------
    NotWritten
        When it cannot be begun.
    """

    def __init__(self, path: Path, head: str) -> None:
        self.path = path
        self._rest = b""
        write_text(path, head)

    def add(self, text: str) -> None:
        """Append some text, or keep it for the next time."""
        self._rest += text.encode()
        with contextlib.suppress(NotWritten):
            self.finish()

    def finish(self) -> None:
        """Append what could not be written before.

        Raises
        ------
        NotWritten
            When it still cannot.
        """
        if self._rest:
            append(self.path, self._rest)
            self._rest = b""


def check_target(path: Path, folder: bool = False) -> None:
    """Find out whether a file, or files in a folder, could be written, leaving nothing behind.

    Parameters
    ----------
    path : Path
        Folders above it need not exist.
    folder : bool, default=False
        Whether it is the folder that is to hold the files.

    Raises
    ------
    NotWritten
        Naming the path and what stands in the way.
    """
    if not folder and path.is_dir():
        raise NotWritten(f"{path} cannot be written: it is a folder")
    if not folder and path.exists() and not path.is_file():  # a pipe or a device, which is not opened in vain
        return
    place = path if folder else path.parent
    while not place.exists():
        place = place.parent
    if not place.is_dir():
        raise NotWritten(f"{path} cannot be written: {place} is not a folder")
    try:
        with tempfile.NamedTemporaryFile(dir=place, prefix=".rcss-hat-"):
            pass
    except OSError as problem:
        raise NotWritten(f"{path} cannot be written: {place}: {problem.strerror}") from problem


@contextmanager
def named(path: Path) -> Iterator[None]:
    """Turn whatever keeps a file from being written into a `NotWritten`."""
    try:
        yield
    except NotWritten:
        raise
    except OSError as problem:
        raise NotWritten(f"{path} was not written: {problem.strerror or problem}") from problem


def _usual_mode() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask
