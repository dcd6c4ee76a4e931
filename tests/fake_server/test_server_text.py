"""Every recorded message that the server writes is written again, byte for byte."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from recorded_state import (
    Message,
    focus_of_sense_body,
    index_of,
    match_of_fullstate,
    received,
    version_of,
)

from fake_server import text
from fake_server.options import parse_value
from fake_server.param_text import EVERYTHING, all_params, json_params, player_param, player_type, server_param
from fake_server.player_param import BY_NAME as PLAYER_PARAMETERS
from fake_server.player_param import PlayerParams
from rcss_hat.protocol.commands import MAX_DATAGRAM
from rcss_hat.protocol.digits import ascii_bytes, put_hex, put_int, put_number
from rcss_hat.protocol.messages import Hear, parse
from rcss_hat.protocol.params import BY_NAME as SERVER_PARAMETERS
from rcss_hat.protocol.params import ServerParams
from rcss_hat.protocol.records import SEE, SENSE_BODY, empty
from rcss_hat.protocol.see import parse_see, team_names, write_see
from rcss_hat.protocol.sense_body import parse_sense_body
from rcss_hat.simulation.hearing import HEAR_FULL, HEAR_PART, HEAR_SELF
from rcss_hat.simulation.player_types import player_types
from rcss_hat.simulation.state import MATCH, MAX_MESSAGES

BUFFER = np.zeros(MAX_DATAGRAM, dtype=np.uint8)


def written(size: int) -> str:
    return BUFFER[:size].tobytes().decode("ascii")


# --- numbers ---------------------------------------------------------------------------------------------------------
@given(st.floats())
@example(0.0)
@example(-0.0)
@example(999999.5)
@example(99999.95)
@example(0.00009999995)
@example(123456.5)
@example(123457.5)
@example(5e-324)
@example(1.7976931348623157e308)
@example(0.1 + 0.2)
def test_numbers_have_six_significant_digits(value: float) -> None:
    assert written(put_number(BUFFER, 0, value)) == f"{value:g}"


@given(st.integers(100_000, 999_999), st.integers(-12, 12), st.sampled_from([-1, 0, 1]))
def test_ties_of_the_seventh_digit_round_as_printf_does(digits: int, exponent: int, beside: int) -> None:
    value = float(f"{digits}.5e{exponent}")
    value = np.nextafter(value, beside * np.inf) if beside else value
    assert written(put_number(BUFFER, 0, float(value))) == f"{value:g}"


@given(st.integers(-(2**62), 2**62))
def test_integers(number: int) -> None:
    assert written(put_int(BUFFER, 0, number)) == str(number)


@given(st.integers(0, 2**40))
def test_hexadecimal_numbers(number: int) -> None:
    assert written(put_hex(BUFFER, 0, number)) == (hex(number) if number else "0")


# --- see, sense_body, fullstate --------------------------------------------------------------------------------------
def _other_team(message: Message) -> str:
    names = set(re.findall(r'\(p "([^"]+)"', message.text)) - {message.team}
    assert len(names) <= 1
    return names.pop() if names else "nobody"


def test_see_is_written_as_it_was_read() -> None:
    see = empty(SEE)
    messages = received("(see ")
    assert len(messages) > 300
    for message in messages:
        parse_see(message.text.encode(), message.team.encode(), see)
        names, sizes = team_names(message.team, _other_team(message))
        assert written(write_see(see, names, sizes, BUFFER)) == message.text


def test_sense_body_is_written_as_it_was_read_in_every_version() -> None:
    sense = empty(SENSE_BODY)
    match = np.zeros(1, dtype=MATCH)
    versions = set()
    for message in received("(sense_body "):
        if "(card yellow)" in message.text or ("(charged 0)" not in message.text and "(foul" in message.text):
            continue
        parse_sense_body(message.text.encode(), sense)
        match["version"][0, 0] = version_of(message)
        focus_of_sense_body(message.text, match, 0)
        assert written(text.write_sense_body(sense, match, 0, BUFFER)) == message.text
        versions.add(version_of(message))
    assert versions >= {8, 11, 12, 13, 14, 18, 19}


def test_fullstate_is_written_as_it_was_read_in_every_version() -> None:
    versions = set()
    for message in received("(fullstate "):
        i = index_of(message)
        version = version_of(message)
        match = match_of_fullstate(message.text, i, version)
        mode = re.search(r"\(pmode (\w+)\)", message.text)[1]
        expires = int(re.search(r"\(expires (\d+)\)", message.text)[1])
        target = re.search(r"\(target [^)]*\)", message.text)[0]
        if not (version >= 14 or match["goalie"][0].sum() == 0 or (match["type"][0] == 0).all()):
            continue
        match["arm_expires"][0, i] = expires
        result = written(text.write_fullstate(match, i, ascii_bytes(mode), BUFFER))
        # the arm's numbers were computed from unrounded angles: compared apart
        assert _without_arms(result) == _without_arms(message.text)
        _assert_arms_close(result, message.text, target)
        versions.add(version)
    assert versions >= {8, 11, 13, 14, 18, 19}


_ARM = re.compile(r"(\(\(p [lr] \d+(?: g)?(?: \d+)?\)(?: [-\d.e]+){6})((?: [-\d.e]+){2})?(?= \()")


def _without_arms(message: str) -> str:
    return re.sub(r"\(target [^)]*\)", "", _ARM.sub(r"\1", message))


def _assert_arms_close(result: str, expected: str, target: str) -> None:
    for found, wanted in zip(_ARM.finditer(result), _ARM.finditer(expected), strict=True):
        if wanted[2] is None:
            assert found[2] is None
            continue
        got, want = ([float(v) for v in group.split()] for group in (found[2], wanted[2]))
        assert got[0] == pytest.approx(want[0], rel=1e-4, abs=1e-4)
        assert abs((got[1] - want[1] + np.pi) % (2 * np.pi) - np.pi) < 1e-3
    got = [float(v) for v in re.search(r"\(target (\S+) (\S+)\)", result).groups()]
    want = [float(v) for v in re.search(r"\(target (\S+) (\S+)\)", target).groups()]
    assert got[0] == pytest.approx(want[0], rel=1e-4, abs=1e-4)
    assert abs((got[1] - want[1] + 180) % 360 - 180) <= 1


# --- parameters ------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("version", [8, 11, 13, 14, 18, 19, EVERYTHING])
def test_parameters_are_told_as_recorded(version: int) -> None:
    client = "monitor_v4" if version == EVERYTHING else f"k_v{version}"
    messages = {m.text.split(" ")[0]: m.text for m in received("(") if m.file == "versions" and m.client == client}
    params, player_params = ServerParams(), PlayerParams()
    for name, value in re.findall(r"\((\w+) ([^()]*)\)", messages["(server_param"]):
        params.set(name, parse_value(SERVER_PARAMETERS[name], value))
    for name, value in re.findall(r"\((\w+) ([^()]*)\)", messages["(player_param"]):
        player_params.set(name, parse_value(PLAYER_PARAMETERS[name], value))
    assert server_param(params, version) == messages["(server_param"]
    assert player_param(player_params, version) == messages["(player_param"]
    types = player_types(params, int(player_params["random_seed"]), player_params.numbers())
    number = int(re.search(r"\(id (\d+)\)", messages["(player_type"])[1])
    assert player_type(types, number, version) == messages["(player_type"]


def test_json_tells_the_same_parameters() -> None:
    params, player_params = ServerParams(), PlayerParams()
    types = player_types(params, 1, player_params.numbers())
    texts, objects = all_params(params, player_params, types, EVERYTHING), json_params(params, player_params, types)
    assert len(texts) == len(objects) == 20
    for told, same in zip(texts, objects, strict=True):
        assert re.match(r"\((\w+)", told)[1] == re.match(r'\{"(\w+)"', same)[1]
        assert len(re.findall(r"\(\w+ [^()]*\)", told)) == same.count('":') - 1


# --- hear -----------------------------------------------------------------------------------------------------------
def _spoken(message: str) -> str:
    """Take a hear message of a player apart and let the kernel write it again."""
    form = r'\(hear (\d+)(?: (self))?(?: (-?\d+))?(?: our (\d+))?(?: (opp))?(?: "(.*)")?\)'
    time, own, direction, unum, opponent, said = re.fullmatch(form, message).groups()
    match, order = np.zeros(1, dtype=MATCH), np.zeros((MAX_MESSAGES, 2), dtype=np.int32)
    match["time"] = int(time)
    speaker = 11 if opponent else int(unum) - 1 if unum else 0
    listener = 10 if speaker != 10 else 9
    match["heard_by"][0, 0] = listener if own else speaker
    match["heard_n"][0, 0] = len(said or "")
    match["heard"][0, 0, : len(said or "")] = np.frombuffer((said or "").encode(), dtype=np.uint8)
    if direction:
        degrees = int(direction)
        angle = np.deg2rad(degrees + np.sign(degrees) * 0.4)  # the server cuts towards zero
        match["pos"][0, speaker] = np.cos(angle), np.sin(angle)
    order[0] = 0, HEAR_SELF if own else HEAR_FULL if said is not None else HEAR_PART
    ends = np.zeros(MAX_MESSAGES, dtype=np.int64)
    text.write_hear(match, listener, order, 1, BUFFER, ends)
    assert BUFFER[ends[0] - 1] == 0
    return written(int(ends[0]) - 1)


def test_hear_is_written_as_it_was_read() -> None:
    kinds = set()
    for message in received("(hear "):
        if message.client != "trainer" and "180" not in message.text:
            heard = parse(message.text.encode())
            assert isinstance(heard, Hear)
            told = heard.to_text() if heard.source in ("referee", "coach") else _spoken(message.text)
            assert told == message.text
            kinds.add(re.sub(r'-?\d+|".*"|referee .*', "", message.text))
    assert len(kinds) == 7


def test_several_voices_are_several_datagrams() -> None:
    match, order = np.zeros(1, dtype=MATCH), np.zeros((MAX_MESSAGES, 2), dtype=np.int32)
    match["heard_by"][0, :3] = 0, 1, 11
    match["heard_n"][0, :3] = 2
    match["heard"][0, :3, :2] = 65, 66
    order[:3] = (0, HEAR_SELF), (1, HEAR_FULL), (2, HEAR_PART)
    ends = np.zeros(MAX_MESSAGES, dtype=np.int64)
    text.write_hear(match, 0, order, 3, BUFFER, ends)
    assert written(int(ends[2])) == '(hear 0 self "AB")\0(hear 0 0 our 2 "AB")\0(hear 0 opp)\0'
