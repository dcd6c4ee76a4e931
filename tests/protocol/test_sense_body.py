from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcss_hat.protocol import records
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.protocol.sense_body import parse_sense_body

from .recorded import received

SHORT = "(sense_body 7 (view_mode high normal) (stamina 8000 1) (speed 0 0)"
NUMBER = r"(-?[\d.]+(?:e-?\d+)?)"


def parse(text: str | bytes) -> np.ndarray:
    sense = records.empty(records.SENSE_BODY)
    parse_sense_body(text if isinstance(text, bytes) else text.encode(), sense)
    return sense


def values(sense: np.ndarray) -> dict[str, Any]:
    return {name: sense[name][0].tolist() for name in records.SENSE_BODY.names or ()}


def by_regular_expressions(text: str) -> dict[str, Any]:
    """Read a sense_body message of versions 7 to 19 in an independent, slow way."""
    pattern = (
        r"\(sense_body (?P<time>\d+) \(view_mode (?P<quality>high|low) (?P<width>narrow|normal|wide)\)"
        r" \(stamina N N(?: N)?\) \(speed N N\) \(head_angle N\)"
        + "".join(rf" \({name} (?P<{name}>\d+)\)" for name in _PRINTED)
        + r"(?: \(change_focus \d+\))?(?: \(arm \(movable (?P<movable>\d+)\) \(expires (?P<expires>\d+)\)"
        r" \(target N N\) \(count (?P<arms>\d+)\)\)"
        r" \(focus \(target (?P<target>none|[lr] \d+)\) \(count (?P<focus>\d+)\)\)"
        r" \(tackle \(expires (?P<immobile>\d+)\) \(count (?P<tackles>\d+)\)\))?"
        r"(?: \(collision(?P<collision>(?: none|(?: \(\w+\))*))\))?"
        r"(?: \(foul \(charged \d+\) \(card \w+\)\))?(?: \(focus_point N N\))?\)"
    ).replace("N", NUMBER)
    match = re.fullmatch(pattern, text)
    assert match, text
    numbers = [
        None if match[i] is None else float(match[i]) for i in range(1, match.re.groups + 1) if i in _plain(match)
    ]
    stamina, effort, capacity, speed, speed_direction, head_angle, distance, direction, *_ = numbers
    target = match["target"] or "none"
    collided = {"(ball)": 1, "(player)": 2, "(post)": 4, "none": 0}
    return {
        "time": int(match["time"]),
        "quality": int(match["quality"] == "high"),
        "width": ("narrow", "normal", "wide").index(match["width"]),
        "stamina": stamina,
        "effort": effort,
        "capacity": -1.0 if capacity is None else capacity,
        "speed": speed,
        "speed_direction": speed_direction,
        "head_angle": head_angle,
        "counts": [int(match[name]) for name in records.COUNT_NAMES],
        "arm_movable": int(match["movable"] or 0),
        "arm_expires": int(match["expires"] or 0),
        "arm_distance": distance or 0.0,
        "arm_direction": direction or 0.0,
        "arm_count": int(match["arms"] or 0),
        "focus_side": 0 if target == "none" else " lr".index(target[0]),
        "focus_unum": 0 if target == "none" else int(target[2:]),
        "focus_count": int(match["focus"] or 0),
        "tackle_expires": int(match["immobile"] or 0),
        "tackle_count": int(match["tackles"] or 0),
        "has_collision": int(match["collision"] is not None),
        "collision": sum(collided[word] for word in (match["collision"] or "").split()),
    }


def _plain(match: re.Match[str]) -> set[int]:
    return set(range(1, match.re.groups + 1)) - set(match.re.groupindex.values())


_PRINTED = ("kick", "dash", "turn", "say", "turn_neck", "catch", "move", "change_view")


def test_recorded_messages_are_read_exactly() -> None:
    messages = received("(sense_body ")
    assert len(messages) > 300
    for datagram in messages:
        assert repr(values(parse(datagram.text))) == repr(by_regular_expressions(datagram.text))


def test_what_is_missing_has_a_default() -> None:
    sense = parse(received("(sense_body ")[-1].text)
    parse_sense_body(SHORT.encode() + b")\0", sense)
    expected = dict.fromkeys(records.SENSE_BODY.names or (), 0)
    expected |= {"time": 7, "quality": 1, "width": 1, "stamina": 8000, "effort": 1, "capacity": -1, "counts": [0] * 8}
    assert values(sense) == expected


