"""Runs a command that ends when whoever started it does: ``python tether.py PARENT COMMAND ...``.

On Linux the kernel sees to that (PR_SET_PDEATHSIG survives an exec), elsewhere this process stays as a watchdog, whose
standard input is a pipe that closes with its parent. Only the standard library: it starts in a few milliseconds.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import threading

_PR_SET_PDEATHSIG = 1
_NOT_FOUND = 127


def _die_with_parent() -> bool:
    """Ask the kernel to end this process with its parent; false where it cannot."""
    if not sys.platform.startswith("linux"):
        return False
    try:
        import ctypes

        return ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0) == 0
    except (ImportError, OSError, AttributeError):
        return False


def _watch(command: list[str]) -> int:
    """Run a command until it ends, or standard input does."""
    child = subprocess.Popen(command, stdin=subprocess.DEVNULL)

    def wait_for_end() -> None:
        while os.read(sys.stdin.fileno(), 1024):  # unbuffered: a lock that this thread holds would fail the exit
            pass
        child.kill()

    def pass_on(number: int, frame: object) -> None:
        if sys.platform == "win32":  # has no signals to send
            child.terminate()
        else:
            child.send_signal(number)

    threading.Thread(target=wait_for_end, daemon=True).start()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, pass_on)
    return child.wait()


def main(arguments: list[str]) -> int:
    """Run the command; returns its exit code where it does not take this process's place."""
    parent, command = int(arguments[0]), arguments[1:]
    if not _die_with_parent():
        return _watch(command)
    if os.getppid() != parent:
        return 1  # it is gone already
    with contextlib.suppress(OSError):
        os.execvp(command[0], command)
    return _NOT_FOUND


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
