"""A trainer as referee: the rules, its side of a recorded conversation, and whole matches."""

from __future__ import annotations

import asyncio
import contextlib
import gzip
import json
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from asyncio_dgram.aio import DatagramServer

from fake_server.options import parse_options
from fake_server.running import running_server
from fake_server.server import Server
from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.report import OUT, TAKEN, Episode, RunReport
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.protocol.params import Value
from rcss_hat.stage.connection import ServerGone
from rcss_hat.stage.match import Match, play_match
from rcss_hat.stage.options import REFEREED_BY_TRAINER, server_options
from rcss_hat.stage.processes import ProcessCrew
from rcss_hat.stage.refereeing import KeepawayRules, KeepawayTrainer, WrongServer
from rcss_hat.stage.relay import Relay
from rcss_hat.stage.trainer import TrainerClient, referee_match

TASK = Task()
RECORDED = Path(__file__).parents[1] / "data" / "stage" / "trainer.jsonl.gz"
FAR = (8.0, 8.0)
HERE, NEAR = (0.0, 0.0), (1.08, 0.0)


# --- the rules -------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("ball", "reason"),
    [((9.999, -9.999), None), ((10.0, 0.0), OUT), ((0.0, -10.0), OUT), ((-12.0, 3.0), OUT)],
)
def test_the_ball_must_be_inside(ball: tuple[float, float], reason: str | None) -> None:
    assert KeepawayRules(TASK).ending(ball, [FAR], [FAR]) == reason


def steps_until_taken(*takers: tuple[float, float], keeper: tuple[float, float] = FAR) -> int:
    rules = KeepawayRules(TASK)
    for step, taker in enumerate(takers, 1):
        if rules.ending(HERE, [keeper], [taker]) == TAKEN:
            return step
    return 0


def test_takers_need_four_steps_and_win_in_the_fifth() -> None:
    assert steps_until_taken(*[NEAR] * 6) == 5


def test_a_keeper_near_too_does_not_help() -> None:
    assert steps_until_taken(*[NEAR] * 6, keeper=NEAR) == 5


def test_a_loose_ball_neither_counts_nor_resets() -> None:
    assert steps_until_taken(NEAR, NEAR, FAR, FAR, NEAR, NEAR, FAR) == 7


def test_a_keeper_alone_resets() -> None:
    rules = KeepawayRules(TASK)
    for _ in range(4):
        assert rules.ending(HERE, [FAR], [NEAR]) is None
    rules.restart()
    for takers in ([NEAR], [NEAR], [NEAR], [FAR], [NEAR], [NEAR], [NEAR], [NEAR]):
        assert rules.ending(HERE, [NEAR], takers) is None
    assert rules.ending(HERE, [NEAR], [NEAR]) == TAKEN


def test_players_start_in_the_corners_and_the_middle() -> None:
    rules, rng = KeepawayRules(Task.parse("4v3", "30x20")), np.random.default_rng(1)
    firsts = set()
    for _ in range(50):
        keepers, takers = rules.places(4, 3, rng)
        corners = [(x > 0.0, y > 0.0) for x, y in keepers if abs(x) > 2.0]
        assert sorted(corners) == [(False, False), (True, False), (True, True)]
        assert all(12.0 <= abs(x) <= 15.0 and 7.0 <= abs(y) <= 10.0 for x, y in keepers if abs(x) > 2.0)
        assert sum(abs(x) <= 1.0 and abs(y) <= 1.0 for x, y in keepers) == 1
        assert all(-15.0 <= x <= -12.0 and 7.0 <= y <= 10.0 for x, y in takers)
        firsts.add((keepers[0][0] > 0.0, keepers[0][1] > 0.0, abs(keepers[0][0]) <= 1.0))
    assert len(firsts) >= 4  # every keeper comes everywhere
    assert rules.ball_place() == (-11.0, -6.0)


# --- the conversation ------------------------------------------------------------------------------------------------
def recorded() -> list[tuple[str, bytes]]:
    """A trainer's conversation with rcssserver 19.0.0: (send or recv, datagram)."""
    with gzip.open(RECORDED, "rt") as file:
        entries = [json.loads(line) for line in file]
    return [(entry["dir"], entry["text"].encode() + b"\0") for entry in entries]


