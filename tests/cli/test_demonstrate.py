"""A person who presses no key demonstrates on servers, at their speed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from rcss_hat.cli.main import cli
from rcss_hat.hat.demonstrations import DemonstrationSet
from rcss_hat.team.servers import find_executable

BY_HAND = ("demonstrate", "--browser", "--no-open", "--out", "x.csv")


def invoke(*arguments: str) -> tuple[int, str]:
    result = CliRunner().invoke(cli, list(arguments))
    return result.exit_code, result.output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("demonstrate", "--out", "x.csv", "--speed", "5"), "--speed is for people: give it with --browser or"),
        (("demonstrate", "--out", "x.csv", "--teacher", "D"), "scripted persons are A, B, C, B-fast, B-limited"),
        ((*BY_HAND, "--on", "fake", "--speed", "3"), "multiples of 10 ms, from 20 ms; try 2.5 or 3.33"),
        ((*BY_HAND, "--on", "real", "--speed", "10"), "servers cannot play 10 times as fast"),
        (
            (*BY_HAND, "--on", "localhost:6000", "--speed", "5"),
            "localhost:6000 runs already, at its own speed; leave out --speed, and start it with server::synch_mode=0 "
            "server::simulator_step=20 server::sense_body_step=20 server::send_step=30 server::recv_step=2 "
            "('rcss-hat server --real-time --speed 5' does)",
        ),
        (("watch", "--on", "localhost:6000", "--speed", "2"), "server::simulator_step=50"),
        (("server", "--fake", "--speed", "5"), "--speed needs --real-time"),
        (("server", "--fake", "--real-time", "--speed", "3"), "try 2.5 or 3.33"),
    ],
)
def test_what_cannot_be_is_named(
    arguments: tuple[str, ...], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    code, output = invoke(*arguments)
    assert code == 2
    assert message in " ".join(output.split())
    assert not list(tmp_path.iterdir())


@pytest.mark.compiled
@pytest.mark.parametrize("stage", ["fake", "real"])
def test_a_person_demonstrates_on_a_fast_server(stage: str, tmp_path: Path) -> None:
    if stage == "real" and find_executable() is None:
        pytest.skip("no rcssserver here")
    out = tmp_path / "fast.csv"
    code, output = invoke(
        "demonstrate", "--browser", "--no-open", "--on", stage, "--speed", "5", "--episodes", "2", "--out", str(out)
    )
    assert code == 0, output
    assert "Demonstrate at http://127.0.0.1:" in output
    recorded = DemonstrationSet.load(out)
    assert len(recorded) == 2 and set(recorded.y) == {0}
    assert recorded.info.notes == "played 5 times as fast as real time"
    server = json.loads(out.with_suffix(".json").read_text())["server"]
    assert (server["synch_mode"], server["simulator_step"], server["send_step"]) == (False, 20, 30)
    assert all(1.0 < seconds < 60.0 for seconds in recorded.durations)  # of the game, not of the clock on the wall
