"""Synch mode: the cycle, the wait, and that a seed decides everything whatever the order of arrival."""

from __future__ import annotations

import random
import re
import select
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import chain
from pathlib import Path

import pytest
from server_clients import FAST, PATIENCE, Client, Clients, keepaway, serving, wait_for

from fake_server.clock import SynchClock, Timing
from fake_server.player_client import PlayerClient
from fake_server.reactions import Reactions
from fake_server.server import Server
from fake_server.trainer import TrainerClient
from fake_server.warm_up import warm_up
from rcss_hat.keepaway.report import read_kwy

N_KEEPERS, N_TAKERS = 3, 2


def everybody(clients: Clients) -> list[Client]:
    keepers = [clients.player("keepers", 12 if k == 0 else 11) for k in range(N_KEEPERS)]
    return keepers + [clients.player("takers") for _ in range(N_TAKERS)]


def answer_thinks(players: list[Client], until: str, turning: Sequence[Client] = ()) -> None:
    """Let everybody answer every think once, as real clients do, until he has heard something; some turn, too."""
    waiting = list(players)
    while waiting:
        readable, _, _ = select.select([player.socket for player in waiting], [], [], PATIENCE)
        assert readable, f"{len(waiting)} players heard no {until!r}"
        for player in [player for player in waiting if player.socket in readable]:
            message = player.receive()
            if message == "(think)":
                player.send("(turn 30)(done)" if player in turning else "(done)")
            if re.match(until, message):
                waiting.remove(player)


def kick_off(clients: Clients, players: list[Client]) -> None:
    """Kick off, and let everybody hear it; what comes next for everybody is the first cycle."""
    monitor = clients.monitor()
    monitor.send("(dispstart)")
    monitor.send("(dispbye)")
    answer_thinks(players, r"\(hear 0 referee play_on\)")


def commands(player: int, cycle: int) -> list[str]:
    """Datagrams of a player in a cycle: everything that draws random numbers or depends on order."""
    rng = random.Random(1000 * cycle + player)
    body = rng.choice([f"(dash {rng.randrange(100)})", f"(turn {rng.randrange(-180, 180)})", "(kick 60 30)"])
    body = rng.choice([body, f"(kick {rng.randrange(100)} {rng.randrange(-180, 180)})", "(tackle 50)"])
    sent = [body + f"(turn_neck {rng.randrange(-60, 60)})"]
    if rng.random() < 0.5:
        sent.append(f'(say "{player} {cycle}")')
    if rng.random() < 0.2:
        sent.append(rng.choice(["(attentionto our 1)", "(change_view narrow high)", "(pointto 5 30)", "(sense_body)"]))
    return [*sent, "(done)"]


def begin(clients: Clients, within_a_think: bool) -> list[Client]:
    """Bring everybody in, let everybody turn, and kick off while somebody thinks, or between two thinks.

    In the one case everybody turns in a cycle of his own, in the other all together.
    """
    players, monitor, server = everybody(clients), clients.monitor(), clients.server
    for turning in [[player] for player in players] if within_a_think else [players]:
        answer_thinks(players, r"\(think\)", turning)
    if within_a_think:
        players[0].until(r"\(think\)")
        monitor.send("(dispstart)")
        wait_for(lambda: server.kick_off_wanted)
        players[0].send("(done)")
    else:
        read_others = server.read_others

        def knock(timeout: float) -> None:
            server.read_others = read_others  # type: ignore[method-assign]
            monitor.send("(dispstart)")
            read_others(timeout)

        server.read_others = knock  # type: ignore[method-assign]
    answer_thinks(players, r"\(hear 0 referee play_on\)")
    monitor.send("(dispbye)")
    return players


