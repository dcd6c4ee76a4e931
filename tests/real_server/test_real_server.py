"""Against a real rcssserver, where one is found on PATH (or named by RCSSSERVER)."""

from __future__ import annotations

import asyncio
import os

import numpy as np
import pytest

from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.report import Episode, RunReport
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.connection import Connection
from rcss_hat.stage.match import Match, play_match
from rcss_hat.stage.options import REFEREED_BY_TRAINER
from rcss_hat.stage.relay import Network, Relay
from rcss_hat.stage.servers import ServerProcess, find_executable
from rcss_hat.stage.terms import Terms
from rcss_hat.stage.trainer import TrainerClient

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
    asyncio.run(play_match(report, Match(task, (server.host, server.port), 1, policy, True, 5), server))
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
    asyncio.run(play_match(report, Match(task, (server.host, server.port), 3, policy, True, 100), server))
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
        await play_match(
            report, Match(task, (server.host, server.port), 3, policy, True, episodes), server, trainer=trainer
        )
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
            match = Match(task, (server.host, server.port), 1, policy, True, 2)
            await match.connect()
            await match.play(kick_off=True, server=server)
        server.clean()
        return match

    match = asyncio.run(run())
    assert len(match.finished_episodes()) == 2
    assert match.missed <= max(2, 0.01 * 5 * match.cycles)


def test_later_matches_on_one_server_are_counted_as_it_counts_them() -> None:
    """Also on one that plays on by itself (keepaway_start), which leaves no time between a foul and coming back."""
    task = Task()
    policy = load_policy("hold", 3, 2, 1)
    policy.warm_up()

    async def run() -> tuple[list[RunReport], set[tuple[int, int]]]:
        reports = []
        async with ServerProcess(task, None, EXECUTABLE, keepaway_start=3) as server:
            await server.answers()
            for seed in range(5):  # a team has eleven numbers: these are the first three, again and again
                reports.append(RunReport.of("real", "hold", task, seed))
                await play_match(reports[-1], Match(task, (server.host, server.port), seed, policy, True, 3))
            logged = {(episode.start, episode.end) for episode in server.episodes()}
        server.clean()
        return reports, logged

    reports, logged = asyncio.run(run())
    assert [report.failure for report in reports] == [None] * 5
    for report in reports:
        assert len(report.episodes) == 3
        assert {(episode.start, episode.end) for episode in report.episodes} <= logged
        assert all(episode.cycles < 300 for episode in report.episodes)
        assert (report.profile, report.speed) == ("19.0", "synch mode")


def test_a_match_that_is_running_is_left_alone() -> None:
    task = Task()
    policy = load_policy("hold", 3, 2, 1)
    policy.warm_up()

    async def run() -> tuple[RunReport, RunReport]:
        first, second = (RunReport.of("real", "hold", task, seed) for seed in (1, 2))
        async with ServerProcess(task, None, EXECUTABLE) as server:
            await server.answers()
            address = (server.host, server.port)
            begun = asyncio.Event()
            running = asyncio.create_task(
                play_match(first, Match(task, address, 1, policy, True, 10**6), on_episode=lambda *_: begun.set())
            )
            await begun.wait()
            await play_match(second, Match(task, address, 2, policy, True, 1))
            running.cancel()
            await running
        server.clean()
        return first, second

    first, second = asyncio.run(run())
    assert second.failure is not None and "a match is running" in second.failure
    assert first.failure == "interrupted" and first.episodes


def test_keepers_end_the_match_for_everybody() -> None:
    task = Task()
    policy = load_policy("hold", 3, 2, 1)
    policy.warm_up()
    keepers, takers = (RunReport.of("real", name, task, 1) for name in ("hold", "-"))

    async def run() -> int:
        async with ServerProcess(task, None, EXECUTABLE, coach_w_referee=True) as server:
            await server.answers()
            address = (server.host, server.port)
            playing = asyncio.create_task(play_match(takers, Match(task, address, 1, None), kick_off=False))
            terms = Terms(ends_match=True)
            await play_match(keepers, Match(task, address, 1, policy, False, 2, terms))
            await playing
            logged = len(server.episodes())
        server.clean()
        return logged

    assert asyncio.run(run()) == 2, "nothing is logged after the keepers' last episode"
    assert (keepers.failure, takers.failure) == (None, "interrupted")  # by who ended it, not by a fault


@pytest.mark.parametrize("synch_mode", [True, False])
@pytest.mark.parametrize(
    "network", [Network(loss=0.02, double=0.2, reorder=0.1, delay=0.02, seed=4), Network(loss=0.1, delay=0.05, seed=5)]
)
def test_what_a_bad_network_leaves_is_counted_as_the_server_does(network: Network, synch_mode: bool) -> None:
    """Or the command says what is missing, and fails."""
    task = Task()
    policy = load_policy("hold", 3, 2, 1)
    policy.warm_up()
    report = RunReport.of("relay", "hold", task, 1)

    async def run() -> list[Episode]:
        async with ServerProcess(task, None, EXECUTABLE, synch_mode=synch_mode) as server:
            await server.answers()
            async with Relay(server.host, server.port, None, network=network) as relay:
                await play_match(report, Match(task, (relay.bind, relay.port), 1, policy, True, 2))
            logged = server.episodes()
        server.clean()
        return logged

    logged = [(episode.start, episode.end) for episode in asyncio.run(run())]
    counted = [(episode.start, episode.end) for episode in report.episodes]
    assert report.failure is None or "not heard by any player" in report.failure
    assert counted == logged[:2] if report.failure is None else set(counted) < set(logged)
