"""Monitors: frames of every version, and what monitors may do."""

from __future__ import annotations

import json
import re
import zlib

import numpy as np
import pytest
from server_clients import Client, Clients, keepaway, options, serving, wait_for

from rcss_hat.protocol.messages import binary

PLAYERS = 22


@pytest.fixture
def clients():
    with serving(options(send_comms=True, keepaway=True)) as clients:
        yield clients


@pytest.mark.parametrize(("version", "fields"), [(3, 11), (4, 11), (5, 12)])
def test_text_monitors_get_parameters_and_frames_of_their_version(clients: Clients, version: int, fields: int) -> None:
    other = clients.monitor(8 - version)  # at the same time: versions do not mix
    monitor = clients.open()
    monitor.send(f"(dispinit version {version})")
    kinds = [message.split(" ")[0] for message in monitor.until(r"\(player_type \(id 17\)")]
    assert kinds == ["(server_param", "(player_param", *["(player_type"] * 18]
    for _ in range(3):
        show = monitor.until(r"\(show ")[-1]
        assert re.match(r"\(show 0 \(pm 1\) \(tm null null 0 0\) \(\(b\) 0 0 0 0\) \(\(l 1\) 0 0 -3 -37 ", show)
        assert {len(counts.split()) for counts in re.findall(r"\(c ([^)]*)\)", show)} == {fields}
        assert ("(fp " in show) == (version == 5)
        assert other.until(r"\(show ")


def test_monitor_of_version_1_may_keep_using_the_known_port(clients: Clients) -> None:
    monitor = clients.open()
    monitor.send("(dispinit)")
    frame = np.frombuffer(monitor.receive_bytes(), dtype=binary.SHOW_1)
    assert (frame["mode"][0], frame["pmode"][0]) == (binary.SHOW_MODE, 1)
    monitor.send("(dispstart)", to_door=True)
    while frame["pmode"][0] != 3:
        data = monitor.receive_bytes()
        if len(data) == binary.SHOW_1.itemsize and data[1] == binary.SHOW_MODE:
            frame = np.frombuffer(data, dtype=binary.SHOW_1)


def test_monitor_of_version_2_gets_structures_first(clients: Clients) -> None:
    monitor = clients.open()
    monitor.send("(dispinit version 2)")
    modes = [int.from_bytes(monitor.receive_bytes()[:2], "big") for _ in range(21)]
    assert modes == [binary.SERVER_MODE, binary.PLAYER_MODE, *[binary.TYPE_MODE] * 18, binary.SHOW_MODE]
    monitor.send("(dispinit version 2)", to_door=True)
    while not (data := monitor.receive_bytes()).startswith(b"(error"):
        pass
    assert data == b"(error only_init_allowed_on_init_port)\0"


def test_json_monitor(clients: Clients) -> None:
    player = clients.player()
    monitor = clients.open()
    monitor.send("(dispinit version -1)")
    told = [json.loads(monitor.receive()) for _ in range(21)]
    assert [next(iter(message)) for message in told[:20]] == ["server_param", "player_param", *["player_type"] * 18]
    frame = told[20]["show"]
    assert frame["mode"] == "before_kick_off" and len(frame["players"]) == PLAYERS
    assert frame["team"]["l"]["name"] == "keepers" and frame["team"]["r"]["name"] is None
    player.send('(say "hi")')
    while "msg" not in (message := json.loads(monitor.receive())):
        pass
    assert message["msg"]["message"] == "((player keepers 1) hi)"


def test_kick_off_and_messages(clients: Clients) -> None:
    clients.player()
    monitor = clients.monitor()
    monitor.send("(dispstart)")
    assert monitor.until(r"\(msg")[-1] == '(msg 0 1 "(referee play_on)")'
    assert monitor.until(r"\(show 1 \(pm 3\)")


@pytest.mark.parametrize(
    ("command", "reply"),
    [
        ("(nonsense)", "(error illegal_command_form)"),
        ("(dispplayer 1 1)", "(error illegal_command_form)"),
        ("(dispfoul 1)", "(error illegal_command_form)"),
        ("(dispcard 1 1 green)", "(error illegal_command_form)"),
        ("(compression 12)", "(error illegal_command_form)"),
        ("(start)", "(error illegal_command_form)"),
    ],
)
def test_replies(clients: Clients, command: str, reply: str) -> None:
    assert clients.monitor().ask(command, r"\(msg") == f'(msg 0 1 "{reply}")'


def test_a_message_without_nul(clients: Clients) -> None:
    monitor = clients.monitor()
    assert monitor.ask("(dispbye", r"\(msg", end="") == '(msg 0 1 "(warning message_not_null_terminated)")'


