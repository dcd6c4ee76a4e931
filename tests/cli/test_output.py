"""Results are shown before they are stored, targets are tried before the play, and progress needs no terminal."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import json
import os
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from click.testing import CliRunner, Result

from fake_server.options import parse_options
from fake_server.running import running_server
from fake_server.server import Server
from rcss_hat.cli import common
from rcss_hat.cli.common import Target, deliver, progress_bar
from rcss_hat.cli.main import COMMANDS, LazyGroup, cli
from rcss_hat.experiments.training import TrainingRun
from rcss_hat.hat.demonstrations import DemonstrationSet
from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.report import RunReport, read_kwy
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.params import Value
from rcss_hat.stage.match import Match, play_match
from rcss_hat.stage.options import REFEREED_BY_TRAINER, server_options
from rcss_hat.system.files import LiveLog

WRITING = {"--out", "--kwy", "--rest", "--arff", "--folder"}


def call(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [str(a) for a in arguments])


def full(*_: object) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_every_option_that_names_a_file_to_write_tries_it_first() -> None:
    found = set()
    group = cli
    assert isinstance(group, LazyGroup)
    for name in COMMANDS:
        command = group.get_command(click.Context(group), name)
        assert command is not None
        for option in command.params:
            if WRITING & set(option.opts):
                assert isinstance(option.type, Target), (name, option.opts)
                found |= {(name, *option.opts)}
    assert len(found) >= 12


@pytest.mark.parametrize(
    "arguments",
    [
        ("play", "--on", "arena", "--kwy", "/proc/x.kwy"),
        ("referee", "--kwy", "/proc/x.kwy"),
        ("demonstrate", "--on", "arena", "--out", "/proc/x.csv"),
        ("summarize", "A", "--out", "/proc/x.json"),
        ("sets", "A", "--out", "/proc/x.csv"),
        ("train", "--out", "/proc/x"),
        ("experiment", "paper", "--out", "/proc/x"),
        ("record", "--out", "/proc/x.gz"),
        ("server", "--fake", "--folder", "/proc/x"),
    ],
)
@pytest.mark.skipif(not Path("/proc/self").exists(), reason="no /proc here")
def test_a_place_that_takes_no_files_is_refused_before_playing(arguments: tuple[str, ...]) -> None:
    result = call(*arguments)
    assert result.exit_code == 1 and result.stdout == ""
    assert result.stderr.startswith("Error: /proc/x") and "cannot be written" in result.stderr
    assert result.stderr.count("\n") == 1


def test_what_cannot_be_stored_is_shown_and_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "fsync", full)
    rules, arff, table = tmp_path / "rules.json", tmp_path / "a.arff", tmp_path / "a.csv"
    learned = call("summarize", "A", "--out", rules, "--arff", arff)
    assert learned.exit_code == 1 and "-> Action = " in learned.stdout
    said = [f"Error: {path} was not written: No space left on device" for path in (rules, arff)]
    assert learned.stderr.splitlines() == said
    described = call("sets", "A", "--out", table, "--json")
    assert described.exit_code == 1 and json.loads(described.stdout)["episodes"] == 20
    assert f"{table} was not written: No space left" in described.stderr
    assert not list(tmp_path.iterdir())


def test_one_file_that_fails_costs_no_other(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        deliver("result", (tmp_path / "a", full), (None, full), (tmp_path / "b", lambda path: path.write_text("kept")))
    out, err = capsys.readouterr()
    assert out == "result\n" and err == f"Error: {tmp_path / 'a'} was not written: No space left on device\n"
    assert (tmp_path / "b").read_text() == "kept"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_a_result_that_cannot_be_printed_is_stored_all_the_same(tmp_path: Path) -> None:
    rules = tmp_path / "rules.json"
    command = [sys.executable, "-m", "rcss_hat", "summarize", "A", "--out", rules]
    with Path("/dev/full").open("w") as stdout:
        done = subprocess.run(command, stdout=stdout, stderr=subprocess.PIPE, text=True)
    assert (done.returncode, done.stderr) == (1, "Error: the result was not printed: No space left on device\n")
    assert json.loads(rules.read_text())["rules"]


@pytest.mark.compiled
def test_a_match_is_reported_although_its_log_cannot_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = tmp_path / "new" / "x.kwy"
    command = ("play", "--on", "arena", "--keepers", "hold", "--episodes", 3, "--seed", 1, "--kwy", log, "--json")
    good = call(*command)
    assert good.exit_code == 0 and len(read_kwy(log)) == 3
    before = log.read_bytes()
    monkeypatch.setattr(os, "fsync", full)
    bad = call(*command)
    assert bad.exit_code == 1 and json.loads(bad.stdout)["mean_s"] == json.loads(good.stdout)["mean_s"]
    assert bad.stderr == f"Error: {log} was not written: No space left on device\n" and log.read_bytes() == before


@pytest.mark.compiled
def test_training_and_evaluation_on_a_full_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "run"
    command = ("train", "--learner", "cmac", "--out", out, "--json")
    assert call(*command, "--hours", 0.05, "--seed", 1).exit_code == 0
    kept = {path.name: path.read_bytes() for path in out.iterdir()}
    with monkeypatch.context() as broken:
        broken.setattr("rcss_hat.system.files.os.fsync", full)
        evaluated = call("evaluate", out, "--episodes", 3, "--seed", 1, "--json")
        assert evaluated.exit_code == 1 and json.loads(evaluated.stdout)["episodes"] == 3
        assert f"{out / 'evaluations.jsonl'} was not written: No space left" in evaluated.stderr
    TrainingRun.open(out).extend(0.1)
    with monkeypatch.context() as broken:
        broken.setattr("rcss_hat.system.files.os.fsync", full)
        stopped = call("train", "--resume", "--out", out, "--json")
    assert (
        stopped.exit_code == 1
        and "episodes.csv was not written: No space left" in json.loads(stopped.stdout)["failure"]
    )
    assert "go on with: rcss-hat train --resume" in stopped.stderr
    assert (out / "episodes.csv").read_bytes() == kept["episodes.csv"]
    assert call("train", "--resume", "--out", out, "--json").exit_code == 0
    assert TrainingRun.open(out).done


@pytest.mark.compiled
def test_a_demonstration_on_a_full_disk_keeps_what_it_has(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "x.csv"
    command = ("demonstrate", "--on", "arena", "--teacher", "hold", "--seed", 1, "--out", out)
    assert call(*command, "--episodes", 2).exit_code == 0
    before = out.read_bytes()
    with monkeypatch.context() as broken:
        broken.setattr(os, "fsync", full)
        result = call(*command, "--episodes", 4, "--resume")
    assert result.exit_code == 1 and "2 episodes" in result.stdout
    assert "x.csv was not written: No space left on device (2 of 4 episodes are in" in result.stderr
    assert out.read_bytes() == before and len(DemonstrationSet.load(out)) == 2


def test_without_a_terminal_progress_is_a_line_now_and_then(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(common, "LINE_S", 0.001)
    said = ""
    with progress_bar("hand on arena", 20, "episodes") as update:
        update(5, "mean 10 s")
        while said.count("5 of 20 episodes, mean 10 s") < 2:  # the time limit of all tests ends this
            said += capsys.readouterr().err
        update(20)
    lines = (said + capsys.readouterr().err).splitlines()
    assert lines[0] == "hand on arena: 0 of 20 episodes (0 s)" and lines[-1].startswith("hand on arena: 20 of 20")
    with progress_bar("hidden", 20, hide=True) as update:
        update(20)
    assert capsys.readouterr().err == ""


@pytest.mark.compiled
def test_compiling_says_how_long_it_has_taken(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Compiling takes minutes where nothing is cached: what is compiled waits here until two more lines were said."""
    said: list[str] = []

    def compile_slowly(*_: object) -> None:
        said.extend(capsys.readouterr().err.splitlines())
        before = len(said)
        while len(said) < before + 2:  # the time limit of all tests ends this
            said.extend(capsys.readouterr().err.splitlines())

    monkeypatch.setattr(common, "LINE_S", 0.05)
    monkeypatch.setattr("rcss_hat.numeric.compiling.is_cached", lambda *_: False)
    for name in ("rcss_hat.stage.in_arena.prepare", "rcss_hat.experiments.execution.warm_up"):
        monkeypatch.setattr(name, compile_slowly)
    study = tmp_path / "study.toml"
    study.write_text("title = 'Short'\n[[condition]]\nname = 'one'\nhours = 0.01\nlearner = 'cmac'\n")
    for arguments, label in (
        (("play", "--on", "arena", "--keepers", "hold", "--episodes", 1), "hold on arena: 0 of 1 episodes"),
        (
            ("experiment", study, "--trials", 1, "--jobs", 1, "--no-report", "--out", tmp_path / "out"),
            "Short: 0 of 1 trials",
        ),
    ):
        said.clear()
        with contextlib.suppress(SystemExit):
            cli.main([str(a) for a in arguments], standalone_mode=False)
        said.extend(capsys.readouterr().err.splitlines())
        compiling = said.index("Compiling the players and the simulation (once per version, up to a minute) ...")
        assert sum(line.startswith(label) for line in said[compiling:]) >= 2, said
        assert said[-1].startswith(label.replace(": 0 ", ": 1 "))


