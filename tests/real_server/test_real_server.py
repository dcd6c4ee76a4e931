"""Against a real rcssserver, where one is found on PATH (or named by RCSSSERVER)."""

from __future__ import annotations

import asyncio
import os

import numpy as np
import pytest

from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.report import RunReport
from rcss_hat.keepaway.task import Task
from rcss_hat.team.match import Match, play
from rcss_hat.team.servers import ServerProcess, find_executable

EXECUTABLE = find_executable(os.environ.get("RCSSSERVER"))
pytestmark = [
    pytest.mark.compiled,
    pytest.mark.skipif(EXECUTABLE is None, reason="no rcssserver on PATH; name one by the variable RCSSSERVER"),
]


@pytest.mark.parametrize(("size", "vision"), [("3v2", 360), ("3v2", 90), ("4v3", 360)])
def test_a_match_in_synch_mode(size: str, vision: int) -> None:
    task = Task.parse(size, vision=vision)
    policy = load_policy("hand", task.keepers, task.takers, 1)
    policy.warm_up()
    report = RunReport("real", "hand", "hand", task.size, task.field, task.vision, 1)
    server = ServerProcess(task, None, EXECUTABLE)
    asyncio.run(play(report, task, 1, policy, 5, server, None))
    assert report.failure is None
    assert server.random_seed is not None
    server.clean()
    assert len(report.episodes) == 5
    assert report.missed == 0


def test_random_keepers_last_as_long_as_the_original_ones() -> None:
    task = Task()
    policy = load_policy("random", 3, 2, 3)
    policy.warm_up()
    report = RunReport("real", "random", "hand", task.size, task.field, task.vision, 3)
    server = ServerProcess(task, None, EXECUTABLE)
    asyncio.run(play(report, task, 3, policy, 100, server, None))
    server.clean()
    assert abs(np.mean(report.durations_s) - 5.26) < 0.9


def test_a_match_in_real_time_misses_nearly_no_cycle() -> None:
    task = Task()
    policy = load_policy("hand", 3, 2, 1)
    policy.warm_up()

    async def run() -> Match:
        async with ServerProcess(task, None, EXECUTABLE, synch_mode=False) as server:
            await server.answers()
            match = Match(task, server.host, server.port, 1, policy, True, 2)
            await match.connect()
            await match.play(kick_off=True, server=server)
        server.clean()
        return match

    match = asyncio.run(run())
    assert len(match.finished_episodes()) == 2
    assert match.missed <= max(2, 0.01 * 5 * match.cycles)
