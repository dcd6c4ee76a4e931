from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcss_hat.protocol import messages, records
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.protocol.hear import (
    HEARD_LONG,
    HEARD_OPPONENT,
    HEARD_OTHER,
    HEARD_PARTIAL,
    HEARD_REFEREE,
    HEARD_SELF,
    HEARD_TEAM_MATE,
    parse_hear_fast,
)

from .recorded import received


def untouched() -> np.ndarray:
    heard = records.empty(records.HEARD)
    heard["time"][0] = -1
    return heard


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("(hear 5 referee play_on)", HEARD_REFEREE),
        ("(hear 5 referee training Keepaway 1)", HEARD_REFEREE),
        ('(hear 5 self "x")', HEARD_SELF),
        ('(hear 5 -12 opp "x")', HEARD_OPPONENT),
        ("(hear 5 our 2)", HEARD_PARTIAL),
        ("(hear 5 opp)", HEARD_PARTIAL),
        ('(hear 5 coach "x")', HEARD_OTHER),
        ('(hear 5 12 "x")', HEARD_OTHER),
        ('(hear 5 12 our 2 "12345678901")', HEARD_LONG),
        ('(hear 5 12 our 12 "x")', HEARD_OTHER),
        ('(hear 5 12 our 2 "x)', HEARD_OTHER),
        ('(hear 5 12 our 2 "x") y', HEARD_OTHER),
        ("(hear referee 5 play_on)", HEARD_OTHER),
        ("(hearing 5 referee play_on)", HEARD_OTHER),
        ("(hear 5 ours 2)", HEARD_OTHER),
        ("(see 5)", HEARD_OTHER),
        ("", HEARD_OTHER),
    ],
)
def test_kinds(text: str, kind: int) -> None:
    heard = untouched()
    assert parse_hear_fast(text.encode() + b"\0", heard) == kind
    assert heard == untouched()


@pytest.mark.parametrize(("said", "n"), [("1zuVx10Et", 9), ("", 0), ("a)b(c (d)", 9), ("0123456789", 10)])
def test_a_team_mates_words(said: str, n: int) -> None:
    heard = records.empty(records.HEARD)
    heard["text"] = 1
    assert parse_hear_fast(f'(hear 15 -99 our 2 "{said}")'.encode(), heard) == HEARD_TEAM_MATE
    assert (heard["time"][0], heard["direction"][0], heard["unum"][0], heard["n"][0]) == (15, -99.0, 2, n)
    assert bytes(heard["text"][0]) == said.encode().ljust(records.SAY_SIZE, b"\0")


def test_recorded_messages_as_the_thorough_parser_reads_them() -> None:
    kinds = {"referee": HEARD_REFEREE, "self": HEARD_SELF, "coach": HEARD_OTHER, "player": HEARD_OTHER}
    kinds |= {"our": HEARD_TEAM_MATE, "opp": HEARD_OPPONENT}
    for datagram in received("(hear "):
        event = messages.parse(datagram.text.encode())
        assert isinstance(event, messages.Hear)
        heard = untouched()
        kind = parse_hear_fast(datagram.text.encode(), heard)
        if datagram.client == "trainer" and event.source == "referee" and kind == HEARD_OTHER:
            continue
        assert kind == (HEARD_PARTIAL if event.text is None else kinds[event.source])
        if kind == HEARD_TEAM_MATE:
            assert event.text is not None
            assert (heard["time"][0], heard["direction"][0]) == (event.time, event.direction)
            assert bytes(heard["text"][0][: heard["n"][0]]) == event.text.encode()


@given(st.binary(max_size=60))
def test_random_bytes_do_no_harm(data: bytes) -> None:
    heard = records.empty(records.HEARD)
    for start in (b"", b"(hear ", b"(hear 5 ", b'(hear 5 12 our 2 "'):
        text = start + data
        kind = parse_hear_fast(text, heard)
        assert HEARD_OTHER <= kind <= HEARD_LONG
        if kind == HEARD_TEAM_MATE:
            assert 0 <= heard["n"][0] <= records.SAY_SIZE
            assert 1 <= heard["unum"][0] <= records.MAX_PLAYERS
        try:
            messages.parse(text)
        except RemoteProtocolError:
            assert kind != HEARD_TEAM_MATE
