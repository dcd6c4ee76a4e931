"""One writer at a time, whatever becomes of him."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from rcss_hat.system.locks import InUse, SoleWriter, sole_writer

HOLD = (
    "import sys, time; from pathlib import Path; from rcss_hat.system.locks import SoleWriter; "
    "right = SoleWriter(Path(sys.argv[1]), sys.argv[2] == 'folder'); print('held', flush=True); sys.stdin.read()"
)


def other_writer(path: Path, kind: str = "folder") -> subprocess.Popen[str]:
    """Another process that holds a folder or a file until its input ends or it is killed."""
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD, path, kind], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None and process.stdout.readline() == "held\n"
    return process


@pytest.mark.parametrize("kind", ["folder", "file"])
def test_the_second_writer_is_told_who_the_first_is(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "run"
    with other_writer(path, kind) as first:
        with pytest.raises(InUse, match=rf"run is in use by process {first.pid} on \S+ since \d{{4}}-") as told:
            SoleWriter(path, kind == "folder")
        assert len(str(told.value)) - len(str(path)) < 200 and "\n" not in str(told.value)
        assert first.stdin is not None
        first.stdin.close()
    with sole_writer(path, kind == "folder"):
        assert list(tmp_path.rglob("*.lock"))
    assert not list(tmp_path.rglob("*.lock"))


def test_a_killed_writer_holds_nothing(tmp_path: Path) -> None:
    with other_writer(tmp_path) as first:
        first.send_signal(signal.SIGKILL)
        first.wait()
    assert (tmp_path / ".lock").exists()
    SoleWriter(tmp_path).release()
    assert not (tmp_path / ".lock").exists()


def test_who_has_patience_gets_what_is_given_up(tmp_path: Path) -> None:
    with other_writer(tmp_path) as first:
        assert first.stdin is not None
        first.stdin.close()
        with sole_writer(tmp_path, patience=60.0):
            assert first.wait() == 0


def test_within_a_process_the_right_may_be_taken_again(tmp_path: Path) -> None:
    outer = SoleWriter(tmp_path)
    with sole_writer(tmp_path):
        pass
    lock = tmp_path / ".lock"
    assert lock.exists()
    inner = SoleWriter(tmp_path)
    outer.release()
    outer.release()
    assert lock.exists()
    del inner, outer
    gc.collect()
    assert not lock.exists()


def test_a_fork_does_not_give_up_what_is_not_its_own(tmp_path: Path) -> None:
    right = SoleWriter(tmp_path)
    child = os.fork()
    if child == 0:
        right.release()
        os._exit(0)
    assert os.waitpid(child, 0)[1] == 0
    assert (tmp_path / ".lock").exists()
    right.release()


def test_a_lock_that_says_nothing_holds_all_the_same(tmp_path: Path) -> None:
    with other_writer(tmp_path) as first:
        (tmp_path / ".lock").write_text("")
        with pytest.raises(InUse, match="in use by another process"):
            SoleWriter(tmp_path)
        assert first.stdin is not None
        first.stdin.close()
