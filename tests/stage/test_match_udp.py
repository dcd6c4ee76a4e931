from __future__ import annotations

import asyncio
import gzip
import json
import signal
import socket
from pathlib import Path

import pytest
from serving import serving

from fake_server.options import parse_options
from fake_server.running import running_server
from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.report import Episode, RunReport
from rcss_hat.keepaway.task import Task
from rcss_hat.simulation.keepaway import TURNOVER_TIME
from rcss_hat.stage.connection import Connection, ServerGone
from rcss_hat.stage.match import Match, play_match
from rcss_hat.stage.monitor import Monitor
from rcss_hat.stage.options import server_options
from rcss_hat.stage.relay import Relay
from rcss_hat.stage.servers import ServerFailed, ServerProcess, free_ports

pytestmark = pytest.mark.compiled
TASK = Task()


def empty_report() -> RunReport:
    return RunReport("fake", "hold", "hand", TASK.size, TASK.field, TASK.vision, 1)


def warm_policy(name: str = "hold"):  # type: ignore[no-untyped-def]
    policy = load_policy(name, 3, 2, 1)
    policy.warm_up()
    return policy


def test_a_match_on_a_server_of_our_own() -> None:
    report, told = empty_report(), []
    server = ServerProcess(TASK, 1)
    match = Match(TASK, (server.host, server.port), 1, warm_policy(), True, 3)
    asyncio.run(play_match(report, match, server, on_episode=lambda episode: told.append(episode.number)))
    server.clean()
    assert report.failure is None
    assert [e.number for e in report.episodes] == [1, 2, 3]
    assert all(e.reason in "ot" for e in report.episodes)
    assert told == [1, 2, 3]
    assert report.cycles >= report.episodes[-1].end


def test_a_server_that_dies_is_named_and_nothing_is_lost() -> None:
    report = empty_report()
    server = ServerProcess(TASK, 1)

    def kill(episode: Episode) -> None:
        if episode.number == 2:
            assert server._process is not None
            server._process.send_signal(signal.SIGKILL)

    match = Match(TASK, (server.host, server.port), 1, warm_policy(), True, 50)
    asyncio.run(play_match(report, match, server, on_episode=kill))
    server.clean()
    assert report.failure is not None
    assert "server" in report.failure
    assert report.exit_code == 1
    assert len(report.episodes) >= 2


def test_no_server_is_a_clear_error() -> None:
    async def connect() -> None:
        await Connection("127.0.0.1", free_ports(1), "keeper 1").open(b"(init keepers (version 11))\0", attempts=2)

    with pytest.raises(ServerGone, match="keeper 1: no server answers at 127"):
        asyncio.run(connect())


def test_an_unknown_host_is_a_clear_error() -> None:
    async def connect() -> None:
        await Connection("no-such-host.invalid", 6000, "keeper 1").open(b"(init k)\0", attempts=1)

    with pytest.raises(ServerGone, match="no-such-host"):
        asyncio.run(connect())


def test_a_wrong_option_ends_the_server_and_the_match_says_why() -> None:
    report = empty_report()
    server = ServerProcess(TASK, 1, verbose="maybe")
    asyncio.run(play_match(report, Match(TASK, (server.host, server.port), 1, warm_policy(), True, 1), server))
    server.clean()
    assert report.failure is not None
    assert "exit code 2" in report.failure
    assert "verbose" in report.failure


def test_a_full_team_is_refused_with_the_servers_words() -> None:
    with running_server(
        parse_options(server_options(TASK, real=False, port=0, coach_port=0, olcoach_port=0))
    ) as server:
        server_address = ("127.0.0.1", server.port)
        names = [b"(init one (version 11))\0", b"(init two (version 11))\0"]
        sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in names]
        for client, name in zip(sockets, names, strict=True):
            client.settimeout(5.0)
            client.sendto(name, server_address)
            assert client.recv(100).startswith(b"(init ")
        report = empty_report()
        asyncio.run(play_match(report, Match(TASK, server_address, 1, warm_policy(), False, 1), kick_off=False))
        for client in sockets:
            client.close()
    assert report.failure is not None
    assert "no_more_team" in report.failure


def test_a_match_in_real_time() -> None:
    twice_as_fast = {"synch_mode": False, "simulator_step": 50, "sense_body_step": 50, "send_step": 75}
    report = empty_report()
    with serving(TASK, 1, **twice_as_fast) as server:
        asyncio.run(play_match(report, Match(TASK, (server.host, server.port), 1, warm_policy(), True, 1)))
    assert report.failure is None
    assert [e.number for e in report.episodes] == [1]
    assert report.cycles >= report.episodes[0].end > TURNOVER_TIME
    assert 0 <= report.missed <= 5 * (report.cycles + 1)


