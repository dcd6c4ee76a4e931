"""What takes its time is said every few seconds, and what stands still is an end; on a clock nobody has to wait for."""

from __future__ import annotations

import asyncio
import selectors
from collections.abc import Coroutine
from dataclasses import dataclass, field
from typing import Any, TypeVar

import pytest

from fake_server.options import parse_options
from fake_server.running import running_server
from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.report import RunReport
from rcss_hat.keepaway.session import KeepawayPlayer
from rcss_hat.keepaway.task import Task
from rcss_hat.stage import terms
from rcss_hat.stage.connection import ServerGone
from rcss_hat.stage.crew import never
from rcss_hat.stage.match import Match, play_match
from rcss_hat.stage.options import pace_options, server_options
from rcss_hat.stage.processes import EVERY_S, News, _reporter
from rcss_hat.stage.relay import Relay
from rcss_hat.stage.servers import free_ports
from rcss_hat.stage.terms import Terms, reminding

TASK = Task()
T = TypeVar("T")


class _Jumping(selectors.SelectSelector):
    """Where nothing happens until a timer is due, time is at once what the timer waits for."""

    now = 0.0

    def select(self, timeout: float | None = None):  # type: ignore[no-untyped-def]
        self.now += timeout or 0.0
        return super().select(None if timeout is None else 0.0)


class _Jumps(asyncio.SelectorEventLoop):
    def __init__(self) -> None:
        self._jumping = _Jumping()
        super().__init__(self._jumping)

    def time(self) -> float:
        return self._jumping.now


def run(work: Coroutine[Any, Any, T]) -> T:
    with asyncio.Runner(loop_factory=_Jumps) as runner:
        return runner.run(work)


# --- a server that stands still ---------------------------------------------------------------------------------------
@dataclass
class Watched:
    """A crew of which only the clock is looked at."""

    seats: list[tuple[int, int]] = field(default_factory=lambda: [(0, 1), (1, 1)])
    first: KeepawayPlayer = field(default_factory=lambda: KeepawayPlayer("keepers", 3, 2, 1, never))


async def watched(cycles: list[int], step_s: float, **told: int) -> tuple[float, str, list[str]]:
    """Play some cycles, then none; returns when the match was ended (s), how, and what was said."""
    crew, said = Watched(), list[str]()
    match = Match(TASK, ("127.0.0.1", 6000), 1, None, terms=Terms(say=said.append), crew=crew)  # type: ignore[arg-type]
    match.gathering.told = told
    crew.first.mode = "play_on"

    async def play() -> None:
        for cycle in cycles:
            crew.first.cycle = cycle
            await asyncio.sleep(step_s)

    playing = asyncio.create_task(play())
    with pytest.raises(ServerGone) as ended:
        await match._watch_clock()
    playing.cancel()
    return asyncio.get_running_loop().time(), str(ended.value), said


def test_a_server_that_stands_still_is_noticed() -> None:
    when, how, said = run(watched(list(range(1, 1001)), 0.1))
    assert how == "the server at 127.0.0.1:6000 stands still in cycle 1000 for 30 s"
    assert when == pytest.approx(150.0), "looked at every 30 s; the last cycle was the one of 99.9 s"
    assert said == []


def test_a_slow_server_may_take_ten_cycles_for_one() -> None:
    when, how, _ = run(watched([1, 2, 3], 20.0, simulator_step=5000))
    assert how.endswith("stands still in cycle 3 for 50 s")
    assert when == pytest.approx(100.0)


def test_who_waits_for_a_kick_off_does_not_stand_still() -> None:
    async def waiting() -> list[str]:
        said = list[str]()
        match = Match(TASK, ("127.0.0.1", 6000), 1, None, terms=Terms(say=said.append), crew=Watched())  # type: ignore[arg-type]
        match.crew.first.mode = "before_kick_off"
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(100.0):
                await match._watch_clock()
        return said

    assert run(waiting()) == ["waiting for the kick-off at 127.0.0.1:6000 (--kick-off) ..."] * 3


class Frozen(Relay):
    """Lets no cycle through once an episode has ended; whoever asks is answered."""

    frozen = False

    async def _deliver(self, data, stream, address) -> None:  # type: ignore[no-untyped-def]
        self.frozen |= b"referee training Keepaway 1" in data
        if not (self.frozen and data.startswith((b"(sense_body", b"(see"))):
            await stream.send(data, address)


