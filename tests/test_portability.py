"""Nothing is needlessly bound to one system: all is imported, and the arena plays, without what Windows and macOS lack.

These tests run where everything is there and take it away. What is then still untested on those systems is said in
docs/reference/reliability.md.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from rcss_hat.system import tether

ROOT = Path(__file__).parents[1]
WITHOUT = """
import importlib, os, pkgutil, signal, subprocess, sys, tempfile
from pathlib import Path

# Other people's packages look after themselves: they are imported while everything is there.
for name in ("asyncio.subprocess", "asyncio_dgram", "filelock", "joblib", "msgspec", "numba", "numpy", "pandas",
             "click", "multiprocessing.connection", "rich.console", "rich.progress", "scipy.stats", "sklearn.tree"):
    importlib.import_module(name)
for name in ("aiohttp.web", "distributed", "gymnasium", "h5py", "jinja2", "matplotlib.pyplot", "minari", "pettingzoo",
             "stable_baselines3", "torch"):
    try:
        importlib.import_module(name)
    except ImportError:
        pass

GONE = {
    os: "fchmod fork forkpty getegid geteuid getgid getgroups getloadavg getpgid getpgrp getpriority getsid getuid "
        "killpg mkfifo nice openpty posix_fadvise posix_fallocate pread preadv pwrite pwritev sched_getaffinity "
        "sched_setaffinity sched_yield sendfile setpgid setpriority setsid setuid sync uname wait wait3 wait4",
    signal: "SIGALRM SIGCHLD SIGHUP SIGKILL SIGPIPE SIGQUIT SIGTSTP SIGUSR1 SIGUSR2 alarm getitimer pause pthread_kill "
            "setitimer sigtimedwait sigwait",
}
for module, names in GONE.items():
    for name in names.split():
        if hasattr(module, name):
            delattr(module, name)
for name in ("fcntl", "grp", "pty", "pwd", "resource", "termios", "tty"):
    sys.modules[name] = None  # "import fcntl" fails

subprocess.Popen.kill = subprocess.Popen.terminate  # which Windows has made one

import fake_server, rcss_hat
imported = 0
for package in (rcss_hat, fake_server):
    for found in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        if found.name.endswith("__main__"):
            continue
        try:
            importlib.import_module(found.name)
            imported += 1
        except ModuleNotFoundError as missing:  # an extra that is not installed
            ours = ("rcss_hat", "fake_server", "fcntl", "grp", "pwd", "resource", "termios")
            assert missing.name.split(".")[0] not in ours, missing
report = rcss_hat.play("hand", episodes=3, seed=1)
assert len(report.episodes) == 3
with tempfile.TemporaryDirectory() as folder:
    rcss_hat.learn(folder, hours=0.02, seed=1)
from fake_server.running import running_server, stopped_by_signals
with running_server(seed=1) as server, stopped_by_signals(server):
    assert server.port
print("imported", imported)
"""


@pytest.mark.compiled
def test_everything_is_imported_and_the_arena_plays_without_what_other_systems_lack() -> None:
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT],
        cwd=ROOT,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert int(done.stdout.split()[-1]) > 250


def elsewhere(command: str) -> list[str]:
    """Return the command line of a tethered program where the kernel does not end it with its parent."""
    arguments = ["tether", str(os.getpid()), sys.executable, "-c", command]
    code = f"import sys, runpy; sys.platform = 'darwin'; sys.argv = {arguments!r}; "
    return [sys.executable, "-c", f"{code} runpy.run_path({tether.__file__!r}, run_name='__main__')"]


def test_a_tethered_program_ends_with_its_parents_pipe() -> None:
    command = "import time; print('here', flush=True); time.sleep(600)"
    with subprocess.Popen(elsewhere(command), stdin=subprocess.PIPE, stdout=subprocess.PIPE) as watchdog:
        assert watchdog.stdout is not None and watchdog.stdin is not None
        assert watchdog.stdout.readline() == b"here\n"
        watchdog.stdin.close()
        assert watchdog.stdout.read() == b""  # the program has ended, too: it held the other end
        assert watchdog.wait() != 0


def test_a_tethered_programs_exit_code_is_passed_on() -> None:
    with subprocess.Popen(elsewhere("import sys; sys.exit(3)"), stdin=subprocess.PIPE) as watchdog:
        assert watchdog.wait() == 3
