from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcss_hat.protocol import records
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.protocol.landmarks import LANDMARK_NAMES, LINE_NAMES
from rcss_hat.protocol.records import HAS_CHANGE, HAS_DISTANCE, HAS_FACING, HAS_POINTING, IS_KICKING, IS_TACKLING
from rcss_hat.protocol.see import parse_see

from .recorded import received

ENTRY = tuple(name for name in records.SEE.names or () if name not in ("time", "n"))
CODES = {name: code for code, name in enumerate(LANDMARK_NAMES)}
CODES |= {name: records.LINE + i for i, name in enumerate(LINE_NAMES)}
CODES |= {"b": records.BALL, "B": records.CLOSE_BALL, "P": records.CLOSE_PLAYER, "F": records.CLOSE_FLAG}
CODES |= {"G": records.CLOSE_GOAL}
FORMS = {
    1: (0, ("direction",)),
    2: (HAS_DISTANCE, ("distance", "direction")),
    3: (HAS_DISTANCE | HAS_POINTING, ("distance", "direction", "pointing")),
    4: (HAS_DISTANCE | HAS_CHANGE, ("distance", "direction", "distance_change", "direction_change")),
}
FORMS[6] = (FORMS[4][0] | HAS_FACING, (*FORMS[4][1], "body", "head"))
FORMS[7] = (FORMS[6][0] | HAS_POINTING, (*FORMS[6][1], "pointing"))


def parse(text: bytes, team: bytes = b"keepers") -> np.ndarray:
    see = records.empty(records.SEE)
    parse_see(text, team, see)
    return see


def entries(see: np.ndarray) -> list[dict[str, Any]]:
    return [{name: see[name][0, i].item() for name in ENTRY} for i in range(int(see["n"][0]))]


def by_regular_expressions(text: str, team: str) -> list[dict[str, Any]]:
    """Read a see message in an independent, slow way."""
    found = []
    for name, fields in re.findall(r"\(\(([^)]*)\)([^)]*)\)", text):
        entry: dict[str, Any] = dict.fromkeys(ENTRY, 0)
        values = [float(word) for word in fields.split() if word not in "tk"]
        entry["fields"], names = FORMS[len(values)]
        entry["fields"] |= IS_TACKLING * (" t" in fields) | IS_KICKING * (" k" in fields)
        entry.update(zip(names, values, strict=True))
        if name == "p" or name.startswith("p "):
            entry["code"] = records.PLAYER
            words = name.split()[1:]
            if words:
                entry["team"] = records.OWN_TEAM if words[0] == f'"{team}"' else records.OTHER_TEAM
            if len(words) > 1:
                entry["unum"] = int(words[1])
            entry["goalie"] = int("goalie" in words)
        else:
            entry["code"] = CODES[name]
        found.append(entry)
    return found


def test_recorded_messages_are_read_exactly() -> None:
    messages = received("(see ")
    assert len(messages) > 400
    for datagram in messages:
        see = parse(datagram.text.encode() + b"\0", datagram.team.encode())
        assert see["time"][0] == int(datagram.text.split()[1].rstrip(")"))
        assert repr(entries(see)) == repr(_typed(by_regular_expressions(datagram.text, datagram.team)))


def _typed(found: list[dict[str, Any]]) -> list[dict[str, Any]]:
    # repr tells -0.0 from 0.0 and 1 from 1.0
    kinds = {name: float if records.SEE[name].base.kind == "f" else int for name in ENTRY}
    return [{name: kinds[name](entry[name]) for name in ENTRY} for entry in found]


def test_every_name_has_its_code() -> None:
    for name, code in CODES.items():
        assert entries(parse(f"(see 1 (({name}) 5 6))".encode()))[0]["code"] == code


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("(p) 5 6", {"team": 0, "unum": 0, "fields": HAS_DISTANCE, "distance": 5.0, "direction": 6.0}),
        ('(p "keepers") 5 6', {"team": 1, "unum": 0}),
        ('(p "keeper") 5 6', {"team": 2}),
        ('(p "keepers2") 5 6', {"team": 2}),
        ('(p "keepers" 11 goalie) -3', {"team": 1, "unum": 11, "goalie": 1, "fields": 0, "direction": -3.0}),
        ('(p "takers" 2) 5 6 -0 0.1 90 -90', {"fields": HAS_DISTANCE | HAS_CHANGE | HAS_FACING, "head": -90.0}),
        ('(p "takers" 2) 5 6 0 0 1 2 33 t', {"fields": 63 & ~IS_KICKING, "pointing": 33.0, "body": 1.0}),
        ('(p "takers") 5 6 33', {"fields": HAS_DISTANCE | HAS_POINTING, "pointing": 33.0, "distance_change": 0.0}),
        ('(p "takers") 5 6 k', {"fields": HAS_DISTANCE | IS_KICKING}),
        ('(p "takers") 5 6 33 t', {"fields": HAS_DISTANCE | HAS_POINTING | IS_TACKLING}),
        ("(b) 1e1 -1.5e-2", {"distance": 10.0, "direction": -0.015}),
    ],
)
def test_forms_of_objects(text: str, expected: dict[str, Any]) -> None:
    entry = entries(parse(f"(see 12 ({text}))".encode()))[0]
    assert {name: entry[name] for name in expected} == expected


