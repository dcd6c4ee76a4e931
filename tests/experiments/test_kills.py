"""An experiment on servers whose servers, workers and whole program are killed at random moments, again and again."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from servers_of_trials import signal_servers

from rcss_hat.experiments.experiment import Experiment
from rcss_hat.experiments.run_folder import TrainingError, read_run, run_state
from rcss_hat.experiments.trial import RESULT

STUDY = Path(__file__).with_name("served.toml")
KILLS = 24
PROGRAM = """
import sys
from rcss_hat.experiments.execution import run_locally
from rcss_hat.experiments.experiment import Experiment
experiment = Experiment.create(sys.argv[1], __import__("pathlib").Path(sys.argv[2]), hours=0.3)
for result in experiment.run(lambda work: run_locally(work, 2, 0.5)):
    print(result["condition"], result["trial"], flush=True)
"""


def started(folder: Path) -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, "-c", PROGRAM, str(STUDY), str(folder)], start_new_session=True)


def workers_of(program: int) -> list[int]:
    """Processes that the experiment has its trials run by."""
    listed = subprocess.run(["ps", "-ww", "-eo", "pid,ppid,args"], capture_output=True, text=True, check=True).stdout
    rows = [line.split(None, 2) for line in listed.splitlines()[1:]]
    return [int(pid) for pid, parent, args in rows if int(parent) == program and "LokyProcess" in args]


def state(folder: Path) -> tuple[dict[str, bytes], dict[str, int]]:
    """Results that are there, and cycles that checkpoints hold."""
    results = {path.parent.as_posix(): path.read_bytes() for path in folder.glob(f"trials/*/*/{RESULT}")}
    cycles = {}
    for path in folder.glob("trials/*/*/config.json"):
        try:
            cycles[path.parent.as_posix()] = run_state(read_run(path.parent).checkpoint)["cycles"]
        except TrainingError as problem:  # pragma: no cover (a checkpoint that cannot be read is what must not be)
            raise AssertionError(f"{path.parent}: {problem}") from problem
    return results, cycles


@pytest.mark.slow
@pytest.mark.compiled
@pytest.mark.timeout(900)
def test_no_finished_trial_and_no_checkpointed_hour_is_lost(tmp_path: Path) -> None:
    draw, folder = random.Random(16), tmp_path / "e"
    program = started(folder)
    kills = {"server": 0, "worker": 0, "experiment": 0}
    known: tuple[dict[str, bytes], dict[str, int]] = {}, {}
    try:
        while sum(kills.values()) < KILLS and program.poll() != 0:
            time.sleep(draw.uniform(0.3, 3.0))
            if program.poll() is not None:  # given up: too many kills in a row; the same command goes on
                program = started(folder)
            if not signal_servers(folder, 0):  # nothing is being played yet, or just now
                continue
            what = draw.choice(["server", "server", "worker", "experiment"])
            if what == "server":
                kills["server"] += bool(signal_servers(folder, signal.SIGKILL))
            elif what == "worker":
                workers = workers_of(program.pid)
                if workers:
                    os.kill(draw.choice(workers), signal.SIGKILL)
                    kills["worker"] += 1
            else:
                program.kill()
                program.wait()
                kills["experiment"] += 1
                program = started(folder)
            seen = state(folder)
            for trial, result in known[0].items():
                assert seen[0][trial] == result
            for trial, cycles in known[1].items():
                assert seen[1][trial] >= cycles
            known = seen
        if program.wait(timeout=600) != 0:
            program = started(folder)
        assert program.wait(timeout=600) == 0
    finally:
        program.kill()
    assert sum(kills.values()) >= 20 and min(kills.values()) >= 2, kills
    experiment = Experiment.open(folder)
    assert experiment.finished == experiment.n_trials == 7
    results, _ = state(folder)
    assert all(results[trial] == result for trial, result in known[0].items())
    replaced = 0
    for condition in ("no-prior", "hold-more", "arena"):
        for record in experiment.trials(condition):
            assert record.log is not None and len(record.log) == record.result["episodes"] > 0
            assert record.result["cycles"] >= 10_800
            replaced += record.result.get("servers", {}).get("replaced", 0)
    assert replaced >= kills["server"] // 2
    info = json.loads((folder / "experiment.json").read_text())
    assert info["finished_trials"] <= 7
