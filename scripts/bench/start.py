"""How long one waits for the first result, with nothing compiled and with everything compiled.

    scripts/bench/start.py [--against CHECKOUT] [--dearest 10]

Every program starts in a process of its own, with an empty cache of kernels (cold) or the one it just filled (warm).
Processor time is that of all its processes. With ``--against`` the same is measured with the sources in another folder,
turn by turn, and the ratios are printed: on a shared machine nothing else means much.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parents[2]
PROGRAMS = {
    "import": ["-c", "import rcss_hat.arena.match, rcss_hat.stage.stages"],
    "--help": ["-m", "rcss_hat", "--help"],
    "play --on arena": ["-m", "rcss_hat", "play", "--on", "arena", "--episodes", "1", "--seed", "1"],
    "play --on fake": ["-m", "rcss_hat", "play", "--on", "fake", "--episodes", "1", "--seed", "1"],
    "train": ["-m", "rcss_hat", "train", "--method", "none", "--hours", "0.02", "--seed", "1", "--out", "run"],
}
_COMPILED_BY_ONE = """
import collections, contextlib, json, time
from numba.core import event

class Listener(event.Listener):
    def __init__(self):
        self.open, self.own = [], collections.Counter()
    def on_start(self, e):
        self.open.append([time.process_time(), 0.0])
    def on_end(self, e):
        begun, inner = self.open.pop()
        took = time.process_time() - begun
        if self.open:
            self.open[-1][1] += took
        kernel = e.data["dispatcher"].py_func
        self.own[f"{kernel.__module__}.{kernel.__qualname__}"] += took - inner

listener = Listener()
event.register("numba:compile", listener)
from rcss_hat.arena import match
match.other_half = contextlib.nullcontext
match.prepare()
print(json.dumps(listener.own))
"""


class Took(NamedTuple):
    """Seconds of a program."""

    wall: float
    processor: float


def run(arguments: list[str], sources: Path, cache: Path) -> Took:
    """Run a program of some sources with a cache of kernels."""
    environment = {**os.environ, "PYTHONPATH": str(sources), "RCSS_HAT_CACHE": str(cache)}
    with tempfile.TemporaryDirectory() as folder:
        before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        subprocess.run([sys.executable, *arguments], cwd=folder, env=environment, check=True, capture_output=True)
        wall, after = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    return Took(wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def cold_and_warm(arguments: list[str], sources: Path) -> tuple[Took, Took]:
    """Run a program with an empty cache, then with the one it has filled."""
    with tempfile.TemporaryDirectory() as cache:
        return run(arguments, sources, Path(cache)), run(arguments, sources, Path(cache))


def dearest(count: int) -> list[tuple[str, float]]:
    """Compile the loop in one process; return the kernels that took longest, without what they call (s)."""
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "PYTHONPATH": str(HERE), "RCSS_HAT_CACHE": cache}
        told = subprocess.check_output([sys.executable, "-c", _COMPILED_BY_ONE], env=environment)
    own = Counter(json.loads(told.splitlines()[-1]))
    print(f"\n{len(own)} kernels, {sum(own.values()):.1f} s of one processor; the dearest:")
    return own.most_common(count)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--against", type=Path, help="a folder with other sources")
    parser.add_argument("--dearest", type=int, default=10, help="kernels to list")
    parser.add_argument("--only", choices=PROGRAMS, action="append", help="this program; may be given again")
    arguments = parser.parse_args()
    print(f"{'':20}{'cold, s':>18}{'warm, s':>18}\n{'':20}" + 2 * f"{'wall':>9}{'processor':>9}")
    for name in arguments.only or PROGRAMS:
        took = cold_and_warm(PROGRAMS[name], HERE)
        print(f"{name:20}" + "".join(f"{t.wall:9.2f}{t.processor:9.2f}" for t in took), flush=True)
        if arguments.against:
            before = cold_and_warm(PROGRAMS[name], arguments.against)
            ratios = [
                (new.wall / old.wall, new.processor / old.processor) for new, old in zip(took, before, strict=True)
            ]
            print(f"{'':20}" + "".join(f"{w:8.2f}x{p:8.2f}x" for w, p in ratios) + "  of the other's", flush=True)
    for kernel, seconds in dearest(arguments.dearest) if arguments.dearest else []:
        print(f"{seconds:6.2f}  {kernel}")


if __name__ == "__main__":
    main()
