"""Ends of episodes that nobody is told of: noticed, said, and left out; on a good network there are none."""

from __future__ import annotations

import asyncio
import re

import pytest
from asyncio_dgram.aio import DatagramServer
from serving import Served, serving

from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.endings import Endings
from rcss_hat.keepaway.report import Episode, RunReport
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.params import Value
from rcss_hat.stage.match import Match, play_match
from rcss_hat.stage.processes import ProcessCrew
from rcss_hat.stage.relay import Relay

pytestmark = pytest.mark.compiled
TASK = Task()
_END = re.compile(rb"\(hear (\d+) referee training Keepaway 1\)")


class Hushing(Relay):
    """Loses every word of the ends with some numbers, counted from 1; or all but some players'.

    Of every dropped ball one player is told. Nothing else is lost.
    """

    def __init__(self, port: int, lost: set[int], told: int = 0) -> None:
        super().__init__("127.0.0.1", port, None)
        self.lost, self.told = lost, told
        self.ends: list[int] = []
        self.drops: set[bytes] = set()

    async def _deliver(self, data: bytes, stream: DatagramServer, address: tuple[str, int]) -> None:
        word = _END.match(data)
        if word is not None:
            if int(word[1]) not in self.ends:
                self.ends.append(int(word[1]))
                self.told_now = self.told
            if self.ends.index(int(word[1])) + 1 in self.lost:
                self.told_now -= 1
                if self.told_now < 0:
                    return
        if b" referee drop_ball)" in data:
            if data in self.drops:
                return
            self.drops.add(data)
        await stream.send(data, address)


def hold():  # type: ignore[no-untyped-def]
    policy = load_policy("hold", 3, 2, 1)
    policy.warm_up()
    return policy


def spans(episodes: list[Episode]) -> list[tuple[int, int]]:
    return [(episode.start, episode.end) for episode in episodes]


async def hushed(
    who: str, lost: set[int], episodes: int, told: int = 0, **changes: Value
) -> tuple[RunReport, list[Episode], Hushing]:
    """Play behind a relay that loses ends; returns the report, what the server has logged, and the relay."""
    report = RunReport.of("relay", "hold", TASK, 1)
    with serving(TASK, 1, **changes) as server:
        async with Hushing(server.port, lost, told) as relay:
            address = (relay.bind, relay.port)
            if who == "both":
                await play_match(report, Match(TASK, address, 1, hold(), True, episodes))
            elif who == "processes":
                crew = ProcessCrew(TASK, *address, 1, hold())
                await play_match(report, Match(TASK, address, 1, None, False, episodes, crew=crew))
            else:
                others = RunReport.of("localhost", "-", TASK, 1)
                beside = Match(TASK, server_address(server), 1, None)
                takers = asyncio.create_task(play_match(others, beside, kick_off=False))
                await play_match(report, Match(TASK, address, 1, hold(), False, episodes))
                takers.cancel()
                await takers
        return report, server.episodes(), relay


def server_address(server: Served) -> tuple[str, int]:
    return server.host, server.port


@pytest.mark.parametrize("who", ["both", "keepers", pytest.param("processes", marks=pytest.mark.slow)])
def test_an_end_that_nobody_hears_is_said_and_left_out(who: str) -> None:
    report, logged, _ = asyncio.run(hushed(who, {2, 5}, 5))
    assert report.failure is not None
    assert "2 ends of episodes were not heard by any player" in report.failure
    assert report.exit_code == 1
    log = spans(logged)
    assert spans(report.episodes) == [log[0], log[3], log[6]]
    report.stopped_on_purpose()
    assert report.exit_code == 1


@pytest.mark.parametrize("who", ["both", pytest.param("processes", marks=pytest.mark.slow)])
def test_what_one_hears_all_know(who: str) -> None:
    """The ends of episodes, and balls that were dropped, which moves players and ends nothing."""
    report, logged, relay = asyncio.run(hushed(who, {1, 2, 3}, 3, told=1, drop_ball_time=20))
    assert len(relay.drops) >= 3
    assert report.failure is None
    assert spans(report.episodes) == spans(logged)[:3]


@pytest.mark.parametrize(
    ("vision", "keepers", "takers", "field"), [(360, 3, 2, 20), pytest.param(90, 4, 3, 30, marks=pytest.mark.slow)]
)
def test_plain_matches_raise_no_alarm(vision: int, keepers: int, takers: int, field: int) -> None:
    task = Task(keepers, takers, field, field, vision)
    report = RunReport.of("fake", "hand", task, 1)
    policy = load_policy("hand", keepers, takers, 1)
    policy.warm_up()
    with serving(task, 1) as server:
        match = Match(task, server_address(server), 1, policy, episodes=20)
        asyncio.run(play_match(report, match))
    assert report.failure is None
    endings: Endings = match.crew.endings  # type: ignore[attr-defined]
    assert len(endings.cycles) >= 20
    assert endings.suspected == []
