"""A person who presses no key demonstrates on servers, at their speed; and nobody does."""

from __future__ import annotations

import asyncio
import contextlib
import json
import re
import sys
from collections.abc import AsyncIterator
from pathlib import Path

import aiohttp
import pytest
from click.testing import CliRunner

from rcss_hat.cli.main import cli
from rcss_hat.hat.demonstrations import DemonstrationSet
from rcss_hat.stage.servers import find_executable

BY_HAND = ("demonstrate", "--browser", "--no-open", "--out", "x.csv")


def invoke(*arguments: str) -> tuple[int, str]:
    result = CliRunner().invoke(cli, list(arguments))
    return result.exit_code, result.output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((*BY_HAND, "--language", "xx"), "there are en, de"),
        ((*BY_HAND, "--public-url", "example.org"), "such as https://study.example.org/keepaway/"),
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


async def link(process: asyncio.subprocess.Process) -> tuple[str, str]:
    """Wait for the link that a command prints; also without its token."""
    assert process.stderr is not None
    while True:
        line = (await process.stderr.readline()).decode()
        assert line, "the command ended"
        found = re.search(r"(http://127\.0\.0\.1:\d+)/\?token=\S+", line)
        if found is not None:
            return found[0], found[1]


@contextlib.asynccontextmanager
async def browser(url: str) -> AsyncIterator[aiohttp.ClientSession]:
    """A browser that has opened the link."""
    async with aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True)) as http:
        async with http.get(url) as response:
            assert response.status == 200
        yield http


async def frames(http: aiohttp.ClientSession, address: str, n: int | None = None) -> tuple[list[int], list[str]]:
    """Connect as the page does, start, and look at n frames, or all; returns their cycles, and what people were told.

    The person chooses to hold, now and then.
    """
    cycles, notices = [], []
    async with http.ws_connect(f"{address}/socket", headers={"Origin": address}) as page:
        async for message in page:
            told = json.loads(message.data)
            if told["type"] == "hello":
                await page.send_json({"type": "demonstration", "value": "start"})
            elif told["type"] == "frame":
                cycles.append(told["frame"]["time"])
                await page.send_json({"type": "press", "value": 0})
            elif told["type"] == "notice":
                notices.append(told["text"])
            if len(cycles) == n:
                break
    return cycles, notices


async def command(*arguments: str) -> asyncio.subprocess.Process:
    program = [sys.executable, "-m", "rcss_hat", "demonstrate", "--browser", "--no-open", *arguments]
    return await asyncio.create_subprocess_exec(*program, stderr=asyncio.subprocess.PIPE)


@pytest.mark.compiled
@pytest.mark.parametrize("stage", ["fake", "real"])
async def test_a_person_demonstrates_on_a_fast_server(stage: str, tmp_path: Path) -> None:
    if stage == "real" and find_executable() is None:
        pytest.skip("no rcssserver here")
    out = tmp_path / "fast.csv"
    process = await command("--on", stage, "--speed", "5", "--episodes", "2", "--out", str(out))
    url, address = await link(process)
    async with browser(url) as http:
        await frames(http, address)
    assert process.stderr is not None
    assert await process.wait() == 0, (await process.stderr.read()).decode()
    recorded = DemonstrationSet.load(out)
    assert len(recorded) == 2 and set(recorded.y) == {0}
    assert recorded.info.notes == "played 5 times as fast as real time"
    server = json.loads(out.with_suffix(".json").read_text())["server"]
    assert (server["synch_mode"], server["simulator_step"], server["send_step"]) == (False, 20, 30)
    assert all(1.0 < seconds < 60.0 for seconds in recorded.durations)  # of the game, not of the clock on the wall


@pytest.mark.compiled
async def test_nothing_is_played_while_nobody_is_there(tmp_path: Path) -> None:
    out = tmp_path / "mine.csv"
    process = await command("--on", "arena", "--speed", "5", "--episodes", "2", "--seed", "1", "--out", str(out))
    url, address = await link(process)
    await asyncio.sleep(3.0)  # more than both episodes take
    async with browser(url) as http:
        cycles, notices = await frames(http, address, 10)  # goes away in the middle of an episode
        assert cycles[0] <= 2 and "Begins in 3 ..." in notices
        await asyncio.sleep(1.5)
        later, _ = await frames(http, address)
        assert later[0] <= cycles[-1] + 40, "75 cycles would have been played"
    assert await process.wait() == 0
    assert len(DemonstrationSet.load(out)) == 2
