"""Joining, leaving and sharing a server: later matches are as good as the first, and what cannot be is refused."""

from __future__ import annotations

import asyncio
import contextlib
import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from fake_server.options import parse_options
from fake_server.running import running_server
from fake_server.server import Server
from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.decision import Decide, EpisodeEnd
from rcss_hat.keepaway.report import Episode, RunReport, read_kwy
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.params import Value
from rcss_hat.stage.match import Match, play_match
from rcss_hat.stage.options import REFEREED_BY_TRAINER, server_options
from rcss_hat.stage.processes import ProcessCrew
from rcss_hat.stage.terms import Terms
from rcss_hat.stage.trainer import TrainerClient

pytestmark = pytest.mark.compiled
TASK = Task()
PORTS: dict[str, Value] = dict.fromkeys(("port", "coach_port", "olcoach_port"), 0)


def policy(name: str = "hold"):  # type: ignore[no-untyped-def]
    team = load_policy(name, 3, 2, 1)
    team.warm_up()
    return team


class Counted:
    """Holds, and counts the decisions."""

    def __init__(self) -> None:
        self.decisions = 0

    def __call__(self, number: int) -> tuple[Decide, EpisodeEnd | None]:
        def decide(cycle: int, status: int, reward: float, state: object) -> int:
            self.decisions += 1
            return 0

        return decide, None


@contextlib.contextmanager
def serving(folder: Path | None = None, **changes: Value) -> Iterator[Server]:
    logs: dict[str, Value] = {"keepaway_logging": False}
    if folder is not None:
        logs = {"keepaway_log_dir": str(folder), "keepaway_log_fixed": True, "keepaway_log_fixed_name": "x"}
    with running_server(parse_options(server_options(TASK, real=False, **PORTS | logs | changes))) as server:
        yield server


def played(server: Server, keepers: object = None, episodes: int = 3, **terms: object) -> RunReport:
    report = RunReport.of("localhost", "hold", TASK, 1)
    address = ("127.0.0.1", server.port)
    asyncio.run(play_match(report, Match(TASK, address, 1, keepers or policy(), True, episodes, Terms(**terms))))  # type: ignore[arg-type]
    return report


def spans(episodes: list[Episode]) -> list[tuple[int, int]]:
    return [(episode.start, episode.end) for episode in episodes]


# --- one match after the other ----------------------------------------------------------------------------------------
@pytest.mark.parametrize("changes", [{}, {"keepaway_start": 20}], ids=["begins when told", "begins by itself, too"])
def test_later_matches_are_counted_as_the_server_counts_them(tmp_path: Path, changes: dict[str, Value]) -> None:
    reports, counted = [], Counted()
    with serving(tmp_path, **changes) as server:
        for _ in range(3):
            before = counted.decisions
            reports.append(played(server, counted))
            assert counted.decisions > before
    logged = spans(read_kwy(tmp_path / "x.kwy"))
    for report in reports:
        assert report.failure is None
        assert [episode.number for episode in report.episodes] == [1, 2, 3]
        assert set(spans(report.episodes)) <= set(logged)
        assert report.cycles < report.episodes[-1].end - report.episodes[0].start + 10  # nothing of before
    assert reports[0].episodes[0].start < reports[1].episodes[0].start < reports[2].episodes[0].start


def test_a_second_match_in_real_time(tmp_path: Path) -> None:
    fast: dict[str, Value] = {"synch_mode": False, "simulator_step": 50, "sense_body_step": 50, "send_step": 75}
    with serving(tmp_path, **fast) as server:
        reports = [played(server, episodes=1) for _ in range(2)]
    assert [report.failure for report in reports] == [None, None]
    assert set(spans(reports[1].episodes)) <= set(spans(read_kwy(tmp_path / "x.kwy")))


def test_a_second_match_with_a_trainer() -> None:
    reports = []
    with serving(**REFEREED_BY_TRAINER) as server:
        for _ in range(2):
            report = RunReport.of("localhost", "hold", TASK, 1, referee="trainer")
            trainer = TrainerClient(TASK, "127.0.0.1", server.coach_port, 1)
            address = ("127.0.0.1", server.port)

            async def match(report: RunReport = report, trainer: TrainerClient = trainer) -> None:
                await play_match(report, Match(TASK, address, 1, policy(), True, 2), trainer=trainer)  # noqa: B023

            asyncio.run(match())
            reports.append(report)
    assert [report.failure for report in reports] == [None, None]
    for report in reports:
        assert len(report.episodes) == 2
        assert all(10 < episode.cycles < 600 for episode in report.episodes)
        assert report.cycles < 1300


