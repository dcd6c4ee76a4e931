"""How far a compilation is, for people."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable

import pytest
from numba.core import event

from rcss_hat.arena import loop
from rcss_hat.numeric import compiling
from rcss_hat.numeric.jit import kernel

pytestmark = pytest.mark.compiled


@kernel
def _lowest(x: float) -> float:
    return x + 1.0


@kernel
def _middle(x: float) -> float:
    return 2.0 * _lowest(x)


@kernel
def _top(x: float) -> float:
    return _middle(x) + compiling_tests_of_rng.uniform_of(x)


class compiling_tests_of_rng:
    uniform_of = _lowest


def test_all_that_a_kernel_calls_is_found() -> None:
    names = {compiling.name_of(k) for k in (_lowest, _middle, _top)}
    assert compiling.called_by(_top) == names
    assert compiling.called_by(_middle) == names - {compiling.name_of(_top)}


def test_the_loop_calls_the_kernels_of_all_packages_by_their_modules() -> None:
    names = compiling.called_by(loop.run)
    assert {"rcss_hat.simulation.vision.see", "rcss_hat.keepaway.agent.perceive", "rcss_hat.arena.loop.run"} <= names
    assert len(names) > 200


def words_of(call: Callable[[], object], monkeypatch: pytest.MonkeyPatch, cached: bool = False) -> list[str]:
    said = list[str]()
    monkeypatch.setattr(compiling, "EVERY_S", 0.01)
    monkeypatch.setattr(compiling, "is_cached", lambda *_: cached)
    with compiling.compiling(said.append, "the players", __name__):
        call()
    return said


def test_what_takes_so_long_is_said_and_how_far_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    def call() -> None:
        with event.trigger_event("numba:compile", data={"dispatcher": _top}):
            pass
        time.sleep(0.1)

    said = words_of(call, monkeypatch)
    assert said[0] == "Compiling the players (once per version, up to a minute) ..."
    assert said[-1] == "  1 of 3 kernels compiled"


def test_nothing_is_said_of_what_was_compiled_before(monkeypatch: pytest.MonkeyPatch) -> None:
    assert words_of(lambda: time.sleep(0.05), monkeypatch, cached=True) == []


def test_what_another_process_compiles_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    lines = f"+other.kernel\nother.kernel\n{compiling.name_of(_middle)}\n"

    def call() -> None:
        command = [sys.executable, "-c", f"print({lines!r}, end='')"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as other:
            compiling.listen_to(other).join()
        time.sleep(0.1)

    assert words_of(call, monkeypatch)[-1] == "  2 of 4 kernels compiled"
