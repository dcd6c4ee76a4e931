"""Servers that take their seed from the clock never start in the same second."""

from __future__ import annotations

import asyncio
import time
from pathlib import Path

import pytest

from rcss_hat.keepaway.task import Task
from rcss_hat.stage import seconds
from rcss_hat.stage.servers import ServerProcess


@pytest.fixture(autouse=True)
def _record_of_this_test(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "second"
    monkeypatch.setattr(seconds, "record_path", lambda: path)
    return path


@pytest.fixture
def clock_seeded(tmp_path: Path) -> str:
    """A stand-in for rcssserver, which says a seed as the original does, and waits to be stopped."""
    program = tmp_path / "rcssserver"
    program.write_text("#!/bin/sh\necho Simulator Random Seed: $(date +%s)\nexec sleep 60\n")
    program.chmod(0o755)
    return str(program)


async def seed_of(executable: str, folder: Path) -> int:
    folder.mkdir()
    server = ServerProcess(Task(), None, executable, folder)
    await server.start()
    await server.stop()
    assert server.random_seed is not None
    assert f"Seed: {server.random_seed}\n" in (folder / "console.log").read_text()
    return int(server.random_seed)


async def test_servers_that_are_started_at_once_have_different_seeds(clock_seeded: str, tmp_path: Path) -> None:
    seeds = await asyncio.gather(*(seed_of(clock_seeded, tmp_path / str(k)) for k in range(3)))
    assert len(set(seeds)) == 3


async def test_the_second_of_the_last_server_is_over_before_the_next_one_starts(_record_of_this_test: Path) -> None:
    taken = []
    for _ in range(2):
        async with seconds.second_of_its_own() as say:
            taken.append(int(time.time()))
            say(taken[-1])
    assert taken[1] > taken[0] and int(_record_of_this_test.read_text()) == taken[1]


@pytest.mark.parametrize("text", ["", "x", "99999999999", "-5"])
async def test_a_record_that_cannot_be_is_not_waited_for(_record_of_this_test: Path, text: str) -> None:
    _record_of_this_test.write_text(text)
    begun = time.monotonic()
    async with seconds.second_of_its_own():
        assert time.monotonic() - begun < 1.0
