"""The first start: two processes compile what the loop calls."""

from __future__ import annotations

import pytest
from numba.core import event

from rcss_hat.arena import compilation, loop
from rcss_hat.arena.match import ArenaMatch, prepare_players
from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.task import Task
from rcss_hat.numeric.compiling import called_by, name_of
from rcss_hat.numeric.jit import config

pytestmark = pytest.mark.compiled


def test_the_halves_know_the_types_the_loop_calls_them_with() -> None:
    """Otherwise the loop would compile everything once more."""
    if config.DISABLE_JIT:  # type: ignore[attr-defined]
        pytest.skip("nothing is compiled")
    prepare_players()
    match = ArenaMatch(Task(), 0, load_policy("hold", 3, 2, 0))
    compilation.compile_rest(match)
    with event.install_recorder("numba:compile") as compiled:
        loop.run(match.world, match.team, match.brains, match.control, match.logs)
    again = {name_of(event.data["dispatcher"]) for _, event in compiled.buffer}
    assert not {name for name in again if not name.startswith("rcss_hat.arena.")}


def test_both_halves_together_are_what_the_loop_calls() -> None:
    names = called_by(loop.run)
    packages = {name.split(".")[1] for name in names}
    assert packages >= {"arena", "simulation", "keepaway", "player", "hat"}
    assert "learning" not in packages, "games without learners wait for their kernels"


def test_a_half_that_fails_is_compiled_here(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(compilation, "_OTHER_HALF", "raise SystemExit('no')")
    monkeypatch.setattr(compilation, "is_cached", lambda *_: False)
    with compilation.other_half():
        pass
    assert capfd.readouterr().err == ""
