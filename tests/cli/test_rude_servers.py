"""What others send is printed escaped, whichever command asked for it."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner

from rcss_hat.cli.main import cli

RUDE = b"(error \x1b]0;your terminal is mine\x07)\0"


@pytest.fixture
def rude() -> Iterator[str]:
    """HOST:PORT of somebody who has one answer to everything."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as server:
        server.bind(("127.0.0.1", 0))

        def answer() -> None:
            while True:
                try:
                    data, address = server.recvfrom(10_000)
                except OSError:
                    return
                if data == b"end":
                    return
                server.sendto(RUDE, address)

        thread = threading.Thread(target=answer, daemon=True)
        thread.start()
        port = server.getsockname()[1]
        yield f"127.0.0.1:{port}"
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
            client.sendto(b"end", ("127.0.0.1", port))
        thread.join()


@pytest.mark.parametrize(
    "command",
    [
        ("play", "--on", "{}", "--episodes", "1"),
        ("keepers", "--on", "{}"),
        ("takers", "--on", "{}"),
        ("referee", "--on", "{}", "--coach-port", "{port}"),
        ("watch", "--on", "{}", "--no-open"),
        ("train", "--on", "{}", "--out", "run"),
    ],
    ids=lambda command: command[0],
)
def test_what_a_server_answers_is_printed_escaped(
    rude: str, command: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(cli, [part.format(rude, port=rude.split(":")[1]) for part in command])
    assert result.exit_code == 1, result.output
    assert "your terminal is mine" in result.output
    assert all(line.isprintable() for line in result.output.splitlines())
