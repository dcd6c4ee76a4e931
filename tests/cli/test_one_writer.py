"""One writer per folder, whatever ends the first one; a demonstration goes on with other matches."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pandas as pd
import pytest
from click.testing import CliRunner, Result

from rcss_hat.cli.main import cli
from rcss_hat.hat.demonstrations import DemonstrationSet

STUDY = """
title = "Kill test"
seed = 5
baseline = "no-prior"
[defaults]
hours = 3
trials = 1
[demonstrations.mine]
package = "A"
[[condition]]
name = "no-prior"
label = "No Prior"
[[condition]]
name = "novice"
label = "Novice"
method = "ppr"
demonstrations = "mine"
"""
HOLDER = """
import sys
from pathlib import Path
from rcss_hat.system.locks import SoleWriter
right = SoleWriter(Path(sys.argv[1]), folder=sys.argv[2] == "folder")
print("held", flush=True)
sys.stdin.read()
"""


def call(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [str(a) for a in arguments])


@contextmanager
def held(path: Path, kind: str) -> Iterator[int]:
    """Another process writes there; gives its number."""
    command = [sys.executable, "-c", HOLDER, str(path), kind]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout is not None and holder.stdout.readline() == "held\n"
        try:
            yield holder.pid
        finally:
            holder.kill()


@pytest.mark.compiled
def test_a_run_in_use_is_refused_and_stays_as_it_is(tmp_path: Path) -> None:
    run = tmp_path / "run"
    assert call("train", "--hours", "0.01", "--seed", "1", "--out", run, "--quiet").exit_code == 0
    before = (run / "episodes.csv").read_bytes()
    with held(run, "folder") as process:
        refused = call("train", "--resume", "--hours", "0.02", "--out", run, "--quiet")
    assert refused.exit_code == 1
    assert f"is in use by process {process} on " in refused.stderr
    assert (run / "episodes.csv").read_bytes() == before
    assert call("train", "--resume", "--hours", "0.02", "--out", run, "--quiet").exit_code == 0


def test_an_experiment_in_use_is_refused(tmp_path: Path) -> None:
    study = tmp_path / "study.toml"
    study.write_text(STUDY)
    with held(tmp_path / "out", "folder") as process:
        refused = call("experiment", study, "--out", tmp_path / "out", "--quiet")
    assert refused.exit_code == 1
    assert f"is in use by process {process} on " in refused.stderr


def test_a_demonstration_in_use_is_refused(tmp_path: Path) -> None:
    out = tmp_path / "demo.csv"
    with held(out, "file") as process:
        refused = call("demonstrate", "--on", "arena", "--teacher", "A", "--episodes", "1", "--out", out)
    assert refused.exit_code == 1
    assert f"is in use by process {process} on " in refused.stderr
    assert not out.exists()


@pytest.mark.compiled
@pytest.mark.slow
def test_an_experiment_whose_process_was_killed_ends_as_an_undisturbed_one(tmp_path: Path) -> None:
    study = tmp_path / "study.toml"
    study.write_text(STUDY)

    def command(out: str) -> list[str]:
        arguments = ["experiment", str(study), "--jobs", "2", "--out", str(tmp_path / out), "--quiet"]
        return [sys.executable, "-m", "rcss_hat", *arguments]

    first = subprocess.Popen(command("killed"), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    logs = tmp_path / "killed" / "trials"
    while len(list(logs.glob("*/*/config.json"))) < 2:
        assert first.poll() is None
        time.sleep(0.05)
    first.send_signal(signal.SIGKILL)
    first.wait()
    for out in ("killed", "whole"):
        subprocess.run(command(out), check=True, capture_output=True, timeout=130)
    for log in sorted((tmp_path / "whole" / "trials").glob("*/*/episodes.csv")):
        same = logs / log.parent.parent.name / log.parent.name / "episodes.csv"
        assert same.read_bytes() == log.read_bytes()
        assert pd.read_csv(same)["episode"].is_unique


@pytest.mark.compiled
@pytest.mark.parametrize("teacher", ["A", "hand"])
def test_a_resumed_demonstration_goes_on_with_other_matches(tmp_path: Path, teacher: str) -> None:
    out = tmp_path / "demo.csv"
    given = ("demonstrate", "--on", "arena", "--teacher", teacher, "--seed", "1", "--out", out)
    assert call(*given, "--episodes", "2").exit_code == 0
    begun = DemonstrationSet.load(out).episodes
    assert call(*given, "--episodes", "4", "--resume").exit_code == 0
    episodes = DemonstrationSet.load(out).episodes
    assert len(episodes) == 4
    assert [e.states.tobytes() for e in episodes[:2]] == [e.states.tobytes() for e in begun]
    assert len({e.states.tobytes() for e in episodes}) == 4


@pytest.mark.compiled
def test_a_demonstration_interrupted_before_its_first_episode_leaves_nothing_in_the_way(tmp_path: Path) -> None:
    out = tmp_path / "demo.csv"
    arguments = [
        "demonstrate",
        "--on",
        "fake",
        "--teacher",
        "hand",
        "--episodes",
        "1",
        "--seed",
        "1",
        "--out",
        str(out),
    ]
    run = subprocess.Popen(
        [sys.executable, "-m", "rcss_hat", *arguments],
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    while not list(tmp_path.glob(".*.lock")):
        assert run.poll() is None
        time.sleep(0.01)
    run.send_signal(signal.SIGINT)
    said = run.communicate(timeout=120)[0]
    assert run.returncode == 1, said
    assert "Traceback" not in said
    again = call("demonstrate", "--on", "arena", "--teacher", "hand", "--episodes", "1", "--seed", "1", "--out", out)
    assert again.exit_code == 0
    assert len(DemonstrationSet.load(out).episodes) == 1