@pytest.mark.parametrize(
    ("part", "expected"),
    [
        ("(collision none)", {"has_collision": 1, "collision": 0}),
        ("(collision (ball) (post))", {"has_collision": 1, "collision": 5}),
        ("(collision (player))", {"has_collision": 1, "collision": 2}),
        ("(stamina 7000 0.9 130600)", {"stamina": 7000.0, "capacity": 130600.0}),
        ("(focus (target r 11) (count 3))", {"focus_side": 2, "focus_unum": 11, "focus_count": 3}),
        ("(focus (target none) (count 3))", {"focus_side": 0, "focus_unum": 0, "focus_count": 3}),
        ("(foul (charged 0) (card none)) (tackle (expires 4) (count 5))", {"tackle_expires": 4, "tackle_count": 5}),
        ("(focus_point 0 0) (change_focus 3) (head_angle -12)", {"head_angle": -12.0}),
        ("(arm (movable 1) (expires 2) (target 3.5 -4) (count 5))", {"arm_expires": 2, "arm_distance": 3.5}),
        ("(arm (new (thing)) (count 5))", {"arm_count": 5}),
        ("(speed 0.5)", {"speed": 0.5, "speed_direction": 0.0}),
    ],
)
def test_parts_of_all_versions(part: str, expected: dict[str, Any]) -> None:
    found = values(parse(f"{SHORT} {part})"))
    assert {name: found[name] for name in expected} == expected


@pytest.mark.parametrize(
    ("text", "position"),
    [
        ("", 0),
        ("(sense_bod 1)", 1),
        ("(sense_body)", 11),
        ("(sense_body x)", 12),
        ("(sense_body 7)", 14),
        (SHORT, 66),
        (SHORT + ") x", 68),
        (SHORT + "()", 67),
        (SHORT + "(kick x))", 72),
        (SHORT + "(kick 1 2))", 74),
        (SHORT + "(stamina 1))", 77),
        (SHORT + "(stamina 1 2 3 4))", 81),
        (SHORT + "(view_mode high odd))", 82),
        (SHORT + "(view_mode odd wide))", 77),
        (SHORT + "(focus (target l 12)))", 86),
        (SHORT + "(focus (target x 1)))", 81),
        (SHORT + "(collision (wall)))", 78),
        (SHORT + "(unknown (a) (b)", 74),
        (SHORT + "(arm (target 1)))", 81),
        (SHORT + "(arm (count 1) x))", 81),
        (SHORT + "(focus (target none x)))", 86),
        (SHORT + "(collision (ball x)))", 82),
        (SHORT + "(collision none x))", 82),
        (SHORT + "(view_mode high wide x))", 87),
        (SHORT + "(head_angle nan))", 78),
    ],
)
def test_malformed_messages_name_the_place(text: str, position: int) -> None:
    with pytest.raises(RemoteProtocolError, match="bad sense_body message") as error:
        parse(text)
    assert error.value.position == position


@pytest.mark.parametrize("wrong", ["(head_angle 361)", "(speed 0 -400)", "(speed 1e7)", "(stamina 8000 -1e9)"])
def test_numbers_that_no_server_writes_are_refused(wrong: str) -> None:
    sense = records.empty(records.SENSE_BODY)
    with pytest.raises(RemoteProtocolError, match="a number out of range"):
        parse_sense_body(f"{SHORT}{wrong})".encode(), sense)
    assert sense == records.empty(records.SENSE_BODY)


def try_to_parse(text: bytes) -> None:
    try:
        sense = parse(text)
    except RemoteProtocolError as error:
        assert 0 <= error.position <= len(text)
    else:
        assert np.isfinite(sense["stamina"][0])
        assert abs(sense["head_angle"][0]) <= 360.0
        assert sense["focus_unum"][0] <= records.MAX_PLAYERS


@given(st.binary(max_size=200))
def test_random_bytes_do_no_harm(data: bytes) -> None:
    try_to_parse(data)
    try_to_parse(SHORT.encode() + data)
    try_to_parse(SHORT.encode() + b"(arm (" + data)
    try_to_parse(SHORT.encode() + b"(collision " + data)


@given(st.data())
def test_mutated_messages_do_no_harm(data: st.DataObject) -> None:
    text = bytearray(data.draw(st.sampled_from(received("(sense_body "))).text.encode())
    for _ in range(data.draw(st.integers(1, 3))):
        place = data.draw(st.integers(0, len(text) - 1))
        text[place] = data.draw(st.sampled_from(b"() \0abc-.e0915\xff"))
    try_to_parse(bytes(text))
    try_to_parse(bytes(text[: data.draw(st.integers(0, len(text)))]))
