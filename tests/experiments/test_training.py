"""Training runs: files, resuming, being killed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from rcss_hat.experiments.episode_log import EpisodeLog, EpisodeLogError, read_episode_log
from rcss_hat.experiments.evaluation import evaluate, frozen_policy
from rcss_hat.experiments.run_folder import RunConfig, TrainingError, read_config, session_seed
from rcss_hat.experiments.training import TrainingRun
from rcss_hat.hat.decision_list import PAPER_RULES
from rcss_hat.hat.transfer import CHAT, PPR, Decisions, NoPrior, Replay, ValueBonus
from rcss_hat.keepaway.report import Episode
from rcss_hat.keepaway.task import Task
from rcss_hat.learning.checkpoint import load_checkpoint
from rcss_hat.learning.config import load_config
from rcss_hat.system.interrupts import interrupt_flag

RUN = """
import sys
from pathlib import Path
from rcss_hat.experiments.run_folder import RunConfig
from rcss_hat.experiments.training import TrainingRun
from rcss_hat.hat.decision_list import PAPER_RULES
from rcss_hat.hat.transfer import PPR
from rcss_hat.keepaway.task import Task
from rcss_hat.learning.config import load_config

folder = Path(sys.argv[1])
if (folder / "config.json").exists():
    run = TrainingRun.open(folder)
else:
    config = RunConfig(task=Task(), learner=load_config("cmac"), method=PPR(), seed=5, hours=4)
    run = TrainingRun.create(folder, config, PAPER_RULES)