def recorded_trainer() -> KeepawayTrainer:
    """Return a trainer that draws the places of the recording."""
    trainer = KeepawayTrainer(TASK, 5)
    text = [data for direction, data in recorded() if direction == "send"]
    moves = [re.match(rb"\(move \(player \w+ \d\) (\S+) (\S+) ", data) for data in text]
    places = [(float(move[1]), float(move[2])) for move in moves if move is not None]
    drawn = iter([(places[k : k + 3], places[k + 3 : k + 5]) for k in range(0, len(places), 5)])
    trainer._rules.places = lambda *_: next(drawn)  # type: ignore[method-assign]
    return trainer


def test_a_conversation_with_the_original_is_held_again() -> None:
    trainer = recorded_trainer()
    said = [trainer.first_datagram()]
    recording = recorded()
    heard = [data for direction, data in recording if direction == "recv"]
    said += trainer.initialised(heard[0])
    for data in heard[1:]:
        said += trainer.receive(data)
    without_places = [re.sub(rb"\) [-0-9. ]+\)", b") ...)", data) for data in said]  # they were written in full
    expected = [re.sub(rb"\) [-0-9. ]+\)", b") ...)", data) for direction, data in recording if direction == "send"]
    assert without_places == expected
    assert trainer.episodes == [Episode(1, 0, 28, OUT), Episode(2, 28, 63, OUT), Episode(3, 63, 90, TAKEN)]


def test_bodies_keep_their_angles_and_come_to_rest() -> None:
    trainer = recorded_trainer()
    heard = [data for direction, data in recorded() if direction == "recv"]
    trainer.initialised(heard[0])
    answers = [answer for data in heard[1:] for answer in trainer.receive(data)]
    last = [answer for answer in answers if answer.startswith(b"(move (player takers 2)")][-1]
    assert re.fullmatch(rb"\(move \(player takers 2\) -\d\.\d+ \d\.\d+ 178 0 0\)\0", last)


REPLIES = {
    b"(error connected_offline_coach_without_coach_mode)\0": (WrongServer, "server::coach=1"),
    b"(error already_have_offline_coach)\0": (WrongServer, "already_have_offline_coach"),
    b"(init l 1 play_on)\0": (RemoteProtocolError, "expected the reply to a trainer's init"),
}


@pytest.mark.parametrize("reply", REPLIES)
def test_a_refusal_says_what_would_be_right(reply: bytes) -> None:
    kind, message = REPLIES[reply]
    with pytest.raises(kind, match=message):
        KeepawayTrainer(TASK, 1).initialised(reply)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        (b"(keepaway 1)(coach_w_referee 1)", "server::keepaway=0"),
        (b"(keepaway 0)(keepaway_length 25)(keepaway_width 20)", "region of 25x20 m, not 20x20"),
    ],
)
def test_a_server_that_does_not_fit_is_refused(parameters: bytes, message: str) -> None:
    with pytest.raises(WrongServer, match=message):
        KeepawayTrainer(TASK, 1).receive(b"(server_param " + parameters + b")\0")


def test_a_refused_command_ends_the_match() -> None:
    with pytest.raises(RemoteProtocolError, match="illegal_mode"):
        KeepawayTrainer(TASK, 1).receive(b"(error illegal_mode)\0")


# --- matches ---------------------------------------------------------------------------------------------------------
def empty_report() -> RunReport:
    return RunReport("fake", "random", "hand", TASK.size, TASK.field, TASK.vision, 1)


def random_keepers():  # type: ignore[no-untyped-def]
    policy = load_policy("random", 3, 2, 1)
    policy.warm_up()
    return policy


@contextlib.contextmanager
def serving(**changes: Value) -> Iterator[Server]:
    ports: dict[str, Value] = dict.fromkeys(("port", "coach_port", "olcoach_port"), 0)
    with running_server(parse_options(server_options(TASK, real=False, **ports | changes))) as server:
        yield server


def trainer_for(server: Server, seed: int = 1) -> TrainerClient:
    return TrainerClient(TASK, "127.0.0.1", server.coach_port, seed)


