"""Joining, being refused, leaving, coming back: the answers are those recorded from rcssserver 19.0.0."""

from __future__ import annotations

import zlib

import pytest
from server_clients import Client, Clients, options, packed, serving

FULL = "(error no_more_player_or_goalie_or_illegal_client_version)"


@pytest.fixture(scope="module")
def clients():
    with serving(options()) as clients:
        yield clients


@pytest.fixture(scope="module")
def player(clients: Clients) -> Client:
    return clients.player()


def answer(clients: Clients, first: str, end: str = "\0") -> str:
    client = clients.open()
    client.send(first, end)
    return client.receive()


def test_who_joins_gets_a_number_and_parameters() -> None:
    with serving(options()) as clients:
        player = clients.open()
        assert player.ask("(init keepers (version 11))", r"\(init") == "(init l 1 before_kick_off)"
        assert player.address is not None and player.address[1] != clients.server.port
        kinds = [message.split(" ")[0] for message in player.until(r"\(player_type \(id 17\)")]
        assert kinds == ["(server_param", "(player_param", *["(player_type"] * 18]
        assert answer(clients, "(init takers (goalie) (version 12))") == "(init r 1 before_kick_off)"
        assert answer(clients, "(init keepers (version 18))") == "(init l 2 before_kick_off)"
        assert answer(clients, "(init  keepers (version 11.9))") == "(init l 3 before_kick_off)"
        assert answer(clients, "(init keepers (version 11))", "\n") == "(init l 4 before_kick_off)"
        assert answer(clients, "(init others (version 11))") == "(error no_more_team)"
        assert answer(clients, "(init takers (version 11) (goalie))") == FULL
        for unum in range(5, 12):
            assert answer(clients, "(init keepers (version 11))") == f"(init l {unum} before_kick_off)"
        assert answer(clients, "(init keepers (version 11))") == FULL


@pytest.mark.parametrize(
    ("first", "reply"),
    [
        ("(init x (version 20))", FULL),
        ("(init x (version 0))", FULL),
        ("(init x (version nan))", FULL),
        ("(init x (version 1e9))", FULL),
        ("(init x (versio 9))", "(error illegal_command_form)"),
        ("(init x (version 11)", "(error illegal_command_form)"),
        ("(init \xe4 (version 11))", "(error illegal_teamname)"),
        ("(init ", "(error illegal_teamname)"),
        ("(init abcdefghijklmnop (version 11))", "(error illegal_teamname_or_too_long_teamname)"),
        ("(init)", "(error unknown_command)"),
        ("hello", "(error unknown_command)"),
        ("", "(error unknown_command)"),
        ("(reconnect nobody 1)", "(error no_such_team_or_player)"),
        ("(reconnect x 12)", "(error no_such_team_or_player)"),
        ("(dispinit version 7)", "(error illegal_client_version)"),
        ("(dispinit versio 3)", "(error unknown_command)"),
    ],
)
def test_refusals_come_from_the_known_port(clients: Clients, first: str, reply: str) -> None:
    client = clients.open()
    client.send(first)
    assert client.receive() == reply
    assert client.address is None


def test_clients_of_11_1_speak_11_at_most() -> None:
    with serving(options(profile="11.1")) as clients:
        invalid = "(error no_more_player_or_goalie_or_invalid_client_version)"
        assert answer(clients, "(init keepers (version 12))") == invalid
        player = clients.open()
        assert player.join("(init keepers (version 11))") == "(init l 1 before_kick_off)"
        assert sum(message.startswith("(player_type") for message in player.got) == 7


def test_only_init_is_allowed_on_the_known_port() -> None:
    with serving(options()) as clients:
        player = clients.player()
        player.send("(init keepers (version 11))", to_door=True)
        assert player.until(r"\(error")[-1] == "(error only_init_allowed_on_init_port)"


def test_who_leaves_frees_no_number_and_may_come_back() -> None:
    with serving(options()) as clients:
        player = clients.player()
        assert player.ask("(score)", r"\(score") == "(score 0 0 0)"
        player.send("(turn 20)(bye)(score)")
        monitor = clients.monitor()
        show = monitor.until(r"\(show .*\(\(l 1\) 0 0 -3 -37")[-1]
        assert "((l 1) 0 0 -3 -37" in show
        assert clients.open().join("(init keepers (version 11))") == "(init l 2 before_kick_off)"
        again = clients.open()
        assert again.join("(reconnect keepers 1)") == "(reconnect l before_kick_off)"
        assert again.until(r"\(sense_body")[-1].startswith("(sense_body 0 ")