async def _both_teams(address: tuple[str, int]) -> tuple[RunReport, RunReport]:
    keepers, takers = empty_report(), empty_report()
    await asyncio.gather(
        play_match(keepers, Match(TASK, address, 1, warm_policy(), False, 2), kick_off=True),
        play_match(takers, Match(TASK, address, 1, None, True, 2), kick_off=False),
    )
    return keepers, takers


def test_two_teams_launched_apart_meet_on_a_server() -> None:
    options = server_options(TASK, real=False, port=0, coach_port=0, olcoach_port=0, keepaway_logging=False)
    with running_server(parse_options(options)) as server:
        keepers, takers = asyncio.run(_both_teams(("127.0.0.1", server.port)))
    assert keepers.failure is None
    assert takers.failure is None
    assert [e.end for e in keepers.episodes] == [e.end for e in takers.episodes]


def test_waiting_for_players_who_never_come_has_an_end() -> None:
    options = server_options(TASK, real=False, port=0, coach_port=0, olcoach_port=0, keepaway_logging=False)

    async def wait(port: int) -> None:
        monitor = Monitor("127.0.0.1", port)
        await monitor.connect()
        try:
            await monitor.look(lambda look: look.counts == (3, 2), 0.5)
        finally:
            monitor.connection.close()

    with running_server(parse_options(options)) as server, pytest.raises(TimeoutError):
        asyncio.run(wait(server.port))


@pytest.mark.parametrize(("profile", "old"), [("19.0", False), ("11.1", True)])
def test_a_monitor_counts_the_players_on_servers_new_and_old(profile: str, old: bool) -> None:
    task = Task(profile=profile)
    options = server_options(task, real=False, port=0, coach_port=0, olcoach_port=0, keepaway_logging=False)

    async def count(port: int) -> bool:
        monitor = Monitor("127.0.0.1", port)
        await monitor.connect()
        await monitor.look(lambda look: look.counts == (1, 1), 10.0)
        await monitor.leave()
        return monitor.old

    with running_server(parse_options(options)) as server:
        clients = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2)]
        for client, team in zip(clients, (b"keepers", b"takers"), strict=True):
            client.settimeout(5.0)
            client.sendto(b"(init %s (version 11))\0" % team, ("127.0.0.1", server.port))
            assert client.recv(100).startswith(b"(init ")
        assert asyncio.run(count(server.port)) is old
        for client in clients:
            client.close()


def test_the_physics_of_11_1_are_played_too() -> None:
    report = empty_report()
    task = Task(profile="11.1")
    with serving(task, 1) as server:
        asyncio.run(play_match(report, Match(task, (server.host, server.port), 1, warm_policy(), True, 2)))
    assert report.failure is None
    assert [e.number for e in report.episodes] == [1, 2]


def test_a_server_that_plays_soccer_is_refused() -> None:
    report = empty_report()
    with serving(TASK, 1, keepaway=False) as server:
        asyncio.run(play_match(report, Match(TASK, (server.host, server.port), 1, warm_policy(), True, 2)))
    assert report.failure is not None
    assert "plays soccer, not Keepaway" in report.failure  # before anybody is kept waiting
    assert "server::keepaway=1" in report.failure


def test_the_relay_records_both_directions(tmp_path: Path) -> None:
    transcript = tmp_path / "match.jsonl.gz"
    report = empty_report()

    async def run() -> None:
        with serving(TASK, 1) as server:
            async with Relay(server.host, server.port, transcript) as relay:
                await play_match(report, Match(TASK, ("127.0.0.1", relay.port), 1, warm_policy(), True, 1))

    asyncio.run(run())
    assert report.failure is None
    with gzip.open(transcript, "rt") as file:
        entries = [json.loads(line) for line in file]
    assert {"keepers_1", "keepers_2", "keepers_3", "takers_1", "takers_2"} <= {e["client"] for e in entries}
    assert any(e["dir"] == "send" and e["text"].endswith("(done)") for e in entries)
    assert any(e["dir"] == "recv" and e["text"].startswith("(see ") for e in entries)
    end = report.episodes[0].end
    assert any(e["dir"] == "recv" and e["text"] == f"(hear {end} referee training Keepaway 1)" for e in entries)
    assert max(e["t_cycle"] for e in entries) >= end - 1  # cycles are told by sense_body, which comes after the hear


def test_a_missing_executable_is_a_clear_error() -> None:
    async def start() -> None:
        await ServerProcess(TASK, None, "/no/such/rcssserver").start()

    with pytest.raises(ServerFailed, match="cannot start /no/such/rcssserver"):
        asyncio.run(start())
