"""Writing whole files, and finding out before that a place cannot be written to."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from rcss_hat.system.files import append, check_target, write_text


def full(*_: object) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_file_is_replaced_or_stays_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "new" / "a.txt"
    write_text(path, "one\n")
    assert path.read_text() == "one\n" and path.stat().st_mode & 0o600 == 0o600
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        write_text(path, "two\n")
    assert path.read_text() == "one\n" and list(path.parent.iterdir()) == [path]


def test_what_is_no_ordinary_file_is_written_into(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    write_text(pipe, "hello")
    assert os.read(reader, 99) == b"hello" and pipe.is_fifo()
    os.close(reader)


def test_appending_is_whole_or_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "log.csv"
    append(path, b"a,1\n")
    append(path, b"b,2\n")
    with monkeypatch.context() as broken:
        broken.setattr(os, "fsync", full)
        with pytest.raises(OSError, match="No space left"):
            append(path, b"c,3\n")
    assert path.read_bytes() == b"a,1\nb,2\n"
    if Path("/dev/full").exists():
        with pytest.raises(OSError, match="No space left"):
            append(Path("/dev/full"), b"x")


@pytest.mark.parametrize(
    ("name", "folder", "message"),
    [
        ("folder", False, "it is a folder"),
        ("file/x.csv", False, "file is not a folder"),
        ("file", True, "file is not a folder"),
        ("file/a/b", True, "file is not a folder"),
    ],
)
def test_places_that_cannot_be_are_named(tmp_path: Path, name: str, folder: bool, message: str) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match=message):
        check_target(tmp_path / name, folder)


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="no /proc here")
def test_a_file_system_that_takes_no_files_is_named() -> None:
    for folder in (False, True):
        with pytest.raises(OSError, match=r"/proc/x\.kwy cannot be written: /proc: "):
            check_target(Path("/proc/x.kwy"), folder)


def test_trying_leaves_nothing_behind(tmp_path: Path) -> None:
    check_target(tmp_path / "a" / "b.csv")
    check_target(tmp_path / "a" / "b", folder=True)
    assert not list(tmp_path.iterdir())
    (tmp_path / "b.csv").write_text("kept")
    check_target(tmp_path / "b.csv")
    assert [path.read_text() for path in tmp_path.iterdir()] == ["kept"]