@pytest.mark.compiled
def test_a_match_on_a_server_that_stands_still_ends_with_what_was_played(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rcss_hat.stage.match.STANDSTILL", 0.4)
    report = RunReport.of("relay", "hold", TASK, 1)
    policy = load_policy("hold", 3, 2, 1)
    policy.warm_up()

    async def play(port: int) -> None:
        async with Frozen("127.0.0.1", port, None) as relay:
            await play_match(report, Match(TASK, (relay.bind, relay.port), 1, policy, True, 100))

    ports = dict.fromkeys(("port", "coach_port", "olcoach_port"), 0)
    fast = server_options(TASK, real=False, keepaway_logging=False, synch_mode=False, **ports, **pace_options(5.0))
    with running_server(parse_options(fast)) as server:
        asyncio.run(play(server.port))
    assert report.failure is not None and "stands still in cycle" in report.failure
    assert report.exit_code == 1 and report.episodes


def test_processes_say_where_they_are_also_where_cycles_are_slow() -> None:
    """Otherwise a match that goes on slowly would look like one that stands still."""
    now, told = 0.0, list[int]()

    class Pipe:
        def send(self, message: tuple[str, News]) -> None:
            told.append(message[1].cycle)

    player = KeepawayPlayer("keepers", 3, 2, 1, never)
    report = _reporter(Pipe(), lambda: now)  # type: ignore[arg-type]
    for cycle in range(10):
        player.cycle = cycle
        report(player)
        now += EVERY_S / 2.0
    assert told == [0, 2, 4, 6, 8]


# --- what is waited for -----------------------------------------------------------------------------------------------
def test_what_is_waited_for_is_said_every_five_seconds() -> None:
    said = list[tuple[float, str]]()
    counts = iter(range(9))

    async def wait() -> None:
        clock = asyncio.get_running_loop().time
        async with reminding(lambda text: said.append((clock(), text)), lambda: f"waiting, {next(counts)} are there"):
            await asyncio.sleep(17.0)
        await asyncio.sleep(10.0)  # nothing more is said

    run(wait())
    assert said == [(5.0, "waiting, 0 are there"), (10.0, "waiting, 1 are there"), (15.0, "waiting, 2 are there")]


@pytest.mark.parametrize(
    ("takers", "text"),
    [
        (False, "waiting for 3 keepers and 2 takers at {where}; 3 and 0 are there"),
        (True, "waiting for 3 keepers at {where}; 0 and 0 are there"),
    ],
)
@pytest.mark.compiled
def test_a_team_alone_says_whom_it_waits_for(takers: bool, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(terms, "REMINDER", 0.02)
    policy = None if takers else load_policy("hold", 3, 2, 1)

    async def alone(port: int) -> None:
        enough = asyncio.Event()

        def say(said: str) -> None:
            if said == text.format(where=f"127.0.0.1:{port}"):
                enough.set()

        match = Match(TASK, ("127.0.0.1", port), 1, policy, takers, 1, Terms(say=say))
        playing = asyncio.create_task(play_match(RunReport.of("x", "-", TASK, 1), match, kick_off=False))
        await enough.wait()  # the time limit of all tests ends this
        playing.cancel()
        await playing

    ports = dict.fromkeys(("port", "coach_port", "olcoach_port"), 0)
    with running_server(parse_options(server_options(TASK, real=False, keepaway_logging=False, **ports))) as server:
        asyncio.run(alone(server.port))


def test_who_waits_for_a_server_says_so_and_gives_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(terms, "REMINDER", 0.02)
    said, port = list[str](), free_ports(1)

    async def join() -> None:
        match = Match(TASK, ("127.0.0.1", port), 1, None, terms=Terms(say=said.append))
        opened = match.gathering.monitor.connection.open
        monkeypatch.setattr(
            match.gathering.monitor.connection, "open", lambda first: opened(first, attempts=2, pause=0.1)
        )
        await match.gathering.join()

    with pytest.raises(ServerGone, match=f"no server answers at 127.0.0.1:{port}"):
        asyncio.run(join())
    assert set(said) == {f"waiting for a server at 127.0.0.1:{port} ..."}