@pytest.mark.slow
def test_a_second_match_with_a_process_per_player() -> None:
    reports = []
    with serving() as server:
        for _ in range(2):
            report = RunReport.of("localhost", "hold", TASK, 1)
            address = ("127.0.0.1", server.port)
            asyncio.run(
                play_match(
                    report, Match(TASK, address, 1, None, True, 2, crew=ProcessCrew(TASK, *address, 1, policy()))
                )
            )
            reports.append(report)
    assert [report.failure for report in reports] == [None, None]
    assert [len(report.episodes) for report in reports] == [2, 2]
    assert reports[1].episodes[0].cycles < 600


async def both_teams(address: tuple[str, int]) -> list[RunReport]:
    reports = [RunReport.of("localhost", name, TASK, 1) for name in ("hold", "-")]
    await asyncio.gather(
        play_match(reports[0], Match(TASK, address, 1, policy(), False, 2), kick_off=True),
        play_match(reports[1], Match(TASK, address, 1, None, True, 2), kick_off=False),
    )
    return reports


def test_teams_launched_apart_meet_on_a_server_where_others_played() -> None:
    with serving() as server:
        played(server)
        keepers, takers = asyncio.run(both_teams(("127.0.0.1", server.port)))
    assert (keepers.failure, takers.failure) == (None, None)
    assert spans(keepers.episodes) == spans(takers.episodes)
    assert all(episode.cycles < 600 for episode in keepers.episodes)


def test_a_server_that_began_before_the_keepers_came_is_refused() -> None:
    """It has counted them, and would place another number for ever."""

    async def late(server: Server) -> RunReport:
        report = RunReport.of("localhost", "hold", TASK, 1)
        match = Match(TASK, ("127.0.0.1", server.port), 1, policy(), True, 1)
        take = match.crew.take

        async def take_slowly(k: int, known: bool) -> None:
            while k == 2 and server.game.mode_name == "before_kick_off":  # the time limit of all tests ends this
                await asyncio.sleep(0.05)
            await take(k, known)

        match.crew.take = take_slowly  # type: ignore[method-assign]
        await play_match(report, match)
        return report

    with serving(keepaway_start=0) as server:
        report = asyncio.run(late(server))
        again = played(server)
    assert report.failure is not None and re.search("began by itself with [0-2] of 3 keepers", report.failure)
    assert report.exit_code == 1 and not report.episodes
    # The third keeper's body may be there, when the refusal came too late for it: then two share a corner.
    shared, fewer = r"one corner for keepers \d and \d in cycle \d+; the server", "kicked off with 2 keepers and places"
    assert again.failure is not None and re.search(f"{shared}|{fewer}", again.failure)
    assert again.exit_code == 1


def test_numbers_given_up_before_the_match_are_taken_again() -> None:
    with serving() as server:
        for _ in range(2):
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
                client.settimeout(5.0)
                client.sendto(b"(init keepers (version 11))\0", ("127.0.0.1", server.port))
                reply, own = client.recvfrom(100)
                assert reply.startswith(b"(init ")
                client.sendto(b"(bye)\0", own)
                time.sleep(0.2)
        assert played(server).failure is None


# --- sharing ----------------------------------------------------------------------------------------------------------
def test_the_second_of_two_at_once_is_told() -> None:
    async def two(address: tuple[str, int]) -> tuple[RunReport, RunReport]:
        first, second = (RunReport.of("localhost", "hold", TASK, 1) for _ in range(2))
        begun = asyncio.Event()
        running = asyncio.create_task(
            play_match(first, Match(TASK, address, 1, policy(), True, 10**6), on_episode=lambda *_: begun.set())
        )
        await begun.wait()
        await play_match(second, Match(TASK, address, 2, policy(), True, 1))
        running.cancel()
        await running
        return first, second

    with serving() as server:
        first, second = asyncio.run(two(("127.0.0.1", server.port)))
    assert second.failure is not None
    assert "a match is running: 3 keepers and 2 takers" in second.failure
    assert second.exit_code == 1 and not second.episodes
    assert first.failure == "interrupted" and first.episodes


def test_a_team_that_is_left_alone_ends_and_does_not_count_what_comes() -> None:
    async def alone(address: tuple[str, int]) -> RunReport:
        keepers, takers = (RunReport.of("localhost", "hold", TASK, 1) for _ in range(2))
        left = asyncio.create_task(play_match(takers, Match(TASK, address, 1, None, True, 2), kick_off=False))
        await play_match(keepers, Match(TASK, address, 1, policy(), False, 10**6), kick_off=True)
        await left
        assert takers.failure is None
        return keepers

    with serving() as server:
        keepers = asyncio.run(alone(("127.0.0.1", server.port)))
    assert keepers.failure is not None
    assert "0 of 2 takers are left" in keepers.failure
    assert all(episode.cycles < 600 for episode in keepers.episodes)


