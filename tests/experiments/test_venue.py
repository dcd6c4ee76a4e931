"""Trials on servers, which die, hang, are shared, and are written down."""

from __future__ import annotations

import contextlib
import json
import signal
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from servers_of_trials import signal_servers

from fake_server.options import parse_options
from fake_server.running import running_server
from rcss_hat.cli.experiment import _progress
from rcss_hat.cli.main import cli
from rcss_hat.experiments import venue as venues
from rcss_hat.experiments.episode_log import EpisodeLog, last_hour
from rcss_hat.experiments.execution import run_locally
from rcss_hat.experiments.experiment import Experiment
from rcss_hat.experiments.reporting import write_report
from rcss_hat.experiments.results import Results, pooled
from rcss_hat.experiments.run_folder import TrainingError
from rcss_hat.experiments.training import TrainingRun
from rcss_hat.experiments.trial import run_trial
from rcss_hat.experiments.venue import NotRunning, Supply, read_matches, running_match
from rcss_hat.keepaway.report import Episode, read_kwy
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.params import Value
from rcss_hat.stage.options import server_options

pytestmark = pytest.mark.compiled
STUDY = Path(__file__).with_name("served.toml")


@dataclass
class Box:
    """An experiment, as far as what tells of it looks."""

    folder: Path


@contextlib.contextmanager
def serving() -> Iterator[str]:
    """A server that runs already."""
    ports: dict[str, Value] = dict.fromkeys(("port", "coach_port", "olcoach_port"), 0)
    options = server_options(Task(), real=False, **ports, keepaway_logging=False)
    with running_server(parse_options(options)) as server:
        yield f"127.0.0.1:{server.port}"


def job(folder: Path, **changes: Any) -> dict[str, Any]:
    """The first trial of the study's first condition."""
    made = next(experiment.missing())[0] if (experiment := Experiment.create(str(STUDY), folder)) else {}
    experiment.close()
    return {**made, "config": {**made["config"], **changes}}


@contextlib.contextmanager
def afterwards(folder: Path, number: signal.Signals, episodes: int = 2) -> Iterator[None]:
    """Send the server of a training a signal as soon as so many of its episodes are in the trial's log."""
    over = threading.Event()

    def act() -> None:
        while not over.is_set():
            log = folder / "episodes.csv"
            if log.exists() and log.read_bytes().count(b"\n") > episodes and signal_servers(folder, number):
                return
            time.sleep(0.02)

    thread = threading.Thread(target=act)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def test_a_trial_keeps_its_servers_seeds_logs_and_counts(tmp_path: Path) -> None:
    folder = tmp_path / "trial"
    result = run_trial(job(tmp_path / "e"), folder)
    notes = read_matches(folder)
    assert [note.what for note in notes] == ["initial", "training", "greedy"]
    servers = result["servers"]
    assert (servers["matches"], servers["replaced"], servers["unheard"]) == (3, 0, 0)
    assert servers["cycles"] == sum(note.cycles for note in notes) > 720
    for note, seed in zip(notes, servers["seeds"], strict=True):
        logs = folder / "servers" / str(note.logs)
        assert seed and f"Seed: {seed}" in (logs / "console.log").read_text()
        assert len(read_kwy(logs / "keepaway.kwy")) >= note.episodes
    assert result["initial"]["episodes"] == result["greedy"]["episodes"] == 2
    assert TrainingRun.open(folder).done
    assert not list(folder.glob("initial.json")) and not (folder / "running.json").exists()
    assert run_trial(job(tmp_path / "e"), folder) == result  # is not played again


@pytest.mark.parametrize("number", [signal.SIGKILL, pytest.param(signal.SIGSTOP, marks=pytest.mark.slow)])
def test_a_server_that_dies_or_hangs_is_replaced_and_the_trial_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: signal.Signals
) -> None:
    monkeypatch.setattr("rcss_hat.stage.match.STANDSTILL", 2.0)
    monkeypatch.setattr("rcss_hat.stage.servers.STOP_TIMEOUT", 0.5)
    folder = tmp_path / "trial"
    with afterwards(folder, number):
        result = run_trial(job(tmp_path / "e"), folder)
    assert result["servers"]["replaced"] == 1
    broken = [note for note in read_matches(folder) if note.failure]
    assert [note.what for note in broken] == ["training"] and broken[0].episodes >= 2
    run = TrainingRun.open(folder)
    assert run.done and run.episodes == result["episodes"] >= broken[0].episodes and run.sessions == 2


@pytest.mark.slow
def test_an_evaluation_keeps_the_episodes_before_its_server_died(tmp_path: Path) -> None:
    folder, wanted = tmp_path / "trial", 12
    work = {**job(tmp_path / "e", hours=0.0), "evaluation_episodes": wanted}
    over = threading.Event()

    def act() -> None:
        while not over.wait(0.02):
            log = folder / "servers" / "001" / "keepaway.kwy"
            if log.exists() and len(read_kwy(log)) >= 2 and signal_servers(folder, signal.SIGKILL):
                return

    thread = threading.Thread(target=act)
    thread.start()
    try:
        result = run_trial(work, folder)
    finally:
        over.set()
        thread.join()
    first, second = read_matches(folder)
    assert first.failure and first.episodes and second.failure is None
    assert first.episodes + second.episodes == result["initial"]["episodes"] == wanted


