from __future__ import annotations

import asyncio
import functools
import os
import pty
import re
import signal
import socket
import sys
from pathlib import Path

import aiohttp
import pytest
from click.testing import CliRunner

from rcss_hat.cli.main import cli

LOG = Path(__file__).parents[1] / "data" / "viewer" / "sample-v5.rcg.gz"
COMMAND = (sys.executable, "-c", "from rcss_hat.cli.main import main; main()", "watch")


def invoke(*arguments: str) -> tuple[int, str]:
    result = CliRunner().invoke(cli, ["watch", *arguments])
    return result.exit_code, result.output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--on", "nowhere"], "HOST:PORT"),
        (["--on", "missing.rcg"], "there is no game log 'missing.rcg'"),
        (["--on", "arena", "--keepers", "nobody"], "'nobody' is none of"),
        (["--speed", "0"], "0.1"),
    ],
)
def test_wrong_usage_is_named(arguments: list[str], message: str) -> None:
    code, output = invoke(*arguments)
    assert code == 2 and message in output


def test_a_file_that_is_no_log_is_an_error_of_one_line(tmp_path: Path) -> None:
    path = tmp_path / "x.rcg"
    path.write_bytes(b"ULG\x03")
    code, output = invoke("--on", str(path))
    assert code == 1 and output.startswith("Error: ") and "game_log_version=5" in output and output.count("\n") == 1


def test_no_server_is_an_error_of_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    from rcss_hat.viewer import live

    monkeypatch.setattr(live, "MonitorSource", functools.partial(live.MonitorSource, patience=0.4))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    code, output = invoke("--on", f"127.0.0.1:{port}", "--no-open")
    assert code == 1 and f"Error: no server answers at 127.0.0.1:{port}" in output


async def test_a_log_is_served_until_interrupted() -> None:
    process = await asyncio.create_subprocess_exec(
        *COMMAND, "--on", str(LOG), "--no-open", stderr=asyncio.subprocess.PIPE
    )
    assert process.stderr is not None
    line = (await process.stderr.readline()).decode()
    found = re.search(r"http://127\.0\.0\.1:\d+/\?token=\S+", line)
    assert found is not None, line
    async with aiohttp.ClientSession() as http, http.get(found[0]) as response:
        assert response.status == 200 and "app.js" in await response.text()
    process.send_signal(signal.SIGINT)
    rest = (await process.stderr.read()).decode()
    assert await process.wait() == 0 and "Traceback" not in rest


async def test_a_log_is_shown_in_the_terminal_until_q() -> None:
    outer, inner = pty.openpty()
    process = await asyncio.create_subprocess_exec(
        *COMMAND, "--on", str(LOG), "--terminal", stdin=inner, stdout=inner, stderr=inner
    )
    os.close(inner)
    os.set_blocking(outer, False)
    text = ""
    async with asyncio.timeout(30.0):
        while "episode 1" not in text:
            await asyncio.sleep(0.02)
            try:
                text += os.read(outer, 65536).decode(errors="replace")
            except BlockingIOError:
                continue
        os.write(outer, b"q")
        assert await process.wait() == 0
    os.close(outer)
    assert "sample-v5.rcg.gz" in text


@pytest.mark.slow
async def test_a_match_on_the_fake_server_is_watched_to_its_end() -> None:
    process = await asyncio.create_subprocess_exec(
        *COMMAND, "--on", "fake", "--keepers", "hold", "--episodes", "1", "--seed", "1", "--no-open",
        stderr=asyncio.subprocess.PIPE,
    )  # fmt: skip
    _, errors = await process.communicate()
    text = errors.decode()
    assert process.returncode == 0, text
    assert "Watch at http://127.0.0.1:" in text and "1 episodes, mean" in text and "keepers hold" in text
