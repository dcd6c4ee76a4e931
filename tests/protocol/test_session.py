from __future__ import annotations

import pytest

from rcss_hat.protocol import messages
from rcss_hat.protocol.commands import Bye, Compression, Dash, Done, Init, Say, Start, Turn, parse_init
from rcss_hat.protocol.errors import LocalProtocolError, RemoteProtocolError
from rcss_hat.protocol.session import PlayerSession, State

from .recorded import received


def joined() -> PlayerSession:
    session = PlayerSession()
    session.initialise("keepers")
    session.receive_data(b"(init r 3 before_kick_off)\0")
    return session


def test_joining() -> None:
    session = PlayerSession()
    assert parse_init(session.initialise("keepers", 11, goalie=True)) == Init("keepers", 11, True)
    assert session.state is State.JOINING
    session.receive_data(b"(init r 3 before_kick_off)\0")
    assert (session.state, session.side, session.unum, session.mode) == (State.PLAYING, "r", 3, "before_kick_off")
    assert session.send(Turn(5), Say("x")) == b'(turn 5)(say "x")\0'


def test_a_refused_player_may_try_again() -> None:
    session = PlayerSession()
    session.initialise("keepers")
    event = session.receive_data(b"(error no_more_team)")
    assert event == messages.Error(text="no_more_team")
    assert session.state is State.NEW
    session.initialise("takers")
    assert session.team == "takers"


def test_coming_back() -> None:
    session = PlayerSession()
    assert session.reconnect("keepers", 3) == b"(reconnect keepers 3)\0"
    session.receive_data(b"(reconnect l drop_ball)")
    assert (session.state, session.side, session.unum, session.mode) == (State.PLAYING, "l", 3, "drop_ball")


def test_nothing_may_be_sent_before_joining() -> None:
    session = PlayerSession()
    with pytest.raises(LocalProtocolError, match="Dash is not allowed in state new; allowed: Init, Reconnect"):
        session.send(Dash(50))
    session.initialise("keepers")
    with pytest.raises(LocalProtocolError, match="state joining"):
        session.send(Done())
    assert session.initialise("keepers")  # the first may have been lost


def test_nothing_may_be_sent_after_leaving() -> None:
    session = joined()
    with pytest.raises(LocalProtocolError, match="state gone; allowed: nothing"):
        session.send(Bye(), Turn(5))
    assert session.state is State.PLAYING
    session.send(Turn(5), Bye())
    assert session.state is State.GONE
    with pytest.raises(LocalProtocolError, match="Turn is not allowed"):
        session.send(Turn(5))
    session.receive_data(b"(see 5)")


def test_what_players_do_not_send() -> None:
    session = joined()
    for command in (Init("keepers"), Start()):
        with pytest.raises(LocalProtocolError, match="allowed: Bye, Command"):
            session.send(command)
    with pytest.raises(LocalProtocolError, match="does not compress"):
        session.send(Compression(5))
    with pytest.raises(LocalProtocolError, match="power"):
        session.send(Dash(500))
    assert session.state is State.PLAYING


def test_what_servers_do_not_send() -> None:
    session = PlayerSession()
    with pytest.raises(RemoteProtocolError, match="Think is not allowed in state new"):
        session.receive_data(b"(think)")
    session.initialise("keepers")
    with pytest.raises(RemoteProtocolError, match="allowed: Error, Init, Reconnect"):
        session.receive_data(b"(see 5)")


def test_the_play_mode_follows_the_referee() -> None:
    session = joined()
    for text, mode in (
        ("(hear 0 referee play_on)", "play_on"),
        ("(hear 9 referee training Keepaway 1)", "play_on"),
        ('(hear 9 self "drop_ball")', "play_on"),
        ("(hear 36 referee drop_ball)", "drop_ball"),
        ("(hear 40 referee goal_l_2)", "goal_l"),
    ):
        session.receive_data(text.encode())
        assert session.mode == mode


def test_a_recorded_conversation() -> None:
    session = PlayerSession()
    session.initialise("left")
    for datagram in received():
        if datagram.file == "versions" and datagram.client == "k_v19":
            session.receive_data(datagram.text.encode() + b"\0")
    assert (session.side, session.unum) == ("l", 8)
    assert session.params is not None
    assert session.params["coach_w_referee"] is True
    assert session.player_param is not None
    assert session.player_param.values["player_types"] == 3
    assert 0 in session.player_types
    assert session.types[4] == 1


def test_see_messages_know_the_own_team() -> None:
    event = joined().receive_data(b'(see 5 ((p "keepers" 2) 1 2))')
    assert isinstance(event, messages.See)
    assert event.record["team"][0, 0] == 1
