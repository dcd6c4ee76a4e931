"""The trainer: replies, what he sees and hears, and what he does to a match."""

from __future__ import annotations

import re

import pytest
from server_clients import FAST, Client, Clients, options, serving

from fake_server.clock import Timing


@pytest.fixture(scope="module")
def clients():
    with serving(options(coach_w_referee=True, send_comms=True)) as clients:
        yield clients


@pytest.fixture(scope="module")
def players(clients: Clients) -> list[Client]:
    return [clients.player("keepers"), clients.player("takers")]


@pytest.fixture(scope="module")
def trainer(clients: Clients, players: list[Client]) -> Client:
    return clients.trainer()


@pytest.fixture(scope="module")
def still():
    """A trainer of a match in which no step is made: the referee does not see what he does."""
    with serving(options(coach_w_referee=True, simulator_step=1_000_000)) as clients:
        for team in ("keepers", "takers"):
            clients.player(team)
        yield clients.trainer()


REPLY = r"\((ok|error|warning)"


def test_no_trainer_without_coach_mode() -> None:
    with serving(options()) as clients:
        client = clients.open(clients.server.coach_port)
        client.send("(init (version 11))")
        assert client.receive() == "(error connected_offline_coach_without_coach_mode)"


def test_one_trainer_at_a_time(clients: Clients, trainer: Client) -> None:
    second = clients.open(clients.server.coach_port)
    second.send("(init (version 11))")
    assert second.receive() == "(error already_have_offline_coach)"


@pytest.mark.parametrize(
    ("command", "reply"),
    [
        ("(team_names)", "(ok team_names (team l keepers) (team r takers))\n"),
        ("(check_ball)", r"\(ok check_ball 0 in_field\)"),
        ("(eye xx)", "(error illegal_command_form)"),
        ("(ear off)", "(ok ear off)"),
        ("(say hello)", "(ok say)"),
        ("(say)", "(error illegal_command_form)"),
        ("(move (ball) 60 0)", "(ok move)"),
        ("(check_ball)", r"\(ok check_ball 0 out_of_field\)"),
        ("(move (ball) 53 0)", "(ok move)"),
        ("(check_ball)", r"\(ok check_ball 0 goal_r\)"),
        ("(move (ball) -53 0)", "(ok move)"),
        ("(check_ball)", r"\(ok check_ball 0 goal_l\)"),
        ("(move (ball) 1 2 3)", "(ok move)"),
        ("(move (ball) 1 2 3 4)", "(error illegal_command_form)"),
        ("(move (ball) 1 2 3 0.4 0.5)", "(ok move)"),
        ("(move (ball) nan 2)", "(error illegal_object_form)"),
        ("(move (ball) 1e300 2)", "(ok move)"),
        ("(move (nobody) 1 2)", "(error illegal_object_form)"),
        ("(move (player keepers 12) 1 2)", "(error illegal_object_form)"),
        ("(move (player nobody 2) 1 2)", "(ok move)"),
        ("(change_mode nosuch)", "(error illegal_mode)"),
        ("(change_mode)", "(error illegal_command_form)"),
        ("(change_mode goal_l)", "(ok change_mode)"),
        ("(change_mode before_kick_off)", "(ok change_mode)"),
        ("(change_player_type keepers 1 3)", "(ok change_player_type keepers 1 3)"),
        ("(change_player_type keepers 1 0)", "(ok change_player_type keepers 1 0)"),
        ("(change_player_type keepers 1 99)", "(error out_of_range_player_type)"),
        ("(change_player_type nobody 1 3)", "(warning no_team_found)"),
        ("(change_player_type keepers 2 3)", "(warning no_such_player)"),
        ("(recover)", "(ok recover)\n"),
        ("(compression 12)", "(error illegal_command_form)"),
        ("(bye)", "(error unknown_command)"),
        ("bogus", "(error illegal_command_form)"),
    ],
)
def test_replies(still: Client, command: str, reply: str) -> None:
    told = still.ask(command, REPLY)
    assert told == reply or re.fullmatch(reply, told)


def test_look_shows_everything_where_it_was_put(still: Client) -> None:
    for command in (
        "(move (ball) 3 4 0 0.4 -0.5)",
        "(move (player keepers 1) -10.25 5 90 0.125 0)",
        "(move (player takers 1) 20 -5 180)",
    ):
        assert still.ask(command, REPLY) == "(ok move)"
    told = still.ask("(look)", REPLY)
    start = "(ok look 0 ((g r) 52.5 0) ((g l) -52.5 0) ((b) 3 4 0.4 -0.5) "
    assert told.startswith(start)
    assert re.fullmatch(
        r'\(\(p "keepers" 1\) -10\.25 5 \S+ 0 90 0\) \(\(p "takers" 1\) 20 -5 0 0 180 0\)\)', told[len(start) :]
    )