@pytest.mark.compiled
def test_a_match_refereed_by_our_trainer() -> None:
    report, told = empty_report(), []
    with serving(**REFEREED_BY_TRAINER) as server:
        address = ("127.0.0.1", server.port)

        async def match() -> TrainerClient:
            trainer = trainer_for(server)
            await play_match(
                report, Match(TASK, address, 1, random_keepers(), True, 4), trainer=trainer, on_episode=told.append
            )
            return trainer

        trainer = asyncio.run(match()).trainer
        assert not server.kicked_off  # the stand-in's own referee had no part in it
    assert report.failure is None
    assert report.episodes == trainer.episodes[:4]
    assert [episode.start for episode in report.episodes] == [0, *(e.end for e in report.episodes[:-1])]
    assert all(10 < episode.cycles < 600 for episode in report.episodes)
    assert {episode.reason for episode in report.episodes} <= {OUT, TAKEN}
    assert told == report.episodes  # with the trainer's reasons, as they end


@pytest.mark.compiled
def test_a_trainer_referees_in_real_time() -> None:
    report = empty_report()
    fast: dict[str, Value] = {"synch_mode": False, "slow_down_factor": 1}
    with serving(**REFEREED_BY_TRAINER, **fast) as server:
        address = ("127.0.0.1", server.port)

        async def match() -> None:
            await play_match(report, Match(TASK, address, 1, random_keepers(), True, 1), trainer=trainer_for(server))

        asyncio.run(match())
    assert report.failure is None
    assert len(report.episodes) == 1
    assert report.episodes[0].reason in (OUT, TAKEN)


@pytest.mark.compiled
@pytest.mark.slow
def test_a_trainer_referees_players_in_processes_of_their_own() -> None:
    report = empty_report()

    async def match(server: Server) -> None:
        address = ("127.0.0.1", server.port)
        crew = ProcessCrew(TASK, *address, 1, random_keepers())
        await play_match(report, Match(TASK, address, 1, None, True, 2, crew=crew), trainer=trainer_for(server))

    with serving(**REFEREED_BY_TRAINER) as server:
        asyncio.run(match(server))
    assert report.failure is None
    assert [episode.number for episode in report.episodes] == [1, 2]


@pytest.mark.compiled
def test_a_server_without_coach_mode_ends_the_match_clearly() -> None:
    report = empty_report()
    with serving() as server:
        address = ("127.0.0.1", server.port)

        async def match() -> None:
            await play_match(report, Match(TASK, address, 1, random_keepers(), True, 1), trainer=trainer_for(server))

        asyncio.run(match())
    assert report.failure is not None
    assert "server::coach=1" in report.failure


@pytest.mark.compiled
def test_a_trainer_alone_referees_whoever_comes() -> None:
    refereed, told = empty_report(), []
    with serving(**REFEREED_BY_TRAINER) as server:

        async def match() -> None:
            match = asyncio.create_task(play_without_kick_off(("127.0.0.1", server.port)))
            await referee_match(refereed, TASK, 1, ("127.0.0.1", server.coach_port), 2, told.append)
            match.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await match

        asyncio.run(match())
    assert refereed.failure is None
    assert [episode.number for episode in refereed.episodes] == [1, 2]
    assert told == refereed.episodes
    assert refereed.cycles >= refereed.episodes[-1].end


async def play_without_kick_off(address: tuple[str, int]) -> None:
    match = Match(TASK, address, 1, random_keepers())
    match.gathering.led = True  # by somebody else's trainer
    await match.connect()
    await match.play(kick_off=False)


@pytest.mark.compiled
def test_a_trainer_gives_up_when_nobody_comes() -> None:
    report = empty_report()
    with serving(**REFEREED_BY_TRAINER) as server:
        address = ("127.0.0.1", server.coach_port)
        asyncio.run(referee_match(report, TASK, 1, address, 1, lambda episode: None, patience=0.3))
    assert report.failure is not None
    assert "0 and 0 came" in report.failure


def test_a_trainer_without_a_server_says_what_to_start() -> None:
    async def connect() -> None:
        client = TrainerClient(TASK, "127.0.0.1", 9, 1)
        try:
            await client.connect(attempts=1)
        finally:
            client.close()

    with pytest.raises(ServerGone, match="server::coach=1"):
        asyncio.run(connect())