def test_goodbye(clients: Clients) -> None:
    monitor = clients.monitor()
    monitor.send("(dispbye)")
    wait_for(lambda: clients.server.clients.monitors == [])


def test_placing_players_dropping_the_ball_and_discarding() -> None:
    with serving(keepaway(send_comms=True)) as clients:
        player, monitor = clients.player(), clients.monitor()

        def shown(command: str, pattern: str) -> str:
            player.until(r"\(think\)")
            monitor.send(command)
            for _ in range(5):
                player.send("(done)")
                show = monitor.until(r"\(show ")[-1]
                if re.search(pattern, show):
                    return show
                player.until(r"\(think\)")
            raise AssertionError(f"no {pattern} after {command}: {show}")

        shown("(dispstart)", r"\(pm 3\)")
        assert shown("(dispplayer 1 1 160 -48 90)", r"\(\(l 1\) 0 0x1 10 -3 0 0 90 0 ")
        assert shown("(dispfoul 16 16 0)", r"\(\(b\) 1 1 0 0\)")
        assert shown("(dispfoul 32 16 1)", r"\(pm 8\) .*\(\(b\) 2 1 0 0\)")
        player.until(r"\(think\)")
        monitor.send("(dispdiscard 1 1)")
        assert monitor.until(r"\(show .*\(\(l 1\) 0 0 -3 -37 ")


def test_cards() -> None:
    with serving(options(send_comms=True)) as clients:
        player, other = clients.player(), clients.player()
        monitor = clients.monitor(5)
        monitor.send("(dispcard 1 1 yellow)")
        assert monitor.until(r"\(msg")[-1] == '(msg 0 1 "(referee yellow_card_l_1)")'
        assert monitor.until(r"\(show .*\(\(l 1\) 0 0x40001 ")
        monitor.send("(dispcard 1 1 yellow)")
        assert [m for m in monitor.until(r"\(show .*\(\(l 1\) 0 0x80000 -3 -37 ") if m.startswith("(msg")] == [
            '(msg 0 1 "(referee yellow_card_l_1)")',
            '(msg 0 1 "(referee red_card_l_1)")',
        ]
        assert player.until(r"\(hear 0 referee red_card_l_1\)") and other.until(r"\(hear 0 referee red_card_l_1\)")
        monitor.send("(dispcard 1 9 red)")  # nobody there
        again = clients.open()
        assert again.ask("(reconnect keepers 1)", r"\((reconnect|error)") == "(error red_carded_player)"
        monitor.send("(dispcard 1 2 red)")
        assert monitor.until(r"\(msg")[-1] == '(msg 0 1 "(referee red_card_l_2)")'
        assert monitor.until(r"\(show .*\(\(l 2\) 0 0x80000 ")


def test_no_cards_in_version_11() -> None:
    with serving(options(profile="11.1")) as clients:
        clients.player()
        monitor = clients.open()
        monitor.send("(dispinit version 2)")
        monitor.receive_bytes()
        monitor.send("(dispcard 1 1 red)")
        datagrams = (monitor.receive_bytes() for _ in range(30))
        assert any(b"(error illegal_command_form)" in data for data in datagrams)


def test_replies_in_coach_mode() -> None:
    with serving(options(coach_w_referee=True)) as clients:
        clients.player()
        monitor = clients.monitor()
        for command, reply in (
            ("(change_mode play_on)", "(ok change_mode)"),
            ("(change_mode foo)", "(error illegal_mode)"),
            ("(move (ball) 1 1)", "(ok move)"),
            ("(move (player keepers 1) 5 5)", "(ok move)"),
            ("(recover)", "(ok recover)"),
            ("(start)", "(ok start)"),
        ):
            assert re.fullmatch(rf'\(msg \d+ 1 "{re.escape(reply)}"\)', monitor.ask(command, r"\(msg"))
        assert re.fullmatch(r'\(msg \d+ 1 "\(ok check_ball \d+ in_field\)"\)', monitor.ask("(check_ball)", r"\(msg"))


def test_compressed_frames(clients: Clients) -> None:
    monitor = clients.monitor()
    assert monitor.ask("(compression 6)", r"\(msg") == '(msg 0 1 "(ok compression 6)")'
    assert zlib.decompressobj().decompress(monitor.receive_bytes()).startswith(b"(show 0 ")


def test_no_more_monitors_than_wanted() -> None:
    with serving(options(max_monitors=1)) as clients:
        clients.monitor()
        second: Client = clients.open()
        second.send("(dispinit version 4)")
        assert second.receive() == "(error no_more_monitor)"