def transcript(seed: int, shuffle: int, within_a_think: bool, cycles: int = 50) -> list[list[str]]:
    """What every player is told in a match in which the datagrams of a cycle arrive in some order."""
    order = random.Random(shuffle)
    with serving(keepaway(seed=seed), Timing(patience=PATIENCE, pause=0.02, monitor_pause=0.0)) as clients:
        players = begin(clients, within_a_think)
        told: list[list[str]] = [[] for _ in players]
        for cycle in range(1, cycles):
            for k, player in enumerate(players):
                told[k] += player.until(r"\(think\)")
            sendings = [(k, data) for k in range(len(players)) for data in commands(k, cycle)]
            waiting = {k: [data for j, data in sendings if j == k] for k in range(len(players))}
            while waiting:  # the datagrams of one player keep their order, those of different players do not
                k = order.choice(list(waiting))
                players[k].send(waiting[k].pop(0))
                if not waiting[k]:
                    del waiting[k]
        return told


def test_a_seed_decides_the_match_whatever_the_order_of_arrival() -> None:
    first, second, other = transcript(3, 1, True), transcript(3, 2, False), transcript(4, 1, False)
    assert first == second
    assert all(first[k] != other[k] for k in range(N_KEEPERS + N_TAKERS))
    kinds = {re.match(r"\(\w+", message)[0] for message in chain(*first)}
    assert kinds == {"(sense_body", "(see", "(hear", "(think"}


def test_order_of_messages_within_a_cycle() -> None:
    with serving(keepaway(fullstate_l=True)) as clients:
        players = everybody(clients)
        kick_off(clients, players)
        shapes = set()
        for cycle in range(1, 10):
            for k, player in enumerate(players):
                told = player.until(r"\(think\)")
                if k == 0 and cycle > 1:
                    shapes.add(" ".join(re.match(r"\((\w+)", message)[1] for message in told))
                player.send(f'(say "{cycle}")(done)')
        hears = "hear hear hear"  # himself, one team mate and one opponent: the others are heard in part, which is off
        late = f"see sense_body fullstate {hears} think"
        assert shapes <= {
            f"sense_body fullstate {hears} see think",
            f"sense_body fullstate {hears} think",
            late,
        }
        assert f"sense_body fullstate {hears} see think" in shapes


def play_cycle(players: list[Client], answer: str = "(done)") -> list[str]:
    """Let everybody answer a think; what the first player was told."""
    told = [player.until(r"\(think\)") for player in players]
    for player in players:
        player.send(answer)
    return told[0]


def end_episodes(clients: Clients, players: list[Client]) -> list[list[str]]:
    """End one episode with the ball out and one with the ball taken; what the first player is told then."""
    trainer = clients.trainer()
    ends = []
    for places in (["(ball) 30 0"], ["(player keepers 1) 0 0", "(player takers 1) -6 -5.2"]):
        for place in places:
            assert trainer.ask(f"(move {place})", r"\((ok|error)") == "(ok move)"
        for _ in range(8):
            told = play_cycle(players)
            if "training" in told[0]:
                ends.append(told)
                break
    return ends


def test_episodes_end_with_a_message_and_a_log_line(tmp_path: Path) -> None:
    ended: list[tuple[int, int, int, bool]] = []
    options = keepaway(tmp_path, coach_w_referee=True)
    with serving(options, on_episode=lambda *episode: ended.append(episode)) as clients:
        players = everybody(clients)
        kick_off(clients, players)
        ends = end_episodes(clients, players)
        log = clients.server.logs.paths[0]
        assert log == tmp_path / "rcssserver.kwy"
        assert [(e.number, e.start, e.end, e.reason == "t") for e in read_kwy(log)] == ended
    assert [taken for *_, taken in ended] == [False, True]
    assert ended[0][1] == 0 and ended[1][1] == ended[0][2] and ended[1][2] == ended[1][1] + 6
    for told, (_, _, end, _) in zip(ends, ended, strict=True):
        assert told[0] == f"(hear {end} referee training Keepaway 1)"
        assert told[1].startswith(f"(sense_body {end} ")