def test_a_trial_is_given_up_when_no_server_plays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    broken = tmp_path / "rcssserver"
    broken.write_text("#!/bin/sh\necho out of order\nexit 3\n")
    broken.chmod(0o755)
    with pytest.raises(TrainingError, match=r"initial: no episode was finished on 5 servers in a row: .*out of order"):
        run_trial(job(tmp_path / "e", stage="real"), tmp_path / "trial", supply=Supply(str(broken)))
    assert len(read_matches(tmp_path / "trial")) == 5
    monkeypatch.setattr(venues, "BACK_S", 0.0)
    monkeypatch.setattr(venues, "GLANCE_S", 0.05)
    away = Supply(None, ("127.0.0.1:9",), tmp_path / "locks")
    with pytest.raises(TrainingError, match=r"no server answers at 127\.0\.0\.1:9"):
        run_trial(job(tmp_path / "e"), tmp_path / "other", supply=away)


@pytest.mark.slow
def test_servers_that_run_already_are_used_by_one_trial_at_a_time(tmp_path: Path) -> None:
    experiment = Experiment.create(str(STUDY), tmp_path / "e", only=("no-prior", "hold-more"))
    with serving() as one, serving() as two:
        supply = Supply(None, (one, two), tmp_path / "locks")
        results = list(experiment.run(lambda work: run_locally(work, 3, supply=supply)))
    assert len(results) == 4
    notes = [note for folder in (tmp_path / "e" / "trials").glob("*/*") for note in read_matches(folder)]
    assert {note.server for note in notes} == {one, two} and not any(note.failure for note in notes)
    assert not any(note.logs or note.seed for note in notes)


def test_the_report_compares_stages_and_leaves_out_who_missed_too_much(tmp_path: Path) -> None:
    experiment = Experiment.create(str(STUDY), tmp_path / "e", only=("no-prior", "arena"))
    list(experiment.run(lambda work: run_locally(work, 1)))
    folder = tmp_path / "e" / "report"
    write_report(experiment)
    table = (folder / "tables" / "stages.csv").read_text().splitlines()
    assert table[0].startswith("Condition,against,Measure,First,Second,Difference") and len(table) == 3
    assert table[1].startswith("no-prior,arena,Initial policy") and table[1].endswith(",2 / 3")
    assert (folder / "figures" / "stages-difference.png").exists()
    servers = (folder / "tables" / "servers.csv").read_text().splitlines()
    assert len(servers) == 3 and all(line.startswith("no-prior,") and ",yes,3,0," in line for line in servers[1:])
    path = experiment.trial_folder("no-prior", 1) / "result.json"
    result = json.loads(path.read_text())
    result["servers"]["missed_share"] = 0.03
    path.write_text(json.dumps(result))
    results = Results(experiment)
    assert len(results.trials["no-prior"]) == 1 and len(results.left_out["no-prior"]) == 1
    write_report(experiment)
    text = (folder / "report.md").read_text()
    assert "**1 trials are left out**: their players missed more than 2 % of the cycles" in text


def test_a_trial_with_an_unheard_end_is_not_pooled(tmp_path: Path) -> None:
    experiment = Experiment.create(str(STUDY), tmp_path / "e", trials=1, only=("arena",))
    list(experiment.run(lambda work: run_locally(work, 1)))
    record = experiment.trials("arena")[0]
    assert pooled(record, 0.0)
    for unheard, share, sound in ((0, 0.01, True), (1, 0.0, False), (0, 0.011, False)):
        record.result["servers"] = {"unheard": unheard, "missed_share": share}
        assert pooled(record, 0.01) is sound


def test_a_running_trial_is_found_by_name(tmp_path: Path) -> None:
    for name, port in (("a/00", 7000), ("a/01", 7001), ("b/00", 7002)):
        folder = tmp_path / "trials" / name
        folder.mkdir(parents=True)
        (folder / "running.json").write_text(
            json.dumps({"what": "training", "host": "127.0.0.1", "port": port, "since": 9.0 - port})
        )
    assert running_match(tmp_path)[0] == "b/00"
    assert str(running_match(tmp_path, "a")[1]) == "127.0.0.1:7001"
    assert running_match(tmp_path, "a/00")[0] == "a/00"
    for trial in ("c", "a/02"):
        with pytest.raises(NotRunning, match=f"no trial {trial} of .* is being played on a server"):
            running_match(tmp_path, trial)
    (tmp_path / "trials" / "b" / "00" / "running.json").write_text("{")
    assert running_match(tmp_path)[0] == "a/01"
    EpisodeLog(tmp_path / "trials" / "a" / "01" / "episodes.csv").append([Episode(1, 0, 900, "o")], lambda number: None)
    (tmp_path / "trials" / "a" / "00" / "episodes.csv").write_text("episode,start\n")
    assert _progress(Box(tmp_path)) == "a/01 0.0 h; a/00 training"  # type: ignore[arg-type]
    assert last_hour(tmp_path / "trials" / "a" / "01" / "episodes.csv") == 0.025


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["paper", "--on", "real", "--executable", "./none"], "no executable './none' was found; give --executable"),
        ([str(STUDY), "--on", "real"], "the study says itself what is played where (arena, fake); leave out --on"),
        (["rounds", "--on", "fake"], "rounds with watch need what only the arena shows"),
        (["paper", "--servers", "localhost:6000"], "--servers are not used by this study"),
        ([str(STUDY), "--servers", "localhost:6000,localhost:6000"], "a server is named twice"),
        ([str(STUDY), "--servers", "localhost"], "'localhost' is not HOST:PORT"),
        ([str(STUDY), "--servers", "a:1", "--dask", "tcp://b:2"], "--servers cannot be given with --dask"),
        (["paper", "--on", "here"], "'here' is not one of 'arena', 'fake', 'real'"),
    ],
)
def test_what_cannot_be_played_is_said_before_anything_is(tmp_path: Path, arguments: list[str], message: str) -> None:
    result = CliRunner().invoke(cli, ["experiment", *arguments, "--out", str(tmp_path / "x")])
    assert result.exit_code == 2 and message in result.stderr
