"""Whatever a server sends: a player answers with legal commands or says what was wrong, and goes on playing."""

from __future__ import annotations

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from protocol.mutations import mutated
from protocol.recorded import received

from rcss_hat.keepaway.patience import WAIT_FOR_SEE
from rcss_hat.keepaway.session import DONE, KeepawayPlayer
from rcss_hat.protocol import messages
from rcss_hat.protocol.commands import parse_commands
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.protocol.session import Handshake

OF_PLAYERS = re.compile(
    r"\((see|sense_body|hear|server_param|player_param|player_type|ok|error|warning|init|fullstate|think|score|change_p)"
)
EVERYTHING = [d.text.encode("latin-1") + b"\0" for d in received() if OF_PLAYERS.match(d.text)]
SENSES = [data for data in EVERYTHING if data.startswith(b"(sense_body")]
SEES = [data for data in EVERYTHING if data.startswith(b"(see")]
HEARS = [data for data in EVERYTHING if data.startswith(b"(hear")]
PARAMS = [data for data in EVERYTHING if data.startswith(b"(server_param")]
PLAY_ON = b"(hear 0 referee play_on)\0"
SENSE = b"(sense_body 7 (view_mode high normal) (stamina 8000 1) (speed 0 0) (head_angle 0))\0"


def at(cycle: int, data: bytes) -> bytes:
    """The same message of another cycle."""
    return re.sub(rb"^(\(\w+) -?\d+", rb"\1 %d" % cycle, data)


def joined(side: str = "l", unum: int = 1, synch: bool = True, n_keepers: int = 3) -> KeepawayPlayer:
    player = KeepawayPlayer("keepers", n_keepers, 2, 1, lambda cycle, status, reward, state: cycle % n_keepers)
    player.initialised(messages.Init(side=side, unum=unum, mode="before_kick_off"))
    player.receive(b"(server_param (synch_mode %d) (visible_angle 360))\0" % synch)
    return player


@st.composite
def cycles(draw) -> list[list[bytes]]:
    """What a player is told, cycle by cycle: real messages, of this cycle or any, and mutated ones."""
    told = []
    for cycle in range(1, draw(st.integers(2, 12))):
        messages = []
        for kind in (SENSES, SEES, HEARS):
            how = draw(st.sampled_from(["as it was", "now", "now", "mutated", "none"]))
            data = draw(mutated(kind) if how == "mutated" else st.sampled_from(kind))
            if how != "none":
                messages.append(at(cycle, data) if how == "now" else data)
        if draw(st.booleans()):
            messages.append(draw(mutated(EVERYTHING)))
        told.append(messages)
    return told


def tell(player: KeepawayPlayer, data: bytes) -> list[bytes]:
    try:
        return player.receive(data)
    except RemoteProtocolError as error:
        assert str(error)
        return []


def check(answers: list[bytes]) -> None:
    for answer in answers:
        commands, complete = parse_commands(answer)
        assert complete, answer
        assert commands, answer


@settings(max_examples=150)
@given(st.sampled_from("lr"), st.integers(1, 11), st.booleans(), mutated(PARAMS), cycles())
def test_no_message_harms_a_player(side: str, unum: int, synch: bool, params: bytes, told: list[list[bytes]]) -> None:
    player = joined(side, unum, synch)
    tell(player, params)
    tell(player, PLAY_ON)
    for datagrams in told:
        for data in datagrams:
            check(tell(player, data))
        wait = player.wait()
        assert wait is None or 0.0 <= wait <= WAIT_FOR_SEE * 1000.0
        check(tell(player, b"(think)\0") if player.synch else player.deadline())
    cycle = player.cycle + 1
    tell(player, at(cycle, PLAY_ON))
    for data in (at(cycle, SENSE), *(at(cycle, see) for see in SEES[:1])):
        assert tell(player, data) == []
    answers = player.receive(b"(think)\0")
    assert len(answers) == 1 and answers[0].endswith(DONE)
    check(answers)


@given(mutated(EVERYTHING))
def test_any_first_reply_is_taken_or_refused(data: bytes) -> None:
    player = KeepawayPlayer("keepers", 3, 2, 1, lambda *_: 0)
    try:
        handshake = Handshake("keepers", 11)
        handshake.receive(data)
    except RemoteProtocolError as error:
        assert str(error)
        return
    assert not handshake.joined  # the parameters, or the place, are yet to come
    if handshake.place is not None:
        player.initialised(handshake.place)
        assert 1 <= player.unum <= 11


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (
            b"(sense_body 1 (view_mode high normal) (stamina 8000 1) (speed 0 0) (head_angle 2147483647))",
            "out of range",
        ),
        (b"(sense_body 1 (view_mode high normal) (stamina 8000 1) (speed 0 -100000))", "out of range"),
        (b"(sense_body 1 (view_mode high normal) (stamina 8000 1e308) (speed 0 0))", "out of range"),
        (b"(see 1 ((f c) 10 99999999))", "out of range"),
        (b"(see 1 ((b) 1e300 10))", "out of range"),
        (b"(server_param (maxmoment -1e308))", "maxmoment is -1e[+]308; our players can play with 1 to 360"),
        (b"(server_param (player_decay 1))", "player_decay is 1"),
        (b"(server_param (player_decay 0))", "player_decay is 0"),
    ],
)
def test_numbers_that_nobody_can_calculate_with_are_named(data: bytes, says: str) -> None:
    player = joined()
    player.receive(PLAY_ON)
    player.receive(SENSE)
    with pytest.raises(RemoteProtocolError, match=says):
        player.receive(data)
    check(player.receive(b"(think)\0"))
