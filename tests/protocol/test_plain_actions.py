"""Datagrams in the plain form: read straight into an ACTION record, and read there as servers read them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcss_hat.protocol.commands import Command, Dash, Done, Kick, Say, Turn, TurnNeck, action_to_bytes, parse_commands
from rcss_hat.protocol.commands.action import ACTS, IS_DONE, NOT_PLAIN, read_action
from rcss_hat.protocol.records import ACTION, DASH, KICK, TURN, empty

from .mutations import mutated

PLAIN = [
    b"(dash 100)(turn_neck -5)(done)\0",
    b'(kick 56 -12)(turn_neck 3)(say "1wtAA10Gr")(done)\0',
    b'(turn -0)(say "a b")\0',
    b"(turn 123456789)(done)\0",
    b'(say "(done)")\0',
    b"(done)\0",
]


def spelled_out(action, found: int) -> list[Command]:  # type: ignore[no-untyped-def]
    """What an action says as commands."""
    a, b = float(action["a"][0]), float(action["b"][0])
    body = {DASH: Dash(a), TURN: Turn(a), KICK: Kick(a, b)}.get(int(action["kind"][0]))
    commands: list[Command] = [] if body is None else [body]
    if action["turns_neck"][0]:
        commands.append(TurnNeck(float(action["neck"][0])))
    if n := int(action["say_n"][0]):
        commands.append(Say(bytes(action["say"][0, :n]).decode()))
    return [*commands, Done()] if found & IS_DONE else commands


@given(mutated(PLAIN))
def test_what_is_plain_is_read_as_servers_read_it(data: bytes) -> None:
    action = empty(ACTION)
    found = read_action(data, action)
    if found != NOT_PLAIN:
        for profile in ("11.1", "19.0"):
            assert parse_commands(data, profile) == (spelled_out(action, found), True)


@given(
    st.sampled_from([0, DASH, TURN, KICK]),
    st.integers(-999_999, 999_999),
    st.integers(-999_999, 999_999),
    st.none() | st.integers(-180, 180),
    st.text("0123456789abcXYZ ().+-*/?<>_", max_size=10),
    st.booleans(),
)
def test_what_players_write_is_plain(kind: int, a: int, b: int, neck: int | None, said: str, done: bool) -> None:
    action, again = empty(ACTION), empty(ACTION)
    action["kind"], action["a"] = kind, a
    action["b"] = b if kind == KICK else 0
    action["turns_neck"], action["neck"] = neck is not None, neck or 0
    action["say_n"] = len(said)
    action["say"][0, : len(said)] = list(said.encode())
    data = action_to_bytes(action)
    if done:
        data = data[:-1] + b"(done)\0"
    if data:
        found = read_action(data, again)
        assert found == (ACTS if len(data) > len(b"(done)\0") or not done else 0) + (IS_DONE if done else 0)
        assert spelled_out(again, 0) == spelled_out(action, 0)


@pytest.mark.parametrize(
    "data",
    [
        b"", b"\0", b"(dash 100)", b"(dash 1e2)\0", b"(dash 1.5)\0", b"(dash 100 30)\0", b"(dash +1)\0", b"(turn -0)\0",
        b"(turn 007)\0", b"(turn 1234567890)\0", b"(kick 10)\0", b"(kick 10 20 30)\0", b"(dash 100) (done)\0",
        b"(dash 100)(done)\n\0", b"(done)(dash 100)\0", b"(turn_neck 5)(dash 100)\0", b"(dash 1)(turn 1)\0",
        b'(say "")\0', b'(say "12345678901")\0', b'(say "a#")\0', b"(say abc)\0", b"(dash 100)\0(done)\0", b"(bye)\0",
        b"(done)(done)\0", b"(tackle 100)\0", b"(move -1 0)\0",
    ],
)  # fmt: skip
def test_other_forms_are_left_to_the_servers_scanner(data: bytes) -> None:
    assert read_action(data, empty(ACTION)) == NOT_PLAIN