# --- what is played ---------------------------------------------------------------------------------------------------
def test_what_nobody_typed_is_the_servers_and_the_report_says_so() -> None:
    with serving(visible_angle=90.0, keepaway_length=25.0, kick_rand=0.05) as server:
        report = played(server, episodes=1, typed=frozenset())
    assert report.failure is None
    assert (report.field, report.vision, report.taken_over) == ("25x20", 90, ("field", "vision"))
    assert (report.profile, report.speed, report.referee) == ("other (kick_rand 0.05)", "synch mode", "server")
    assert "the server's, not asked for: field, vision" in report.to_text()


MISMATCHES = {
    "vision": ({"visible_angle": 90.0}, "plays vision 90, not 360: give --vision 90"),
    "field": ({"keepaway_width": 25.0}, "plays field 20x25, not 20x20: give --field 20x25"),
    "profile": ({"kick_rand": 0.05}, r"plays profile other \(kick_rand 0.05\), not 19.0"),
}


@pytest.mark.parametrize("typed", MISMATCHES)
def test_what_somebody_typed_must_be_what_the_server_plays(typed: str) -> None:
    changes, message = MISMATCHES[typed]
    with serving(**changes) as server:  # type: ignore[arg-type]
        report = played(server, typed=frozenset({typed}))
    assert report.failure is not None
    assert report.exit_code == 1
    assert re.search(message, report.failure)


# --- the end ----------------------------------------------------------------------------------------------------------
def test_half_time_is_the_end_in_words() -> None:
    with serving(half_time=12) as server:
        report = played(server, episodes=100)
    assert report.exit_code == 1 and report.failure is not None
    assert "was stopped: half_time in cycle 120" in report.failure
    assert "server::half_time=-1" in report.failure
    assert report.episodes and report.episodes[-1].end <= 120


def test_another_play_mode_is_the_end_in_words() -> None:
    async def fouled(server: Server) -> RunReport:
        report = RunReport.of("localhost", "hold", TASK, 1)

        def foul(episode: Episode) -> None:
            if episode.number == 2:
                monitor.sendto(b"(dispfoul 0 0 1)\0", ("127.0.0.1", server.port))

        await play_match(report, Match(TASK, ("127.0.0.1", server.port), 1, policy(), True, 10**6), on_episode=foul)
        return report

    with serving() as server, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as monitor:
        monitor.sendto(b"(dispinit)\0", ("127.0.0.1", server.port))
        report = asyncio.run(fouled(server))
    assert report.failure is not None
    assert "was stopped: foul_r in cycle" in report.failure
    assert len(report.episodes) >= 2


def test_a_team_that_plays_until_stopped_ends_well_when_somebody_ends_the_match() -> None:
    async def end(address: tuple[str, int]) -> RunReport:
        takers = RunReport.of("localhost", "-", TASK, 1)
        keepers = RunReport.of("localhost", "hold", TASK, 1)
        playing = asyncio.create_task(play_match(takers, Match(TASK, address, 1, None, True, None), kick_off=False))
        await play_match(keepers, Match(TASK, address, 1, policy(), False, 3, Terms(ends_match=True)), kick_off=True)
        await playing
        assert keepers.failure is None
        return takers

    with serving(coach_w_referee=True) as server:
        takers = asyncio.run(end(("127.0.0.1", server.port)))
    takers.stopped_on_purpose()  # as the command does without --episodes
    assert takers.failure is None
    assert 1 <= len(takers.episodes) <= 3


LAUNCHER = """
import asyncio
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.servers import ServerProcess

async def run():
    async with ServerProcess(Task(), 1) as server:
        print(server._process.pid, flush=True)
        await asyncio.sleep(600)

asyncio.run(run())
"""


def is_running(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.skipif(sys.platform == "win32", reason="needs SIGKILL")
def test_a_server_ends_with_who_started_it() -> None:
    with subprocess.Popen([sys.executable, "-c", LAUNCHER], stdout=subprocess.PIPE, text=True) as launcher:
        assert launcher.stdout is not None
        server = int(launcher.stdout.readline())
        assert is_running(server)
        launcher.send_signal(signal.SIGKILL)
    deadline = time.monotonic() + 20.0
    while is_running(server) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not is_running(server)


# --- ending it for everybody ------------------------------------------------------------------------------------------
def test_the_match_ends_for_everybody_after_our_episodes(tmp_path: Path) -> None:
    with serving(tmp_path, coach_w_referee=True) as server:
        report = played(server, episodes=2, ends_match=True)
        assert server.game.mode_name == "time_over"
    assert len(report.episodes) == 2
    assert len(read_kwy(tmp_path / "x.kwy")) == 2, "nothing is logged after our last episode"


def test_a_server_that_lets_no_monitor_end_it_is_named() -> None:
    with serving() as server:
        report = played(server, episodes=1, ends_match=True)
    assert report.failure is not None and "server::coach_w_referee=1" in report.failure
    assert len(report.episodes) == 1
