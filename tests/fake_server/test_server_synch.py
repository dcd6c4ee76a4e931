"""Synch mode: the cycle, the wait, and that a seed decides everything whatever the order of arrival."""

from __future__ import annotations

import random
import re
import threading
import time
from itertools import chain
from pathlib import Path

import pytest
from server_clients import FAST, Client, Clients, keepaway, serving

from fake_server.clock import Timing
from rcss_hat.keepaway.report import read_kwy

N_KEEPERS, N_TAKERS = 3, 2


def everybody(clients: Clients) -> list[Client]:
    keepers = [clients.player("keepers", 12 if k == 0 else 11) for k in range(N_KEEPERS)]
    return keepers + [clients.player("takers") for _ in range(N_TAKERS)]


def kick_off(clients: Clients, players: list[Client]) -> None:
    """Kick off within a think of everybody, and answer it."""
    monitor = clients.monitor()
    for player in players:
        player.until(r"\(think\)")
    monitor.send("(dispstart)")
    players[0].until(r"\(hear 0 referee play_on\)")
    monitor.send("(dispbye)")
    for player in players:
        player.send("(done)")


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


def transcript(seed: int, shuffle: int, cycles: int = 50) -> list[list[str]]:
    """What every player is told in a match in which the datagrams of a cycle arrive in some order."""
    order = random.Random(shuffle)
    with serving(keepaway(seed=seed), Timing(pause=0.01 * (shuffle % 3), monitor_pause=0.0)) as clients:
        players = everybody(clients)
        kick_off(clients, players)
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


@pytest.mark.xfail(strict=False, reason="failed once on a busy machine; the cause is not known yet")
def test_a_seed_decides_the_match_whatever_the_order_of_arrival() -> None:
    first, second, other = transcript(3, 1), transcript(3, 2), transcript(4, 1)
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
        hears = "hear hear hear hear hear"
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


def test_one_answer_in_time_forgives_misses() -> None:
    with serving(keepaway(), Timing(patience=0.05, most_misses=2, pause=0.0)) as clients:
        player = clients.player()
        kick_off(clients, [player])
        for _ in range(4):
            player.until(r"\(think\)")
            player.until(r"\(think\)")
            player.until(r"\(think\)")  # two misses in a row, then an answer
            player.send("(done)")
        assert clients.server.running


def test_a_client_that_dies_costs_one_wait() -> None:
    with serving(keepaway(), Timing(patience=0.5, pause=0.0)) as clients:
        stays, dies = clients.player(), clients.player()
        stays.send("(done)")
        dies.until(r"\(think\)")
        dies.close()  # nobody notices before something is sent to it
        started = time.monotonic()
        for _ in range(12):
            stays.until(r"\(think\)")
            stays.send("(done)")
        assert time.monotonic() - started < 3.0
        assert clients.server.players[1] is None


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
