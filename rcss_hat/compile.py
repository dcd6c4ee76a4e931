"""Compile all kernels ahead of time: ``python -m rcss_hat.compile``, or ``rcss-hat compile``.

Kernels are compiled when they are first needed, once per version. Whoever installs for others, or builds an image or a
wheel, does it before: into the folder beside the package that every installation reads (`SHIPPED`), for every
processor of this kind that is not too old.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

from rcss_hat.numeric.cache_folders import SHIPPED, cache_root, clear_gone
from rcss_hat.numeric.compiling import compiling, listen_to
from rcss_hat.numeric.targets import generic_environment

_MODULES = ("rcss_hat.arena.loop", "rcss_hat.arena.handle", "rcss_hat.arena.vector_handle", "rcss_hat.keepaway.agent")
_SERVER = (
    "import sys; from rcss_hat.system.workers import end_with; end_with(int(sys.argv[1])); "
    "from fake_server.warm_up import KERNELS, warm_up; "
    "from rcss_hat.numeric.compiling import tell_parent; tell_parent(*KERNELS); warm_up(quiet=True)"
)


class CompilationFailed(RuntimeError):
    """Kernels that could not be compiled, and why."""


def compile_here(say: Callable[[str], None]) -> Path:
    """Compile all kernels for this processor into one's own cache; return its folder.

    Parameters
    ----------
    say : callable
        Told now and then how far it is.

    Raises
    ------
    CompilationFailed
        When there is no folder to keep them in, or the server's kernels cannot be compiled.
    """
    # Imported here, for all of this takes long to import.
    from rcss_hat.arena import handle
    from rcss_hat.arena.match import prepare
    from rcss_hat.arena.vector import VectorMatch
    from rcss_hat.experiments.execution import warm_up as warm_up_learners
    from rcss_hat.hat.policy import load_policy
    from rcss_hat.hat.teachers import ScriptedTeacher
    from rcss_hat.keepaway.session import KeepawayPlayer
    from rcss_hat.keepaway.task import Task
    from rcss_hat.stage.crew import never
    from rcss_hat.stage.survey import KEEPERS

    root = cache_root()
    if root is None:
        raise CompilationFailed("there is no folder to keep kernels in; RCSS_HAT_CACHE may name one")
    with compiling(say, "all kernels", *_MODULES):
        prepare()
        command = [sys.executable, "-c", _SERVER, str(os.getpid())]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
            listener = listen_to(server)
            load_policy("hold", 3, 2, 0).warm_up()
            KeepawayPlayer(KEEPERS, 3, 2, 0, never).prepare()
            warm_up_learners()
            handle.warm_up()
            VectorMatch(Task(), 1).begin([0])
            ScriptedTeacher("A", 0)(0, (0.0, 0.0), np.ones((3, 2)), -np.ones((2, 2)))
            listener.join()
    if server.returncode:
        raise CompilationFailed("the server's kernels were not compiled")
    return root


def compile_for_all(folder: Path = SHIPPED) -> Path:
    """Compile all kernels for any processor of this kind that is not too old; return the folder they are in.

    Parameters
    ----------
    folder : Path
        One that others read: `SHIPPED`, or what ``RCSS_HAT_CACHE`` names there.

    Raises
    ------
    CompilationFailed
        When the folder cannot be written to, or there is no such choice for this kind of processor.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        environment = {**os.environ, **generic_environment(), "RCSS_HAT_CACHE": str(folder)}
    except (OSError, ValueError) as problem:
        raise CompilationFailed(str(problem)) from problem
    if not os.access(folder, os.W_OK):
        raise CompilationFailed(f"{folder} cannot be written to")
    if subprocess.run([sys.executable, "-m", "rcss_hat.compile"], env=environment, check=False).returncode:
        raise CompilationFailed(f"nothing complete is in {folder}")
    clear_gone(folder, kept=1)
    return folder


def main() -> int:
    """Run the command line; return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m rcss_hat.compile", description="Compile all kernels.")
    parser.add_argument("--for-all", action="store_true", help="into the package, for others with other processors")
    arguments = parser.parse_args()
    try:
        with contextlib.suppress(BrokenPipeError):
            print(compile_for_all() if arguments.for_all else compile_here(lambda text: print(text, file=sys.stderr)))
    except CompilationFailed as problem:
        print(f"Error: {problem}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