def test_trainer_hears_and_players_hear_the_trainer(trainer: Client, players: list[Client]) -> None:
    assert trainer.ask("(ear on)", REPLY) == "(ok ear on)"
    players[0].send('(say "hi")')
    assert trainer.until(r"\(hear")[-1] == '(hear 0 (p "keepers" 1) "hi")'
    trainer.send("(say (a b))")
    assert trainer.until(REPLY)[-2:] == ['(hear 0 referee "(a b)")', "(ok say)"]
    for player in players:
        assert player.until(r'\(hear 0 coach "\(a b\)"\)')
    trainer.send("(change_mode kick_in_l)")
    assert trainer.until(REPLY)[-2:] == ["(hear referee 0 kick_in_l)", "(ok change_mode)"]
    assert trainer.ask("(change_mode before_kick_off)", REPLY) == "(ok change_mode)"
    assert trainer.ask("(ear off)", REPLY) == "(ok ear off)"


def test_own_team_learns_the_type_opponents_only_the_change(trainer: Client, players: list[Client]) -> None:
    trainer.ask("(change_player_type keepers 1 5)", REPLY)
    assert players[0].until(r"\(change_player_type")[-1] == "(change_player_type 1 5)"
    assert players[1].until(r"\(change_player_type")[-1] == "(change_player_type 1)"
    trainer.ask("(change_player_type keepers 1 0)", REPLY)


def test_see_global_shows_where_an_arm_points() -> None:
    with serving(options(coach_w_referee=True)) as clients:
        player, trainer = clients.player(), clients.trainer(13)
        for command in ("(change_mode play_on)", "(move (player keepers 1) 0 0 90)", "(eye on)"):
            assert trainer.ask(command, REPLY).startswith("(ok")
        player.send("(pointto 10 30)(tackle 10)")
        told = trainer.until(r'\(see_global .*\(\(p "keepers" 1\) \S+ \S+ \S+ \S+ 90 0 \d+ t\)')[-1]
        assert re.search(r" 90 0 120 t\)\)$", told)  # absolute: 90 degrees of the body and 30 of the arm


def test_an_open_eye_is_waited_for_and_may_ask_before_it_is_done() -> None:
    with serving(options(coach_w_referee=True, synch_mode=True), Timing(patience=60.0, pause=0.0)) as clients:
        trainer = clients.trainer()
        assert trainer.ask("(eye on)", REPLY) == "(ok eye on)"
        for cycle in range(3):
            told = trainer.until(r"\(think\)")
            assert told[-2].startswith("(see_global ")
            assert trainer.ask(f"(move (ball) {cycle} 0)", REPLY) == "(ok move)"
            assert f"((b) {cycle} 0 0 0)" in trainer.ask("(look)", REPLY)
            trainer.send("(done)")
        trainer.until(r"\(think\)")
        trainer.send("(eye off)")
        trainer.send("(done)")
        assert trainer.until(REPLY)[-1] == "(ok eye off)"
        trainer.send("(look)")
        assert trainer.until(REPLY)[-1].startswith("(ok look")  # no think any more


def test_change_mode_play_on_starts_keepaway(tmp_path) -> None:
    wanted = options(
        keepaway=True,
        coach_w_referee=True,
        keepaway_logging=True,
        keepaway_log_dir=str(tmp_path),
        keepaway_log_fixed=True,
    )
    with serving(wanted, FAST) as clients:
        players, trainer = [clients.player("keepers"), clients.player("takers")], clients.trainer()
        assert trainer.ask("(change_mode play_on)", REPLY) == "(ok change_mode)"
        for player in players:
            assert player.until(r"\(hear")[-1] == "(hear 0 referee play_on)"
        assert "((b) -6 -6 0 0)" in trainer.ask("(look)", REPLY)
    assert (tmp_path / "rcssserver.kwy").read_text().startswith("# Keepers: 1\n")


def test_coach_mode_without_referee_has_no_episodes() -> None:
    with serving(options(coach=True, keepaway=True)) as clients:
        clients.player()
        trainer = clients.trainer()
        for command in ("(change_mode play_on)", "(move (ball) 30 0)", "(ear on)"):
            assert trainer.ask(command, REPLY).startswith("(ok")
        assert clients.monitor().until(r"\(show [3-9] ")
        assert "((b) 30 0 0 0)" in trainer.ask("(look)", REPLY)


def test_a_first_datagram_that_is_no_init_is_carried_out_unanswered() -> None:
    with serving(options(coach_w_referee=True, keepaway=True)) as clients:
        monitor = clients.monitor()
        clients.open(clients.server.coach_port).send("(move (ball) 5 5)")
        assert monitor.until(r"\(show \d+ \(pm 3\) .*\(\(b\) (5|-6) ")
