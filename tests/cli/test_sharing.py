"""Commands, one after the other, on one server that goes on."""

from __future__ import annotations

import contextlib
import json
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from click.testing import CliRunner, Result

from fake_server.options import parse_options
from fake_server.running import running_server
from fake_server.server import Server
from rcss_hat.cli.main import cli
from rcss_hat.hat.demonstrations import DemonstrationSet
from rcss_hat.keepaway.report import read_kwy
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.params import Value
from rcss_hat.stage.options import server_options
from rcss_hat.stage.place import Place
from rcss_hat.stage.stages import Part, open_stage
from rcss_hat.stage.terms import Terms

pytestmark = pytest.mark.compiled
TASK = Task()


def call(*arguments: object) -> Result:
    result = CliRunner().invoke(cli, [str(a) for a in arguments])
    assert result.exit_code == 0, result.output
    return result


@contextlib.contextmanager
def serving(folder: Path, **changes: Value) -> Iterator[tuple[Server, str]]:
    """A server that logs to ``x.kwy``, and where it is."""
    ports: dict[str, Value] = dict.fromkeys(("port", "coach_port", "olcoach_port"), 0)
    logs: dict[str, Value] = {
        "keepaway_log_dir": str(folder), "keepaway_log_fixed": True, "keepaway_log_fixed_name": "x",
    }  # fmt: skip
    with running_server(parse_options(server_options(TASK, real=False, **ports, **logs, **changes))) as server:
        yield server, f"127.0.0.1:{server.port}"


def test_training_evaluation_and_demonstration_follow_other_matches(tmp_path: Path) -> None:
    """Everything that is kept is what the server has logged; what was before, or between two matches, is in nothing."""
    run, demo, kwy = tmp_path / "run", tmp_path / "demo.csv", tmp_path / "played.kwy"
    with serving(tmp_path) as (_, where):
        call("play", "--on", where, "--keepers", "hold", "--episodes", 2, "--kwy", kwy)
        train = ("train", "--out", run, "--json")
        first = told(call(*train, "--on", where, "--learner", "cmac", "--hours", 0.002, "--seed", 1))
        call(*train, "--resume", "--hours", 0.004)
        evaluated = told(call("evaluate", run, "--on", where, "--episodes", 1, "--json"))
        demonstrate = ("demonstrate", "--on", where, "--teacher", "hold", "--seed", 1, "--out", demo)
        call(*demonstrate, "--episodes", 2)
        call(*demonstrate, "--episodes", 4, "--resume")
    demonstrated, trained = DemonstrationSet.load(demo).episodes, pd.read_csv(run / "episodes.csv")
    assert all(len(episode.states) for episode in demonstrated), "keepers have decided"
    cycles, before = [*trained["duration"]], first["episodes"]
    sessions = [
        [e.cycles for e in read_kwy(kwy)],
        cycles[:before],
        cycles[before:],
        [evaluated["mean_s"] * 10],
        [d.episode.cycles for d in demonstrated[:2]],
        [d.episode.cycles for d in demonstrated[2:]],
    ]
    logged = [episode.cycles for episode in read_kwy(tmp_path / "x.kwy")]
    for session in sessions:
        assert session
        logged = logged[after(session, logged) :]


def after(session: list[float], logged: list[int]) -> int:
    """Where a server's log goes on after the episodes of a session, which stand in it one after the other."""
    for k in range(len(logged)):
        if logged[k : k + len(session)] == pytest.approx(session):
            return k + len(session)
    raise AssertionError(f"{session} is not in {logged}")


def told(result: Result) -> dict[str, Any]:
    """What a command has printed as JSON; the server beside it prints, too."""
    [line] = [line for line in result.stdout.splitlines() if line.startswith("{")]
    return dict(json.loads(line))


# --- ending it for everybody ------------------------------------------------------------------------------------------
def test_keepers_end_the_match_for_takers_who_play_until_stopped(tmp_path: Path) -> None:
    reports = []

    def take(where: str) -> None:
        place = Place.parse(where)
        with open_stage(place, TASK, 1, None, Terms(takers=True, kick_off=False)) as stage:
            reports.append(stage.play(Part()))

    with serving(tmp_path, coach_w_referee=True) as (server, where):
        takers = threading.Thread(target=take, args=(where,))
        takers.start()
        ended = call(
            "keepers", "--on", where, "--policy", "hold", "--episodes", 2, "--kick-off", "--end-match", "--json"
        )
        takers.join()
        assert server.game.mode_name == "time_over"
    assert told(ended)["episodes"] == len(read_kwy(tmp_path / "x.kwy")) == 2
    [report] = reports
    report.stopped_on_purpose()  # as the command does without --episodes
    assert report.episodes and report.exit_code == 0


def test_ending_a_match_that_cannot_be_ended_is_a_failure(tmp_path: Path) -> None:
    with serving(tmp_path) as (_, where):
        stage = open_stage(Place.parse(where), TASK, 1, None, Terms(takers=True, kick_off=False))
        playing = threading.Thread(target=lambda: stage.play(Part()))
        playing.start()
        command = ("keepers", "--on", where, "--policy", "hold", "--episodes", "1", "--kick-off", "--end-match")
        refused = CliRunner().invoke(cli, command)
        playing.join()
    assert refused.exit_code == 1
    assert "it must run with server::coach_w_referee=1" in refused.output and "1 episodes" in refused.output
    assert CliRunner().invoke(cli, command[:5] + command[-2:]).exit_code == 2, "after how many episodes"
