"""The command: exit codes, what it prints, and that it stops cleanly."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest
from server_clients import PATIENCE, Client

from fake_server.cli import run
from fake_server.warm_up import warm_up

TRANSCRIPT = Path(__file__).parent.parent / "data" / "fake_server" / "transcript.jsonl.gz"


def test_help_shows_an_example(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["--help"]) == 0
    shown = capsys.readouterr()
    assert "fake-rcssserver --seed 1 server::keepaway=1" in shown.out
    assert shown.err == ""


@pytest.mark.parametrize(
    "arguments",
    [
        ["server::prt=1"],
        ["--nonsense"],
        ["replay"],
        ["replay", "a", "b"],
        ["replay", "a", "--port", "x"],
        ["replay", "-x"],
    ],
)
def test_wrong_usage_is_one_line_and_exit_code_2(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(arguments) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err.count("\n") == 1 and shown.err.startswith("fake-rcssserver: ")


def test_a_transcript_that_is_not_there_is_exit_code_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["replay", str(tmp_path / "none.jsonl")]) == 1
    assert "none.jsonl" in capsys.readouterr().err


class Process:
    """The command in a process of its own."""

    def __init__(self, *arguments: str) -> None:
        self.lines: list[str] = []
        self.process = subprocess.Popen(
            [sys.executable, "-m", "fake_server", *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )

    def line(self, start: str) -> str:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.lines.append(line.rstrip())
            if line.startswith(start):
                return self.lines[-1]
        raise AssertionError(f"no {start!r} in {self.lines}: {self.process.stderr.read()}")  # type: ignore[union-attr]

    def end(self) -> tuple[int, str, str]:
        out, err = self.process.communicate(timeout=PATIENCE)
        return self.process.returncode, out, err


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_server_says_its_seed_and_ports_and_stops_on_signals(tmp_path: Path, number: signal.Signals) -> None:
    warm_up(quiet=True)  # it would say so when it had to compile
    ports = [f"server::{name}=0" for name in ("port", "coach_port", "olcoach_port")]
    folders = [f"server::{kind}_log_dir={tmp_path}" for kind in ("game", "text", "keepaway")]
    server = Process("--seed", "5", *ports, *folders, "server::synch_mode=1", "server::keepaway=1")
    assert server.line("Simulator Random Seed") == "Simulator Random Seed: 5"
    port = int(server.line("Listening").split("monitors ")[1].split(",")[0])
    client = Client(port)
    assert client.ask("(init keepers (version 11))", r"\(init") == "(init l 1 before_kick_off)"
    assert server.line("A new") == "A new (v11) player (keepers 1) connected."
    server.process.send_signal(number)
    code, out, err = server.end()
    client.close()
    assert (code, err) == (0, "")
    assert "Server Killed. Exiting..." in out and "'keepers' vs null" in out
    assert sorted(path.suffix for path in tmp_path.iterdir()) == [".kwy", ".rcg", ".rcl"]
    assert all(path.name.endswith(f"-keepers_0-vs-null{path.suffix}") for path in tmp_path.iterdir())


def test_a_port_in_use_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    client = Client(1)
    port = client.socket.getsockname()[1]
    assert run([f"server::port={port}", "--quiet"]) == 1
    assert f"cannot listen on 127.0.0.1, UDP port {port} (server::port)" in capsys.readouterr().err
    client.close()


def test_replay_command() -> None:
    server = Process("replay", str(TRANSCRIPT), "--port", "0")
    port = int(server.line("Replaying").split("players ")[1].split(",")[0])
    client = Client(port)
    assert client.ask("(init keepers (version 11))", r"\(init") == "(init l 1 before_kick_off)"
    client.until(r"\(think\)")
    server.process.send_signal(signal.SIGINT)
    code, _, err = server.end()
    client.close()
    assert (code, err) == (0, "")


def test_help_loads_no_compiler() -> None:
    program = "import sys; from fake_server.cli import run; run(['--help']); print('numba' in sys.modules)"
    out = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    assert out.startswith("Usage: fake-rcssserver") and out.endswith("False\n")