run.train(lambda run: print(run.cycles, flush=True), checkpoint_s=float(sys.argv[2]))
"""


def config(**changes: object) -> RunConfig:
    settings = {"task": Task(), "learner": load_config("cmac"), "method": NoPrior(), "seed": 5, "hours": 0.1}
    return RunConfig(**{**settings, **changes})


def same_runs(a: Path, b: Path) -> bool:
    first, second = load_checkpoint(a / "learners.npz"), load_checkpoint(b / "learners.npz")
    assert first.header == second.header
    assert first.arrays.keys() == second.arrays.keys()
    return all(contents(first.arrays[k]) == contents(second.arrays[k]) for k in first.arrays) and (
        (a / "episodes.csv").read_bytes() == (b / "episodes.csv").read_bytes()
    )


def contents(array: np.ndarray) -> list[bytes]:
    """Every bit of an array that means something: not what lies between the fields of aligned records."""
    return [array[name].tobytes() for name in array.dtype.names] if array.dtype.names else [array.tobytes()]


def test_a_run_writes_weights_settings_and_a_log_that_pandas_reads(tmp_path: Path) -> None:
    run = TrainingRun.create(tmp_path / "run", config(method=PPR()), PAPER_RULES)
    seen: list[float] = []
    assert run.train(lambda r: seen.append(r.hours))
    assert run.done and seen[-1] == pytest.approx(0.1)
    log = pd.read_csv(tmp_path / "run" / "episodes.csv")
    assert list(log.columns) == ["episode", "start", "duration", "reason", "psi", "hour"]
    assert log["episode"].tolist() == list(range(1, run.episodes + 1)) and run.episodes > 20
    assert (log["start"][1:].to_numpy() == (log["start"] + log["duration"])[:-1].to_numpy()).all()
    assert log["psi"].to_numpy() == pytest.approx(0.999 ** log["episode"].to_numpy(), rel=1e-5)
    assert log["hour"].iloc[-1] <= 0.1 and set(log["reason"]) <= {"o", "t"}
    assert read_episode_log(run.log.path)["seconds"].tolist() == (log["duration"] / 10).tolist()
    assert run.windowed_mean == pytest.approx(log["duration"].mean() / 10)
    written = json.loads((tmp_path / "run" / "config.json").read_text())
    assert written["seed"] == 5 and written["method"] == "ppr" and "numba" in written["versions"]
    assert read_config(tmp_path / "run") == run.config
    assert run.learners.episodes == run.episodes


def test_stopping_and_resuming_changes_nothing(tmp_path: Path) -> None:
    whole = TrainingRun.create(tmp_path / "whole", config(hours=2.5))
    whole.train()
    part = TrainingRun.create(tmp_path / "part", config(hours=2.5))
    assert not part.train(stop=lambda: True)
    assert part.cycles == 36_000
    again = TrainingRun.open(tmp_path / "part")
    assert again.cycles == 36_000 and again.recent == part.recent
    assert again.train(until=50_000) and not again.done
    assert TrainingRun.open(tmp_path / "part").train()
    assert same_runs(tmp_path / "whole", tmp_path / "part")


def test_a_killed_run_ends_as_if_it_had_not_been_killed(tmp_path: Path) -> None:
    subprocess.run([sys.executable, "-c", RUN, tmp_path / "whole", "60"], check=True, stdout=subprocess.DEVNULL)
    kills = 0
    for _ in range(20):
        command = [sys.executable, "-c", RUN, tmp_path / "killed", "0"]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        if process.stdout.readline():
            time.sleep(0.05 * kills)
            process.send_signal(signal.SIGKILL)
        kills += process.wait() == -signal.SIGKILL
        if (tmp_path / "killed" / "config.json").exists() and TrainingRun.open(tmp_path / "killed").done:
            break
    assert kills > 0
    TrainingRun.open(tmp_path / "killed").train()
    assert same_runs(tmp_path / "whole", tmp_path / "killed")


def test_rows_beyond_the_checkpoint_are_dropped_and_missing_ones_reported(tmp_path: Path) -> None:
    run = TrainingRun.create(tmp_path / "run", config())
    run.train()
    whole = run.log.path.read_bytes()
    with run.log.path.open("ab") as file:
        file.write(b"99999,1,2,o,,3")
    TrainingRun.open(tmp_path / "run")
    assert run.log.path.read_bytes() == whole
    run.log.path.write_bytes(whole[:-10])
    with pytest.raises(TrainingError, match="fewer than"):
        TrainingRun.open(tmp_path / "run")


def test_a_longer_run_is_the_shorter_one_continued(tmp_path: Path) -> None:
    run = TrainingRun.create(tmp_path / "run", config(hours=0.1))
    run.train()
    run = TrainingRun.open(tmp_path / "run")
    run.extend(0.05)
    assert run.config.hours == 0.1
    run.extend(0.2)
    TrainingRun.open(tmp_path / "run").train()
    TrainingRun.create(tmp_path / "long", config(hours=0.2)).train()
    assert same_runs(tmp_path / "run", tmp_path / "long")


def test_a_new_round_replaces_the_rules_and_begins_reuse_anew(tmp_path: Path) -> None:
    run = TrainingRun.create(tmp_path / "run", config(method=PPR(decay=0.9)), PAPER_RULES)
    run.train(until=1800)
    before, weights = run.episodes, run.learners.weights.copy()
    run.new_round(PAPER_RULES)
    assert run.learners.psi == 1.0 and (run.learners.weights == weights).all()
    again = TrainingRun.open(tmp_path / "run")
    assert (again.round, again.reuse_from) == (1, before)
    again.train()
    psi = read_episode_log(again.log.path)["psi"].to_numpy()
    assert psi[before - 1] == pytest.approx(0.9**before, rel=1e-5)
    assert psi[before : before + 2] == pytest.approx([0.9, 0.81])


def test_what_a_method_needs_must_be_there(tmp_path: Path) -> None:
    for method, rules, message in (
        (PPR(), None, "needs rules"),
        (NoPrior(), PAPER_RULES, "uses no rules"),
        (Replay(), None, "needs demonstrations"),
    ):
        with pytest.raises(TrainingError, match=message):
            TrainingRun.create(tmp_path / "run", config(method=method), rules)
    with pytest.raises(TrainingError, match="the rules are for 3v2; the task is 4v3"):
        TrainingRun.create(tmp_path / "run", config(method=PPR(), task=Task(4, 3)), PAPER_RULES)
    assert not (tmp_path / "run").exists()
    TrainingRun.create(tmp_path / "run", config())
    with pytest.raises(TrainingError, match="resume it"):
        TrainingRun.create(tmp_path / "run", config())


def test_replayed_demonstrations_are_in_the_first_weights(tmp_path: Path) -> None:
    decisions = Decisions.of(np.full((2, 13), 5.0), [1, 0], [10.0, 5.0], [False, True])
    run = TrainingRun.create(tmp_path / "run", config(method=Replay(passes=2)), demonstrations=decisions)
    assert run.learners.weights.any() and run.learners.episodes == 0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "has no config.json"),
        ("{", "not valid"),
        ("[]", "not the configuration"),
        ('{"format": "rcss-hat training run", "version": 1}', "not valid"),
    ],
)
def test_a_folder_that_is_no_run_is_refused(tmp_path: Path, text: str | None, message: str) -> None:
    if text is not None:
        (tmp_path / "config.json").write_text(text)
    with pytest.raises(TrainingError, match=message):
        TrainingRun.open(tmp_path)


def test_damaged_weights_are_named(tmp_path: Path) -> None:
    TrainingRun.create(tmp_path / "run", config())
    (tmp_path / "run" / "learners.npz").write_bytes(b"nothing")
    with pytest.raises(TrainingError, match=r"learners\.npz"):
        TrainingRun.open(tmp_path / "run")
    (tmp_path / "run" / "learners.npz").unlink()
    with pytest.raises(TrainingError, match="cannot be resumed"):
        TrainingRun.open(tmp_path / "run")


def test_settings_are_checked() -> None:
    with pytest.raises(ValueError, match="hours"):
        config(hours=-1.0)
    with pytest.raises(ValueError, match="seed"):
        config(seed=-1)
    changed = config(method=ValueBonus(bonus=3.0), task=Task(4, 3, 30.0, 30.0))
    assert RunConfig.from_dict(json.loads(json.dumps(changed.to_dict()))) == changed


def test_sessions_over_udp_count_on_and_are_settled_by_the_server_log(tmp_path: Path) -> None:
    run = TrainingRun.create(tmp_path / "run", config(stage="fake"))
    assert session_seed(5, run.sessions) == 5
    run.begin_session()
    run.record([Episode(1, 0, 40, "?")])
    run.record([Episode(2, 40, 100, "?")])
    run.learners.records["episodes"] = [2, 2, 1]
    run.settle([Episode(1, 0, 40, "o"), Episode(2, 40, 100, "t")])
    run.checkpoint()
    run = TrainingRun.open(tmp_path / "run")
    assert session_seed(5, run.sessions) == session_seed(5, 1) != 5
    run.begin_session()
    assert run.learners.records["episodes"].tolist() == [2, 2, 2]
    run.record([Episode(1, 0, 30, "?")])
    run.settle([])  # the server wrote no log
    log = read_episode_log(run.log.path)
    assert log["start"].tolist() == [0, 40, 100] and log["episode"].tolist() == [1, 2, 3]
    assert log["reason"].tolist() == ["o", "t", "?"]
    assert (run.cycles, run.episodes, list(run.recent)) == (130, 3, [40, 60, 30])


def test_psi_of_the_log() -> None:
    assert PPR(decay=0.5).psi_after(3) == 0.125
    assert CHAT(decay=0.5).psi_after(1) == 0.5
    assert PPR(schedule="within-episode").psi_after(3) == 1.0
    assert PPR(schedule="decision").psi_after(3) is None
    assert NoPrior().psi_after(3) is None


def test_evaluation_leaves_the_learners_alone_and_repeats(tmp_path: Path) -> None:
    run = TrainingRun.create(tmp_path / "run", config())
    run.train()
    before = run.learners.weights.tobytes() + run.learners.records.tobytes() + run.learners.streams.tobytes()
    first, second = (evaluate(frozen_policy(run.learners, None, 9), Task(), 9, 20) for _ in range(2))
    assert first.episodes == second.episodes and len(first.episodes) == 20
    assert before == run.learners.weights.tobytes() + run.learners.records.tobytes() + run.learners.streams.tobytes()
    other = evaluate(frozen_policy(run.learners, None, 9, exploring=True), Task(), 10, 20)
    assert other.episodes != first.episodes


def test_the_first_ctrl_c_is_a_flag_and_the_second_interrupts() -> None:
    usual = signal.getsignal(signal.SIGINT)
    with interrupt_flag() as pressed:
        assert not pressed()
        os.kill(os.getpid(), signal.SIGINT)
        assert pressed()
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(1.0)
    assert signal.getsignal(signal.SIGINT) is usual


def test_an_episode_log_says_what_is_wrong_with_it(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("a,b\n1,2\n")
    with pytest.raises(EpisodeLogError, match="its columns are a, b"):
        read_episode_log(path)
    path.write_text("")
    with pytest.raises(EpisodeLogError, match="not an episode log"):
        read_episode_log(path)
    path.unlink()
    log = EpisodeLog(path)
    log.append([], lambda number: None)
    assert read_episode_log(path).empty
