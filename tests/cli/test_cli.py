"""The commands as a person types them: output, files, exit codes."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from fake_server.options import parse_options
from fake_server.running import running_server
from rcss_hat.cli.main import COMMANDS, cli
from rcss_hat.keepaway.report import read_kwy
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.options import REFEREED_BY_TRAINER, server_options

pytestmark = pytest.mark.compiled


def invoke(*arguments: str) -> Result:
    return CliRunner().invoke(cli, arguments)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_of_every_command_shows_an_example(name: str) -> None:
    result = invoke(name, "--help")
    assert result.exit_code == 0
    assert "Example:" in result.output
    assert f"rcss-hat {name}" in result.output


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        ("paly", "no such command 'paly'; did you mean 'play'?"),
        ("play --kepers hand", "No such option '--kepers'. (Did you mean one of: '--keepers', '--takers'?)"),
        ("play --on arean", "HOST:PORT, for example localhost:6000; did you mean 'arena'?"),
        ("play --on arena --keepers hnad", "(policies in Python are written module:object); did you mean 'hand'?"),
        ("train --method prp --out x", "'chat', 'replay'; did you mean 'ppr'?"),
        ("experiment papr", "or give a TOML file of the same form; did you mean 'paper'?"),
        ("sets b-fast", "there are A, B, B-fast, B-limited, C; did you mean 'B-fast'?"),
        ("summarize nofile.csv", "Error: nofile.csv: there is no such demonstration"),
        ("train --method replay --demonstrations no.csv --out x", "no.csv: there is no such demonstration"),
        ("play --on arena --keepers mine.py:policy", "Invalid value for --keepers: there is no file 'mine.py'"),
    ],
)
def test_what_is_mistyped_is_suggested_and_what_was_named_is_named(typed: str, said: str) -> None:
    result = invoke(*typed.split())
    assert result.exit_code in (1, 2)
    assert result.stderr.rstrip().endswith(said)


def test_help_needs_no_compiler() -> None:
    code = "import sys; from rcss_hat.cli.main import main; sys.argv = ['rcss-hat', '--help']\n"
    code += "try:\n    main()\nexcept SystemExit:\n    pass\nprint('numba' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "False"
    assert "demonstrate" in done.stdout


def test_play_in_the_arena_prints_one_json_object(tmp_path: Path) -> None:
    kwy = tmp_path / "match.kwy"
    result = invoke(
        "play", "--on", "arena", "--keepers", "hand", "--episodes", "5", "--seed", "3", "--kwy", str(kwy), "--json"
    )
    assert result.exit_code == 0, result.output
    summary = json.loads(result.stdout)
    assert {"episodes", "mean_s", "ci95_s", "out", "taken", "cycles", "wall_s", "cycles_per_s"} <= summary.keys()
    assert summary["episodes"] == 5
    assert summary["out"] + summary["taken"] == 5
    assert [e.cycles for e in read_kwy(kwy)] == [e.cycles for e in read_kwy(kwy)]
    assert len(read_kwy(kwy)) == 5


def test_a_policy_of_a_file_plays_and_its_faults_are_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    strangers = Path("strangers.py")  # a line for people is not longer than 200 characters
    strangers.write_text(
        "def near(state, info):\n    return int(state[3] < 4.0)\ndef none(state, info):\n    return {}[0]\n"
    )
    play = ("play", "--on", "arena", "--episodes", "3", "--seed", "3", "--keepers")
    result = invoke(*play, f"{strangers}:near", "--json")
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["keepers"] == f"{strangers}:near"
    many = invoke(*play, f"{strangers}:near", "--matches", "2", "--json")
    assert json.loads(many.stdout)["episodes"] == 6
    result = invoke(*play, f"{strangers}:none")
    assert result.exit_code == 1
    assert "ended early: the policy strangers.py:none failed: KeyError: 0 (" in result.output
    assert "strangers.py, line 4)" in result.output
    result = invoke(*play, f"{strangers}:nothing")
    assert result.exit_code == 2 and "has no 'nothing'; it has near, none" in result.output


def test_takers_of_a_file_play_the_same_game_everywhere(tmp_path: Path) -> None:
    strangers = tmp_path / "takers.py"
    strangers.write_text(
        "def chase(state, info):\n    return 1 if info['taker'] == 1 else 2\ndef wild(state, info):\n    return 4\n"
    )
    play = ("play", "--keepers", "random", "--episodes", "3", "--seed", "3")
    logs = []
    for place, takers in (("arena", "chase"), ("fake", "chase"), ("arena", "hand")):
        kwy = tmp_path / f"{place}-{takers}.kwy"
        spec = takers if takers == "hand" else f"{strangers}:{takers}"
        result = invoke(*play, "--on", place, "--takers", spec, "--kwy", str(kwy), "--json")
        assert result.exit_code == 0, result.output
        assert json.loads(result.stdout)["takers"] == spec
        logs.append([(e.start, e.end, e.reason) for e in read_kwy(kwy)])
    assert logs[0] == logs[1] != logs[2]
    result = invoke(*play, "--on", "arena", "--takers", f"{strangers}:wild")
    assert result.exit_code == 1 and "returned action 4; legal are a taker's 0 (hand-coded), 1" in result.output
    result = invoke(*play, "--on", "arena", "--takers", "rules.json")
    assert result.exit_code == 2 and "'rules.json' is no policy of takers; there is hand, and" in result.output


def test_play_on_the_fake_server_is_the_same_game(tmp_path: Path) -> None:
    files = [tmp_path / "arena.kwy", tmp_path / "fake.kwy"]
    for stage, kwy in zip(("arena", "fake"), files, strict=True):
        result = invoke(
            "play", "--on", stage, "--keepers", "random", "--episodes", "4", "--seed", "9", "--kwy", str(kwy)
        )
        assert result.exit_code == 0, result.output
        assert "4 episodes, mean" in result.output
    assert files[0].read_text() == files[1].read_text()


def test_play_with_a_trainer_as_referee(tmp_path: Path) -> None:
    kwy = tmp_path / "match.kwy"
    arguments = ("--keepers", "hold", "--episodes", "2", "--seed", "1", "--kwy", str(kwy))
    result = invoke("play", "--on", "fake", "--referee", "trainer", *arguments)
    assert result.exit_code == 0, result.output
    episodes = read_kwy(kwy)
    assert [e.number for e in episodes] == [1, 2]
    assert episodes[1].start == episodes[0].end


def test_referee_writes_the_log_of_a_match_of_others(tmp_path: Path) -> None:
    kwy = tmp_path / "match.kwy"
    ports = {"port": 0, "coach_port": 0, "olcoach_port": 0}
    options = parse_options(server_options(Task(), real=False, **ports, **REFEREED_BY_TRAINER))
    with running_server(options) as server:
        port = str(server.port)
        teams = [subprocess.Popen([sys.executable, "-m", "rcss_hat", team, "--on", f"localhost:{port}"],
                                  stdout=subprocess.DEVNULL) for team in ("keepers", "takers")]  # fmt: skip
        result = invoke("referee", "--on", f"127.0.0.1:{port}", "--coach-port", str(server.coach_port),
                        "--episodes", "2", "--kwy", str(kwy))  # fmt: skip
        for team in teams:
            team.terminate()
            team.wait()
    assert result.exit_code == 0, result.output
    assert "2 episodes" in result.output
    assert kwy.read_text().startswith("# Keepers: 3\n")
    assert len(read_kwy(kwy)) == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("play", "--size", "3x2"), "KEEPERSvTAKERS, for example 3v2"),
        (("play", "--on", "nowhere"), "not HOST:PORT, for example localhost:6000"),
        (("play", "--keepers", "clever"), "none of hold, random, hand"),
        (("play", "--episodes", "0"), "0 is not in the range"),
        (("play", "--on", "arena", "--referee", "trainer"), "a trainer referees on a server, not in the arena"),
        (("demonstrate", "--out", "x.csv", "--teacher", "A"), "use --on arena"),
        (("demonstrate", "--out", "x.csv", "--browser", "--actions", "hold,pass7"), "there are hold, pass1, pass2"),
        (("summarize",), "Missing argument"),
    ],
)
def test_wrong_usage_says_what_would_be_right(arguments: tuple[str, ...], message: str) -> None:
    result = invoke(*arguments)
    assert result.exit_code == 2
    assert message in result.output
    assert "Traceback" not in result.output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("play", "--on", "real", "--executable", "/no/such/rcssserver"), "--executable PATH, or --on fake"),
        (("summarize", "no-such.csv"), "no-such"),
        (("server", "--real", "--executable", "/no/such/rcssserver"), "or --fake"),
    ],
)
def test_failures_are_one_line_and_exit_code_1(arguments: tuple[str, ...], message: str) -> None:
    result = invoke(*arguments)
    assert result.exit_code == 1
    assert message in result.output
    assert "Traceback" not in result.output


def test_from_demonstration_to_a_playing_decision_list(tmp_path: Path) -> None:
    demo, rules = tmp_path / "demo.csv", tmp_path / "rules.json"
    result = invoke(
        "demonstrate", "--on", "fake", "--teacher", "hand", "--episodes", "6", "--seed", "1", "--out", str(demo)
    )
    assert result.exit_code == 0, result.output
    again = tmp_path / "again.csv"
    assert invoke("demonstrate", "--on", "arena", "--episodes", "6", "--seed", "1", "--out", str(again)).exit_code == 0
    assert demo.read_text() == again.read_text()
    result = invoke("summarize", str(demo), "--out", str(rules), "--describe")
    assert result.exit_code == 0, result.output
    assert "-> Action = " in result.output
    assert "cross-validation" in result.output
    result = invoke("play", "--on", "arena", "--keepers", str(rules), "--episodes", "3", "--seed", "2")
    assert result.exit_code == 0, result.output
    assert "3 episodes" in result.output


def test_a_demonstration_is_not_overwritten_but_resumed(tmp_path: Path) -> None:
    demo = str(tmp_path / "demo.csv")
    arguments = ("demonstrate", "--on", "arena", "--teacher", "A", "--seed", "1", "--out", demo)
    assert invoke(*arguments, "--episodes", "2").exit_code == 0
    refused = invoke(*arguments, "--episodes", "4")
    assert refused.exit_code == 1
    assert "exists already" in refused.output
    resumed = invoke(*arguments, "--episodes", "4", "--resume", "--json")
    assert resumed.exit_code == 0, resumed.output
    assert json.loads(resumed.stdout)["episodes"] == 4


def test_a_list_for_another_size_is_refused(tmp_path: Path) -> None:
    from rcss_hat.hat.decision_list import PAPER_RULES

    rules = tmp_path / "rules.json"
    PAPER_RULES.save(rules)
    result = invoke("play", "--on", "arena", "--size", "4v3", "--keepers", str(rules))
    assert result.exit_code == 2
    assert "for 3v2; the task is 4v3" in result.output
