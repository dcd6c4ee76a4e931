"""``rcss-hat train`` and ``rcss-hat evaluate``, as people call them."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest
from click.testing import CliRunner, Result

from rcss_hat.cli.main import cli
from rcss_hat.experiments.run_folder import read_config
from rcss_hat.experiments.training import TrainingRun
from rcss_hat.hat.decision_list import PAPER_RULES
from rcss_hat.hat.transfer import ValueBonus
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.options import server_options
from rcss_hat.stage.servers import free_ports


def call(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [str(a) for a in arguments])


def test_train_resume_and_evaluate_in_the_arena(tmp_path: Path) -> None:
    out, rules = tmp_path / "run", tmp_path / "rules.json"
    PAPER_RULES.save(rules)
    first = call("train", "--method", "ppr", "--rules", rules, "--hours", 0.2, "--seed", 1, "--out", out, "--json")
    assert first.exit_code == 0, first.output
    summary = json.loads(first.stdout)
    assert summary["done"] and summary["method"] == "ppr" and summary["cycles"] == 7200
    assert summary["episodes"] == len(pd.read_csv(out / "episodes.csv"))
    longer = call("train", "--resume", "--out", out, "--hours", 0.3)
    assert longer.exit_code == 0 and "0.30 simulated hours" in longer.stdout and "3600 cycles" in longer.stdout
    evaluated = [call("evaluate", out, "--episodes", 30, "--seed", 2, "--json") for _ in range(2)]
    results = [json.loads(e.stdout) for e in evaluated]
    for result in results:
        del result["wall_s"], result["cycles_per_s"]
    assert results[0] == results[1]
    assert results[0]["episodes"] == 30 and results[0]["mean_s"] > 2.0
    assert len((out / "evaluations.jsonl").read_text().splitlines()) == 2
    assert "30 episodes, mean" in call("evaluate", out, "--episodes", 30, "--explore").stdout


def test_settings_of_learner_and_method(tmp_path: Path) -> None:
    rules = tmp_path / "rules.txt"
    PAPER_RULES.save(rules)
    changes = ["--set", "learner.epsilon=0.05", "--set", "method.bonus=5", "--set", "method.in_targets=false"]
    made = call(
        "train", "--method", "value-bonus", "--rules", rules, "--hours", 0.01, "--out", tmp_path / "r", *changes
    )
    assert made.exit_code == 0, made.output
    config = read_config(tmp_path / "r")
    assert config.method == ValueBonus(bonus=5, in_targets=False) and config.learner.epsilon == 0.05


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["--method", "ppr"], 2, "--method ppr needs --rules"),
        (["--method", "none", "--rules", "RULES"], 2, "uses no --rules"),
        (["--method", "replay"], 2, "--method replay needs --demonstrations"),
        (["--method", "ppr", "--rules", "missing.json"], 2, "there is no such decision list"),
        (["--method", "ppr", "--rules", "RULES", "--size", "4v3"], 1, "the rules are for 3v2"),
        (["--method", "replay", "--demonstrations", "missing.csv"], 2, "missing"),
        (["--learner", "wise"], 2, "no learner preset 'wise'"),
        (["--set", "epsilon=1"], 2, "learner.NAME=VALUE"),
        (["--set", "learner.epsilon=7"], 2, "epsilon must be 0.0 to 1.0"),
        (["--set", "method.speed=7"], 2, "has no setting 'speed'"),
        (["--hours", "0"], 2, "--hours"),
        (["--on", "moon"], 2, "none of arena, fake, real"),
        (["--resume"], 1, "not the folder of a training run"),
        (["--resume", "--seed", "3"], 2, "--seed cannot be given with --resume"),
        (["--resume", "--field", "20x20"], 2, "--field cannot be given with --resume"),
    ],
)
def test_errors_are_one_line(tmp_path: Path, arguments: list[str], code: int, message: str) -> None:
    rules = tmp_path / "rules.json"
    PAPER_RULES.save(rules)
    result = call("train", "--out", tmp_path / "run", *[str(rules) if a == "RULES" else a for a in arguments])
    assert result.exit_code == code, result.output
    assert message in result.stderr and "Traceback" not in result.output and not (tmp_path / "run").exists()


def test_evaluate_wants_a_run(tmp_path: Path) -> None:
    result = call("evaluate", tmp_path)
    assert result.exit_code == 1 and "has no config.json" in result.stderr


@pytest.mark.slow
def test_ctrl_c_saves_and_resuming_finishes(tmp_path: Path) -> None:
    out = tmp_path / "run"
    command = [sys.executable, "-m", "rcss_hat", "train", "--hours", "2000", "--seed", "1", "--learner", "cmac"]
    process = subprocess.Popen([*command, "--out", out, "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    while process.poll() is None and len((out / "episodes.csv").read_bytes() if out.exists() else b"") < 1000:
        time.sleep(0.2)
    process.send_signal(signal.SIGINT)
    stdout, stderr = process.communicate(timeout=60)
    assert process.returncode == 1 and b"go on with: rcss-hat train --resume" in stderr
    stopped = json.loads(stdout)
    run = TrainingRun.open(out)
    assert run.cycles == stopped["hours"] * 36_000 > 0 and run.episodes == stopped["episodes"]


@pytest.mark.slow
def test_training_over_udp_is_recorded_and_goes_on(tmp_path: Path) -> None:
    out = tmp_path / "run"
    first = call("train", "--on", "fake", "--hours", 0.01, "--seed", 3, "--learner", "cmac", "--out", out, "--json")
    assert first.exit_code == 0, first.output
    log = pd.read_csv(out / "episodes.csv")
    summary = json.loads(first.stdout)
    assert summary["episodes"] == len(log) > 0 and set(log["reason"]) <= {"o", "t"}
    run = TrainingRun.open(out)
    assert run.learners.weights.any() and run.sessions == 1
    more = call("train", "--resume", "--hours", 0.02, "--out", out, "--json")
    assert more.exit_code == 0, more.output
    longer = pd.read_csv(out / "episodes.csv")
    assert longer["episode"].tolist() == list(range(1, len(longer) + 1)) and len(longer) > len(log)
    assert (longer["start"].diff().dropna() > 0).all() and longer["hour"].iloc[-1] > 0.01
    evaluated = call("evaluate", out, "--on", "fake", "--episodes", 2, "--seed", 1)
    assert evaluated.exit_code == 0 and "2 episodes" in evaluated.stdout


def start_server(port: int, task: Task) -> subprocess.Popen[bytes]:
    ports = {"port": port, "coach_port": port + 1, "olcoach_port": port + 2}
    command = [sys.executable, "-m", "fake_server", "--seed", "1"]
    options = server_options(task, real=False, keepaway_logging=False, **ports)
    return subprocess.Popen([*command, *options], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


@pytest.mark.slow
def test_training_survives_a_restart_of_the_server(tmp_path: Path) -> None:
    out, port = tmp_path / "run", free_ports()
    server = start_server(port, Task())
    command = [sys.executable, "-m", "rcss_hat", "train", "--on", f"127.0.0.1:{port}", "--hours", "0.06", "--quiet"]
    process = subprocess.Popen([*command, "--seed", "2", "--out", str(out)], stderr=subprocess.PIPE, text=True)
    try:
        log = out / "episodes.csv"
        wait_until(lambda: log.exists() and len(log.read_text().splitlines()) > 5)
        server.kill()
        assert process.stderr is not None
        assert any("waiting up to 60 s for a server" in line for line in process.stderr)
        server = start_server(port, Task())
        assert process.wait(120) == 0, process.stderr.read()
    finally:
        process.kill()
        server.kill()
        server.wait()
    run = TrainingRun.open(out)
    assert run.done and run.sessions == 2
    episodes = pd.read_csv(log)
    assert episodes["episode"].tolist() == list(range(1, len(episodes) + 1))
    assert (episodes["start"].diff().dropna() > 0).all()


def wait_until(done: Callable[[], bool]) -> None:
    give_up = time.monotonic() + 300.0
    while not done():
        assert time.monotonic() < give_up
        time.sleep(0.1)