# --- logs that grow while others play ---------------------------------------------------------------------------------
@contextlib.contextmanager
def others(task: Task) -> Iterator[Server]:
    """A server without a referee on which two teams play."""
    ports: dict[str, Value] = dict.fromkeys(("port", "coach_port", "olcoach_port"), 0)
    with running_server(parse_options(server_options(task, real=False, **ports, **REFEREED_BY_TRAINER))) as server:
        policy = load_policy("hold", task.keepers, task.takers, 1)
        policy.warm_up()

        def play() -> None:
            match = Match(task, ("127.0.0.1", server.port), 1, policy)
            asyncio.run(play_match(RunReport.of("x", "hold", task, 1), match, kick_off=False))

        teams = threading.Thread(target=play)
        teams.start()
        yield server
    teams.join()


@pytest.mark.compiled
def test_a_match_of_others_is_refereed_on_although_its_log_cannot_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = tmp_path / "x.kwy"
    begun = LiveLog.add

    def on_a_full_disk(self: LiveLog, text: str) -> None:
        monkeypatch.setattr(os, "fsync", full)
        begun(self, text)

    monkeypatch.setattr(LiveLog, "add", on_a_full_disk)
    with others(Task()) as server:
        where = ("--on", f"127.0.0.1:{server.port}", "--coach-port", server.coach_port)
        result = call("referee", *where, "--episodes", 2, "--seed", 1, "--kwy", log, "--json")
    assert result.exit_code == 1
    assert '"episodes": 2' in result.stdout
    assert f"Error: {log} was not written: No space left on device" in result.stderr
    assert read_kwy(log) == []  # what was begun is whole


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_a_relay_goes_on_although_its_transcript_cannot_be_written() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as server:
        server.bind(("127.0.0.1", 0))
        command = ("record", "--server", f"127.0.0.1:{server.getsockname()[1]}", "--port", 0, "--out", "/dev/full")
        result = call(*command, "--seconds", 0.01)
    assert result.exit_code == 1
    assert "Error: /dev/full was not written any further: No space left on device" in result.stderr
    assert "Traceback" not in result.output