def test_nobody_comes_back_during_play_on() -> None:
    with serving(options(keepaway=True)) as clients:
        clients.player()
        monitor = clients.monitor()
        monitor.send("(dispstart)")
        monitor.until(r"\(show [0-9]+ \(pm 3\)")
        assert answer(clients, "(reconnect keepers 1)") == "(error cannot_reconnect_while_playon)"


def test_a_client_whose_socket_is_closed_is_removed() -> None:
    with serving(options()) as clients:
        player, monitor = clients.player(), clients.monitor()
        monitor.until(r"\(show .*\(\(l 1\) 0 0x1 ")
        player.close()
        monitor.until(r"\(show .*\(\(l 1\) 0 0 -3 -37")
        assert clients.server.clients.players[0] is None


@pytest.mark.parametrize(
    ("sent", "replies"),
    [
        ("(score)(foo)", ["(score 0 0 0)", "(error illegal_command_form)"]),
        ("(foo)(score)", ["(error illegal_command_form)"]),
        ("", ["(error illegal_command_form)"]),
        (" ", ["(error illegal_command_form)"]),
        ("(clang (ver 7 8))", ["(ok clang (ver 7 8))"]),
        ("(ear (off Z p))", ["(error no team with name Z)"]),
        ("(ear (on))", []),
        ("(synch_see)(gaussian_see)", ["(ok synch_see)", "(ok gaussian_see)"]),
        ("(compression 10)", []),
        ("(turn 10)(dash 5)(kick 10 10)(catch 5)(attentionto our 9)", []),
        ("(say hi)(score)", []),
        ("(move 10 10)", ["(warning moving_to_opponent_field)"]),
        ("(dispstart)", ["(error illegal_command_form)"]),
        ("(init keepers (version 11))", ["(error illegal_command_form)"]),
    ],
)
def test_replies_to_players(player: Client, sent: str, replies: list[str]) -> None:
    player.until(r"\(sense_body")
    player.send(sent)
    player.send("(clang (ver 1 1))")  # answered last
    told = player.until(r"\(ok clang \(ver 1 1\)\)")
    assert [message for message in told[:-1] if message.startswith(("(score", "(error", "(ok", "(warn"))] == replies


def test_a_message_without_nul_is_executed_with_a_warning(player: Client) -> None:
    player.send("(score)", end="")
    told = player.until(r"\(score")
    assert "(warning message_not_null_terminated)" in told


def test_sense_body_on_demand_shows_what_was_just_commanded(player: Client) -> None:
    player.send("(change_view narrow high)(sense_body)")
    told = player.until(r"\(sense_body \d+ \(view_mode high narrow\)")[-1]
    assert "(change_view 1)" in told


def test_compression_packs_every_datagram_for_itself(clients: Clients) -> None:
    player = clients.player()
    assert player.ask("(compression 6)", r"\(ok") == "(ok compression 6)"
    for _ in range(3):
        data = zlib.decompressobj().decompress(player.receive_bytes())
        assert data.startswith((b"(sense_body", b"(see")) and data.endswith(b"\0")
    for _ in range(2):
        player.socket.sendto(packed("(score)"), player.address)
        while b"(score" not in (data := zlib.decompressobj().decompress(player.receive_bytes())):
            pass
        assert data == b"(score 0 0 0)\0"
    player.send("(score)")  # not compressed: not understood, and no harm done
    player.socket.sendto(packed("(compression -1)"), player.address)
    while not (data := player.receive_bytes()).startswith(b"("):
        pass
    assert player.ask("(score)", r"\(score") == "(score 0 0 0)"
    player.send("(bye)")


def test_online_coaches_are_told_that_there_are_none(clients: Clients) -> None:
    coach = clients.open(clients.server.olcoach_port)
    coach.send("(init keepers (version 11))")
    assert coach.receive() == "(error online_coach_not_supported)"