@pytest.mark.parametrize("end", ["", "\0", "\n", " \0", "\0junk"])
def test_messages_end_at_the_nul_or_the_last_byte(end: str) -> None:
    assert entries(parse(f"(see 1 ((b) 5 6)){end}".encode()))[0]["distance"] == 5.0


def test_nothing_seen() -> None:
    see = parse(b"(see 6)")
    assert (see["time"][0], see["n"][0]) == (6, 0)


def test_unknown_landmarks_are_left_out() -> None:
    see = parse(b"(see 6 ((f x y 99) 5 6) ((a very long name) 1) ((b) 7 8))")
    assert [entry["code"] for entry in entries(see)] == [records.BALL]


@pytest.mark.parametrize(
    ("text", "position"),
    [
        ("", 0),
        ("see", 0),
        ("(sea 1)", 1),
        ("(see)", 4),
        ("(see x)", 5),
        ("(see 1", 6),
        ("(see 1 b)", 7),
        ("(see 1 (b 5 6))", 8),
        ("(see 1 ((b) 5 6)", 16),
        ("(see 1 ((b) 5 nan))", 14),
        ("(see 1 ((b) 5 inf))", 14),
        ("(see 1 ((b) 5 1e999))", 14),
        ("(see 1 ((b)))", 11),
        ("(see 1 ((b) 1 2 3))", 11),
        ("(see 1 ((b) 1 2 3 4 5 6))", 11),
        ("(see 1 ((b) 5 6 t 7))", 18),
        ("(see 1 ((b) 5 6 x))", 16),
        ("(see 1 ((b) 5 6)) x", 18),
        ("(see 1 (() 5 6))", 9),
        ('(see 1 ((p "a" 12) 5 6))', 15),
        ('(see 1 ((p "a" 0) 5 6))', 15),
        ('(see 1 ((p "a" 3 striker) 5 6))', 17),
        ('(see 1 ((p "a) 5 6))', 20),
        ("(see 99999999999 ((b) 5 6))", 5),
    ],
)
def test_malformed_messages_name_the_place(text: str, position: int) -> None:
    see = parse(b"(see 1 ((b) 5 6))")
    with pytest.raises(RemoteProtocolError, match="bad see message") as error:
        parse_see(text.encode(), b"a", see)
    assert error.value.position == position
    assert see["n"][0] == 0


def test_too_many_objects() -> None:
    most = b" ((b) 5 6)" * records.MAX_SEEN
    assert parse(b"(see 1" + most + b")")["n"][0] == records.MAX_SEEN
    with pytest.raises(RemoteProtocolError, match="too many objects"):
        parse(b"(see 1" + most + b" ((b) 5 6))")


@pytest.mark.parametrize("wrong", ["(b) 1e7 0", "(b) 5 361", "(b) 5 0 -1e7 0", '(p "k" 1) 5 0 0 0 0 -400'])
def test_numbers_that_no_server_writes_are_refused(wrong: str) -> None:
    with pytest.raises(RemoteProtocolError, match="a number out of range"):
        parse(f"(see 1 ((f c) 5 0) ({wrong}))".encode())


def try_to_parse(text: bytes) -> None:
    see = records.empty(records.SEE)
    try:
        parse_see(text, b"keepers", see)
    except RemoteProtocolError as error:
        assert 0 <= error.position <= len(text)
        assert see["n"][0] == 0
    else:
        n = int(see["n"][0])
        assert 0 <= n <= records.MAX_SEEN
        assert np.isfinite(see["distance"][0, :n]).all()
        assert (np.abs(see["direction"][0, :n]) <= 360.0).all()
        assert (see["unum"][0, :n] <= records.MAX_PLAYERS).all()


@given(st.binary(max_size=200))
def test_random_bytes_do_no_harm(data: bytes) -> None:
    try_to_parse(data)
    try_to_parse(b"(see 1 ((" + data)
    try_to_parse(b'(see 1 ((p "keepers" ' + data)
    try_to_parse(b"(see 1 ((f c) " + data)


@given(st.data())
def test_mutated_messages_do_no_harm(data: st.DataObject) -> None:
    text = bytearray(data.draw(st.sampled_from(received("(see "))).text.encode())
    for _ in range(data.draw(st.integers(1, 3))):
        place = data.draw(st.integers(0, len(text) - 1))
        text[place] = data.draw(st.sampled_from(b'()" \0ptk-.e0915fgbl\xff'))
    try_to_parse(bytes(text))
    try_to_parse(bytes(text[: data.draw(st.integers(0, len(text)))]))