def test_a_reply_is_sent_at_once_to_who_has_not_said_done() -> None:
    with serving(keepaway(), Timing(pause=0.0, patience=60.0)) as clients:
        player = clients.player()
        player.until(r"\(think\)")
        for question, reply in (
            ("(score)", r"\(score 0 0 0\)"),
            ("(sense_body)", r"\(sense_body"),
            ("(x)", r"\(error"),
        ):
            player.send(question)
            assert len(player.until(reply)) == 1
        player.send("(done)")
        player.until(r"\(think\)")


def test_surplus_dones_are_used_up() -> None:
    with serving(keepaway(), Timing(pause=0.0, patience=60.0)) as clients:
        player = clients.player()
        player.until(r"\(think\)")
        player.send("(done)(done)")
        player.until(r"\(think\)")
        assert player.quiet_for(0.3)


def test_who_is_silent_is_waited_for_and_the_server_gives_up_in_the_end(capfd: pytest.CaptureFixture[str]) -> None:
    with serving(keepaway(), Timing(patience=0.02, most_misses=3, pause=0.0)) as clients:
        players = everybody(clients)
        for player in players[1:]:
            player.close()
        monitor = clients.monitor()
        monitor.send("(dispstart)")
        thread = next(t for t in threading.enumerate() if t.name == "fake-rcssserver")
        thread.join(20.0)
        assert not thread.is_alive()
        assert clients.server.exit_code == 1
    errors = capfd.readouterr().err.splitlines()
    assert errors[-5:] == [*(f"Someone missed a cycle at {cycle}" for cycle in range(1, 5)), errors[-1]]
    assert errors[-1] == "Waiting too long for clients! Exiting"


@contextmanager
def by_hand(timing: Timing) -> Iterator[tuple[Server, SynchClock, list[Client]]]:
    """A server in a match of two players whose cycles the test calls, one after the other."""
    warm_up(quiet=True)
    server = Server(keepaway())
    server.start()
    clients = Clients(server)
    players = [clients.open(), clients.open()]
    for player in players:
        player.send("(init keepers (version 11))")
        server.read_all(PATIENCE)
        player.until(r"\(player_type \(id 17\)")
    server.kick_off()
    try:
        yield server, SynchClock(server, timing), players
    finally:
        server.close()
        for player in players:
            player.close()


def test_nobody_is_asked_to_think_before_he_was_told_of_a_step() -> None:
    with by_hand(Timing(patience=0.0, pause=0.0)) as (server, clock, players):
        assert server.clients.start_thinking() == []
        clock.cycle()
        kinds = [re.match(r"\((\w+)", message)[1] for message in players[1].until(r"\(think\)")]
        assert kinds[0] == "hear"
        assert set(kinds[1:-1]) <= {"sense_body", "see"}
        assert [client.who for client in server.clients.start_thinking()] == ["keepers_1", "keepers_2"]


def test_one_answer_in_time_forgives_misses(capfd: pytest.CaptureFixture[str]) -> None:
    with by_hand(Timing(patience=0.0, most_misses=2, pause=0.0)) as (server, clock, players):
        for _ in range(3):
            clock.cycle()
            players[0].send("(done)")  # not enough
            clock.cycle()
            for player in players:
                player.send("(done)")
            clock.cycle()
        assert server.running
        for _ in range(3):
            clock.cycle()
        assert (server.running, server.exit_code) == (False, 1)
    missed = [1, 2, 4, 5, 7, 8, 10, 11, 12]
    said = [f"Someone missed a cycle at {cycle}" for cycle in missed]
    assert capfd.readouterr().err.splitlines() == [*said, "Waiting too long for clients! Exiting"]