# --- a network that loses what the trainer says -----------------------------------------------------------------------
class Deaf(Relay):
    """Loses every third of a trainer's moves, and the first ones of everything else that must arrive."""

    def __init__(self, port: int) -> None:
        super().__init__("127.0.0.1", port, None)
        self.once = [b"(change_mode", b"(team_names"]
        self.moves = self.lost = 0

    async def _deliver(self, data: bytes, stream: DatagramServer, address: tuple[str, int]) -> None:
        if data.startswith(b"(move"):
            self.moves += 1
            if self.moves % 3 == 0:
                self.lost += 1
                return
        for word in self.once:
            if data.startswith(word):
                self.once.remove(word)
                return
        await stream.send(data, address)


def test_what_the_network_loses_of_a_trainers_words_is_said_again() -> None:
    async def refereed(server: Server) -> tuple[RunReport, Deaf]:
        report = RunReport.of("localhost", "hold", TASK, 1, referee="trainer")
        async with Deaf(server.coach_port) as relay:
            trainer = TrainerClient(TASK, relay.bind, relay.port, 1)
            policy = load_policy("hold", 3, 2, 1)
            policy.warm_up()
            match = Match(TASK, ("127.0.0.1", server.port), 1, policy, True, 4)
            await play_match(report, match, trainer=trainer)
        return report, relay

    options = server_options(TASK, real=False, **dict.fromkeys(("port", "coach_port", "olcoach_port"), 0),
                             **REFEREED_BY_TRAINER)  # fmt: skip
    with running_server(parse_options(options)) as server:
        report, relay = asyncio.run(refereed(server))
    assert report.failure is None
    assert relay.once == [] and relay.lost >= 8
    assert [10 < episode.cycles < 600 for episode in report.episodes] == [True] * 4


def test_an_episode_begins_when_all_are_at_their_places_and_the_ball_lies_at_its() -> None:
    """Who was not away yet when the ball was put down may have kicked it, and its move may be lost, too."""
    trainer = KeepawayTrainer(TASK, 5)
    teams = ("keepers", 1), ("keepers", 2), ("keepers", 3), ("takers", 1), ("takers", 2)

    def told(cycle: int, ball: str, places: dict[tuple[str, int], tuple[float, float]]) -> list[bytes]:
        players = " ".join(f'((p "{t}" {n}) {places[t, n][0]} {places[t, n][1]} 0 0 0 0)' for t, n in teams)
        return trainer.receive(f"(see_global {cycle} ((g l) -52.5 0) ((g r) 52.5 0) ((b) {ball}) {players})\0".encode())

    elsewhere = dict.fromkeys(teams, (5.0, 5.0))
    assert told(0, "0 0 0 0", elsewhere) == [b"(team_names)\0"]
    trainer.receive(b"(ok team_names (team l keepers) (team r takers))\0")
    told(1, "0 0 0 0", elsewhere)
    trainer.receive(b"(hear referee 1 play_on)\0")
    there = {(move.team, move.unum): (move.x, move.y) for move in trainer._to_place}
    late = {**there, ("keepers", 1): (0.0, 0.0)}
    again = told(2, "-6 -6 0 0", late)
    assert [word[:13] for word in again] == [b"(move (player", b"(move (ball) "]
    assert told(3, "-6.8 -6 -0.9 0", there) == told(4, "-7.7 -6 -0.8 0", there) == again[1:]
    assert told(5, "-6 -6 1.2 0", there) == again[1:], "rolls over its place"
    assert trainer.episodes == [] and told(6, "-6 -6 0 0", there) == []
    told(7, "-10.1 -6 -1 0", there)
    assert [episode.reason for episode in trainer.episodes] == [OUT]


def test_a_server_that_moves_nobody_is_said() -> None:
    trainer = KeepawayTrainer(TASK, 5)
    heard = [data for direction, data in recorded() if direction == "recv"]
    trainer.initialised(heard[0])
    with pytest.raises(WrongServer, match="does not put players where the trainer wants them"):
        for data in heard[1:]:
            trainer.receive(data)
