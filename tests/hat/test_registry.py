"""Another package adds a transfer method and a policy without touching this one."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from rcss_hat.hat.decision_list import PAPER_RULES
from rcss_hat.hat.registry import METHODS, Registry, RegistryError

METHOD = '''
"""Follow the advice by the toss of a coin."""

from dataclasses import dataclass
from typing import ClassVar

from rcss_hat.hat.transfer.method import NO_ADVICE, TransferMethod, check_number
from rcss_hat.learning.sarsa import select_epsilon_greedily
from rcss_hat.numeric.rng import bernoulli


def select_coin(method, learner, rng, advice, confidence):
    if advice != NO_ADVICE and bernoulli(rng, method["settings"][0, 0]):
        return advice
    return select_epsilon_greedily(learner, rng)


@dataclass(frozen=True, slots=True)
class Coin(TransferMethod):
    heads: float = 0.5

    name: ClassVar[str] = "coin"
    select = staticmethod(select_coin)

    def __post_init__(self):
        check_number("heads", self.heads, 0.0, 1.0)

    def describe(self):
        return f"Coin: D with probability {self.heads:g}"

    def settings(self):
        return (self.heads,)


def nearest(keepers, takers, seed):
    return lambda state, info: 1 if state[3] < 4.0 else 0
'''
ENTRY_POINTS = "[rcss_hat.methods]\ncoin = coin_package:Coin\n\n[rcss_hat.policies]\nnearest = coin_package:nearest\n"


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A folder that holds an installed package."""
    site = tmp_path / "site"
    info = site / "coin_package-1.0.dist-info"
    info.mkdir(parents=True)
    (site / "coin_package.py").write_text(METHOD)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: coin-package\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(ENTRY_POINTS)
    return site


def run(package: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(package), *sys.path])
    return subprocess.run(
        [sys.executable, "-m", "rcss_hat", *arguments],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=280,
    )


@pytest.mark.compiled
def test_a_method_of_another_package_learns_and_is_evaluated(package: Path, tmp_path: Path) -> None:
    rules, out = tmp_path / "rules.json", tmp_path / "run"
    PAPER_RULES.save(rules)
    assert "coin" in run(package, "train", "--help").stdout
    given = ["--method", "coin", "--set", "method.heads=0.25", "--rules", str(rules), "--hours", "0.02", "--seed", "1"]
    trained = run(package, "train", *given, "--out", str(out), "--json")
    assert trained.returncode == 0, trained.stderr
    config = json.loads((out / "config.json").read_text())
    assert (config["method"], config["method_settings"]) == ("coin", {"heads": 0.25})
    played = run(package, "play", "--on", "arena", "--keepers", str(out), "--episodes", "3", "--seed", "1", "--json")
    assert (played.returncode, json.loads(played.stdout)["episodes"]) == (0, 3), played.stderr
    wrong = run(package, "train", "--method", "coin", "--set", "method.tails=1", "--rules", str(rules), "--out", "x")
    assert wrong.returncode == 2
    assert "transfer method coin has no setting 'tails'; it has heads" in wrong.stderr


@pytest.mark.compiled
@pytest.mark.parametrize("stage", ["arena", "fake"])
def test_a_policy_of_another_package_plays(package: Path, stage: str) -> None:
    played = run(package, "play", "--on", stage, "--keepers", "nearest", "--episodes", "3", "--seed", "1", "--json")
    assert played.returncode == 0, played.stderr
    assert json.loads(played.stdout)["episodes"] == 3


def test_without_the_package_the_names_are_unknown() -> None:
    with pytest.raises(RegistryError, match="no transfer method 'coin'; there are no-prior, value-bonus"):
        METHODS["coin"]


def test_a_package_that_cannot_be_imported_is_named(package: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (package / "coin_package.py").write_text("1 / 0")
    monkeypatch.syspath_prepend(package)
    assert list(Registry("thing", "rcss_hat.methods", {"ours": "math:pi"})) == ["ours", "coin"]
    with pytest.raises(RegistryError, match=r"'coin' \(coin_package:Coin\) cannot be imported: ZeroDivisionError"):
        METHODS["coin"]