def test_who_answered_while_the_server_was_busy_has_not_missed(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    take, patience = PlayerClient.take, 0.05
    with by_hand(Timing(patience=patience, pause=0.0)) as (server, clock, players):

        def slowly(client: PlayerClient, data: bytes) -> Reactions:
            if client.i == 0:
                time.sleep(1.5 * patience)
                players[1].send("(done)")
            return take(client, data)

        monkeypatch.setattr(PlayerClient, "take", slowly)
        players[0].send("(done)")
        clock.cycle()
        assert server.game.time == 1
    assert "missed" not in capfd.readouterr().err


def test_the_options_say_how_long_to_wait() -> None:
    wanted = keepaway()
    wanted.patience = 0.001
    with serving(wanted, timing=None) as clients:
        clients.player()
        clients.monitor().send("(dispstart)")
        wait_for(lambda: clients.server.exit_code == 1)  # after 21 waits, of 1.25 s otherwise


def test_the_waits_are_the_originals() -> None:
    assert Timing() == Timing(patience=1.25, most_misses=20, pause=0.05, monitor_pause=0.02)


def test_commands_of_who_never_says_done_are_carried_out() -> None:
    with by_hand(Timing(patience=0.0, pause=0.0)) as (_, clock, players):
        clock.cycle()
        players[0].send("(turn_neck 30)")
        clock.cycle()
        clock.cycle()
        assert "(turn_neck 1)" in players[0].until(r"\(sense_body 3 ")[-1]


def test_who_dies_while_he_thinks_costs_one_wait(capfd: pytest.CaptureFixture[str]) -> None:
    with by_hand(Timing(patience=0.0, pause=0.0)) as (server, clock, (stays, dies)):
        ask = server.clients.start_thinking

        def ask_and_die() -> list[PlayerClient | TrainerClient]:
            thinkers = ask()
            dies.close()  # nobody notices before something is sent to him
            return thinkers

        server.clients.start_thinking = ask_and_die  # type: ignore[method-assign]
        server.clients.hold = lambda: None  # type: ignore[method-assign]  # (think) reaches him before he dies
        for _ in range(5):
            stays.send("(done)")
            clock.cycle()
        assert [player and player.who for player in server.clients.players[:2]] == ["keepers_1", None]
    assert capfd.readouterr().err == "Someone missed a cycle at 1\n"


def test_goodbye_counts_as_done() -> None:
    with serving(keepaway(), Timing(patience=60.0, pause=0.0)) as clients:
        stays, leaves = clients.player(), clients.player()
        stays.send("(done)")
        leaves.until(r"\(think\)")
        leaves.send("(bye)")
        for _ in range(3):
            stays.until(r"\(think\)")
            stays.send("(done)")


def test_keepaway_start_counts_whole_seconds_of_the_wall_clock(tmp_path: Path) -> None:
    with serving(keepaway(tmp_path, keepaway_start=0), FAST) as clients:
        players = [clients.player("keepers"), clients.player("takers")]
        told: list[str] = []
        while not any("play_on" in message for message in told):
            for player in players:
                told = player.until(r"\(think\)")
                player.send("(done)")
        assert told[0] == "(hear 0 referee play_on)"
        assert told[1].startswith("(sense_body 0 ")
    assert (tmp_path / "rcssserver.kwy").read_text().startswith("# Keepers: 1\n# Takers:  1\n")


def test_the_server_stops_after_the_wanted_number_of_episodes(tmp_path: Path) -> None:
    options = keepaway(tmp_path, coach_w_referee=True)
    options.episodes = 1
    with serving(options) as clients:
        players = everybody(clients)
        kick_off(clients, players)
        thread = next(t for t in threading.enumerate() if t.name == "fake-rcssserver")
        assert clients.trainer().ask("(move (ball) 30 0)", r"\((ok|error)") == "(ok move)"
        for player in players:
            player.until(r"\(think\)")
            player.send("(done)")
        thread.join(20.0)
        assert not thread.is_alive()
        assert players[0].until(r"\(hear")[-1].endswith("referee training Keepaway 1)")
    assert [episode.number for episode in read_kwy(tmp_path / "rcssserver.kwy")] == [1]
