from __future__ import annotations

from itertools import permutations

import pytest

from rcss_hat.protocol import messages
from rcss_hat.protocol.commands import Init, Reconnect, parse_init
from rcss_hat.protocol.errors import LocalProtocolError, RemoteProtocolError
from rcss_hat.protocol.session import KEPT, Handshake, State

from .recorded import received

PLACE = b"(init r 3 before_kick_off)\0"
PARAMS = b"(server_param (synch_mode 1))\0"
SENSE = b"(sense_body 0 (view_mode high normal) (stamina 8000 1) (speed 0 0))\0"
SEE = b"(see 0)\0"
KNOWN = b"(error only_init_allowed_on_init_port)\0"


def told(*data: bytes) -> Handshake:
    handshake = Handshake("keepers", 11)
    for datagram in data:
        handshake.receive(datagram)
    return handshake


def test_joining() -> None:
    handshake = Handshake("keepers", 11)
    assert parse_init(handshake.request) == Init("keepers", 11)
    assert handshake.state is State.ASKING
    handshake.receive(PLACE)
    assert (handshake.state, handshake.joined) == (State.PLACED, False)
    handshake.receive(PARAMS)
    assert handshake.joined
    assert handshake.place == messages.Init(side="r", unum=3, mode="before_kick_off")
    assert handshake.told() == [PARAMS]


def test_whatever_overtakes_is_kept_and_told_in_the_right_order() -> None:
    for order in permutations([PLACE, PARAMS, SENSE]):
        handshake = told(*order)
        assert handshake.joined
        assert handshake.place is not None and handshake.place.unum == 3
        assert handshake.told() == [PARAMS, SENSE]
    assert told(SEE, SENSE, PARAMS, PLACE).told() == [PARAMS, SEE, SENSE]


def test_what_was_doubled_changes_nothing() -> None:
    handshake = told(PLACE, PLACE, KNOWN, PARAMS, KNOWN, PLACE, PARAMS, SENSE)
    assert handshake.told() == [PARAMS, SENSE]
    assert handshake.state is State.JOINED


def test_an_answer_to_a_repeated_init_is_no_refusal() -> None:
    handshake = told(KNOWN)
    assert handshake.state is State.ASKING
    handshake.receive(PLACE)
    assert handshake.state is State.PLACED


def test_a_refused_player_is_told_why() -> None:
    with pytest.raises(RemoteProtocolError, match="the server refuses 'keepers': no_more_team"):
        told(b"(error no_more_team)\0")
    told(PLACE, b"(error no_more_team)\0", PARAMS)  # of one that was doubled


def test_coming_back() -> None:
    handshake = Handshake("keepers", 11, 3)
    assert parse_init(handshake.request) == Reconnect("keepers", 3)
    handshake.receive(PARAMS)
    handshake.receive(b"(reconnect l drop_ball)\0")
    assert handshake.place == messages.Init(side="l", unum=3, mode="drop_ball")
    with pytest.raises(RemoteProtocolError, match="asked for a new place"):
        told(b"(reconnect l drop_ball)\0")


def test_nobody_plays_before_joining() -> None:
    with pytest.raises(LocalProtocolError, match="'keepers' has not joined"):
        told(PLACE, SENSE).told()


def test_what_is_kept_has_a_limit() -> None:
    handshake = told(*[b"(see %d)\0" % cycle for cycle in range(3 * KEPT)], PLACE, PARAMS)
    assert handshake.told() == [PARAMS, *[b"(see %d)\0" % cycle for cycle in range(2 * KEPT, 3 * KEPT)]]


def test_a_malformed_message_is_named() -> None:
    with pytest.raises(RemoteProtocolError, match="at byte"):
        told(b"(init l")


def test_a_recorded_conversation() -> None:
    handshake = Handshake("left", 11)
    for datagram in received():
        if datagram.file == "versions" and datagram.client == "k_v19":
            handshake.receive(datagram.text.encode() + b"\0")
    assert handshake.place is not None
    assert (handshake.place.side, handshake.place.unum) == ("l", 8)
    assert handshake.params is not None
    assert b"(coach_w_referee 1)" in handshake.params
