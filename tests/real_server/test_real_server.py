"""Against a real rcssserver, where one is found on PATH (or named by RCSSSERVER)."""

from __future__ import annotations

import asyncio
import os

import numpy as np
import pytest

from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.report import RunReport
from rcss_hat.keepaway.task import Task
from rcss_hat.team.connection import Connection
from rcss_hat.team.match import Match, play
from rcss_hat.team.options import REFEREED_BY_TRAINER
from rcss_hat.team.servers import ServerProcess, find_executable
from rcss_hat.team.trainer import TrainerClient

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


@pytest.mark.parametrize("synch_mode", [True, False])
def test_a_trainer_of_ours_referees(synch_mode: bool) -> None:
    task = Task()
    policy = load_policy("random", 3, 2, 3)
    policy.warm_up()
    report = RunReport("real", "random", "hand", task.size, task.field, task.vision, 3)
    episodes = 60 if synch_mode else 2

    async def match() -> None:
        server = ServerProcess(task, None, EXECUTABLE, synch_mode=synch_mode, **REFEREED_BY_TRAINER)
        trainer = TrainerClient(task, server.host, server.port + 1, 3)
        await play(report, task, 3, policy, episodes, server, None, trainer=trainer)
        server.clean()

    asyncio.run(match())
    assert report.failure is None
    assert len(report.episodes) == episodes
    if synch_mode:
        assert abs(np.mean(report.durations_s) - 5.26) < 1.2


TRAINERS_COMMANDS = (
    "(eye on)", "(eye off)", "(ear on)", "(ear off)", "(eye maybe)", "(look)", "(team_names)", "(check_ball)",
    "(move (ball) 60 0)", "(check_ball)", "(move (ball) 1.5 -2 0 0.25 0.5)", "(look)", "(move (player a 1) -3 4 90)",
    "(move (player a 1) -5 6 30 0.1 0)", "(look)", "(move (player a 1) -5)", "(move (player nobody 3) 1 2)",
    "(recover)", "(say hello)", "(change_mode play_on)", "(change_mode play)", "(change_mode before_kick_off)",
    "(start)", "(change_player_type a 1 99)", "(change_player_type b 1 1)", "(nonsense)",
)  # fmt: skip


async def _replies(server: ServerProcess) -> list[bytes]:
    """What a trainer is told, command by command, on a server where one player has joined."""
    player, trainer = (
        Connection(server.host, server.port, "player"),
        Connection(server.host, server.port + 1, "trainer"),
    )
    told = [await player.open(b"(init a (version 11))\0"), await trainer.open(b"(init (version 11))\0")]
    while not (await trainer.receive()).startswith(b"(player_type (id 17)"):
        continue
    for command in TRAINERS_COMMANDS:
        await trainer.send(command.encode() + b"\0")
        reply = b""
        while not reply.startswith((b"(ok ", b"(error ", b"(warning ")):
            reply = await trainer.receive()
        told.append(reply)
    player.close()
    trainer.close()
    return told


def test_a_trainer_is_answered_as_by_the_original() -> None:
    async def ask(executable: str | None) -> list[bytes]:
        changes = {"synch_mode": False, "use_offside": False, "simulator_step": 10_000}  # nothing moves meanwhile
        async with ServerProcess(Task(), 1, executable, **REFEREED_BY_TRAINER, **changes) as server:
            await server.answers(300.0)
            replies = await _replies(server)
        server.clean()
        return replies

    original, ours = asyncio.run(ask(EXECUTABLE)), asyncio.run(ask(None))
    for command, theirs, mine in zip(("", "", *TRAINERS_COMMANDS), original, ours, strict=True):
        assert mine == theirs, command


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
