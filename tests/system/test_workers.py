"""Workers give results as they come, and do not outlive who started them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rcss_hat.system.workers import WorkerDied, in_parallel

PARENT = (
    "import sys; from test_workers import busy; from rcss_hat.system.workers import in_parallel; "
    "list(in_parallel(busy, [(sys.argv[1], k) for k in range(2)], 2))"
)


def busy(folder: str, number: int) -> None:
    """Say who works, and go on for ever."""
    (Path(folder) / f"{number}").write_text(str(os.getpid()))
    while True:
        time.sleep(0.01)


def squared(number: int) -> int:
    """Take longer than it takes to look at a result."""
    time.sleep(0.02)
    return number**2


@pytest.mark.parametrize("processes", [1, 2])
def test_every_result_comes_once(processes: int) -> None:
    taken = []

    def work() -> object:
        for number in range(20):
            taken.append(number)
            yield (number,)

    results = in_parallel(squared, work(), processes)  # type: ignore[arg-type]
    first = next(results)
    assert len(taken) < 20, "work is taken as processes become free"
    assert sorted([first, *results]) == [number**2 for number in range(20)]


def ended(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    status = Path(f"/proc/{process}/status")  # a container without init keeps what has ended as a zombie
    return status.exists() and "State:\tZ" in status.read_text()


def test_workers_end_when_their_parent_was_killed_and_nobody_complains(tmp_path: Path) -> None:
    command = [sys.executable, "-c", PARENT, tmp_path]
    parent = subprocess.Popen(command, cwd=Path(__file__).parent, stderr=subprocess.PIPE)
    while len(found := [path.read_text() for path in tmp_path.iterdir()]) < 2 or not all(found):
        assert parent.poll() is None
        time.sleep(0.05)
    parent.kill()
    parent.wait()
    while not all(ended(int(process)) for process in found):  # the time limit of all tests ends this
        time.sleep(0.05)
    assert parent.stderr is not None
    assert parent.stderr.read() == b"", "also of who tidies up after them"
    parent.stderr.close()


def killed(number: int) -> int:
    if number == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def test_a_worker_that_is_killed_is_missed() -> None:
    with pytest.raises(WorkerDied, match="a worker process was killed"):
        list(in_parallel(killed, [(number,) for number in range(4)], 2))
