"""Kernels compiled ahead of time: for everybody who installs a wheel, and for one's own user."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest
from click.testing import CliRunner
from hatchling.builders.wheel import WheelBuilder

from rcss_hat.arena.match import ArenaMatch
from rcss_hat.cli.main import cli
from rcss_hat.compile import CompilationFailed, compile_for_all
from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.task import Task
from rcss_hat.numeric import cache_folders, targets
from rcss_hat.numeric.jit import config

pytestmark = pytest.mark.compiled
ROOT = Path(__file__).parents[1]
PLAY = """
from contextlib import suppress
from numba.core import event
with event.install_recorder("numba:compile") as compiled, suppress(SystemExit):
    from rcss_hat.cli.main import cli
    cli("play --on arena --keepers hand --episodes 5 --seed 1 --json".split())
print(len(compiled.buffer))
"""


def built(folder: Path, kernels: bool) -> Path:
    environment = {**os.environ, "HATCH_BUILD_HOOK_ENABLE_CUSTOM": str(kernels).lower()}
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "--wheel-dir"]
    subprocess.run([*command, str(folder), str(ROOT)], check=True, env=environment, capture_output=True)
    [wheel] = folder.glob("*.whl")
    return wheel


def installed(wheel: Path, folder: Path) -> Path:
    """Install a wheel into an environment that borrows all other packages; return its Python."""
    venv.create(folder, with_pip=False)
    python = folder / "bin" / "python"
    [site] = folder.glob("lib/*/site-packages")
    (site / "others.pth").write_text(sysconfig.get_path("purelib"))
    zipfile.ZipFile(wheel).extractall(site)
    return python


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_a_wheel_with_kernels_plays_without_compiling(tmp_path: Path) -> None:
    """In a fresh environment of a user who has nothing in the home folder."""
    if config.DISABLE_JIT or config.CACHE_DIR or len(targets.readable_targets()) < 2:  # type: ignore[attr-defined]
        pytest.skip("nothing is compiled, or this processor is older than those a wheel is for")
    wheel = built(tmp_path / "wheel", kernels=True)
    assert "-none-any" not in wheel.name
    python = installed(wheel, tmp_path / "environment")
    alone = {"PATH": os.defpath, "HOME": str(tmp_path / "home")}
    told = subprocess.run([python, "-c", PLAY], env=alone, cwd=tmp_path, capture_output=True, text=True, check=True)
    report, compiled = told.stdout.rsplit("\n", 2)[:2]
    assert compiled == "0" and "Compiling" not in told.stderr
    match = ArenaMatch(Task(), 1, load_policy("hand", 3, 2, 1))
    here = [episode.cycles for part in match.advance(episodes=5) for episode in part]
    assert json.loads(report)["mean_s"] == pytest.approx(sum(here) / 50.0, abs=1e-12)
    assert not list((tmp_path / "home").rglob("*.nb*"))


def test_a_wheel_without_kernels_is_pure_python(tmp_path: Path) -> None:
    [wheel] = WheelBuilder(str(ROOT)).build(directory=str(tmp_path), versions=["standard"])
    assert wheel.endswith("-py3-none-any.whl")
    assert not [name for name in zipfile.ZipFile(wheel).namelist() if "kernels/" in name or ".nb" in name]


def test_where_nobody_may_write_is_said(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(CompilationFailed, match="file"):
        compile_for_all(tmp_path / "file" / "kernels")


def test_without_a_folder_of_ones_own_it_is_said_what_would_help(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rcss_hat.compile.cache_root", lambda: None)
    result = CliRunner().invoke(cli, ["compile"])
    assert result.exit_code == 1 and "RCSS_HAT_CACHE" in result.stderr and result.stderr.count("\n") == 1


def test_an_unknown_kind_of_processor_has_no_kernels_for_all(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("platform.machine", lambda: "riscv64")
    with pytest.raises(CompilationFailed, match="riscv64"):
        compile_for_all(tmp_path)


def test_everything_is_compiled_that_commands_need(tmp_path: Path) -> None:
    """What `rcss-hat compile` leaves out would be compiled while a server waits."""
    if config.DISABLE_JIT:  # type: ignore[attr-defined]
        pytest.skip("nothing is compiled")
    result = CliRunner().invoke(cli, ["compile"])
    assert result.exit_code == 0
    assert Path(result.stdout.strip()) == cache_folders.cache_root()
    assert cache_folders.is_cached("rcss_hat.arena.loop", "rcss_hat.keepaway.agent", "rcss_hat.hat.teaching")
