"""The players' language."""

from __future__ import annotations

import math

import numpy as np
import pytest
from player.beliefs import NOW, PARAMS, ball, know, player

from rcss_hat.player import hearing
from rcss_hat.player.records import NEVER, OPPONENTS
from rcss_hat.protocol.records import ACTION, DASH, HEARD, KICK, NO_COMMAND, TURN, empty


def heard(text):
    record = empty(HEARD)
    record["time"][0], record["unum"][0], record["n"][0] = NOW, 2, len(text)
    record["text"][0, : len(text)] = np.frombuffer(text.encode(), dtype=np.uint8)
    return record


def said(agent, kind=NO_COMMAND, a=0.0, b=0.0):
    action = empty(ACTION)
    hearing.speak(agent, PARAMS, kind, a, b, action)
    return bytes(action["say"][0, : action["say_n"][0]]).decode()


def ball_info(x, y, vx, vy, age):
    symbols = [hearing.encode(x, 106.0), hearing.encode(y, 68.0), hearing.encode(vx, 5.4), hearing.encode(vy, 5.4)]
    return "1" + bytes(symbols).decode() + str(age)


def test_symbols_are_the_lower_edges_of_their_cells():
    for span, value in ((106.0, -7.3), (68.0, 33.0), (5.4, -2.69), (106.0, 52.0)):
        back = hearing.decode(hearing.encode(value, span), span)
        assert back <= value < back + span / 73
    assert hearing.encode(-60.0, 106.0) == ord("0")
    assert hearing.encode(60.0, 106.0) == ord("_")
    assert chr(hearing.encode(0.0, 106.0)) == "A"


def test_the_ball_seen_near_by_is_told_with_its_velocity():
    agent = player((-5.0, 3.0))
    ball(agent, (0.0, 0.0), (1.0, -1.0))
    assert said(agent) == ball_info(0.0, 0.0, 1.0, -1.0, 1) + "0xD"


def test_a_ball_not_seen_in_this_cycle_is_not_told():
    agent = player((-5.0, 3.0))
    ball(agent, (0.0, 0.0), age=1)
    assert said(agent) == "0xD"


def test_a_held_ball_is_told_without_velocity_a_kicked_one_as_it_will_be():
    agent = player(body=0.0)
    ball(agent, (0.6, 0.0), (0.1, 0.0))
    assert said(agent, KICK, 5.0, 90.0).startswith(ball_info(0.6, 0.0, 0.0, 0.0, 1))
    agent["say_time"][0] = NEVER
    rate = 0.027 * (1.0 - 0.25 * (0.6 - 0.385) / 0.7)
    vx = 0.1 + 100.0 * rate
    assert said(agent, KICK, 100.0, 0.0).startswith(ball_info(0.6 + vx, 0.0, 0.94 * vx, 0.0, 0))
    agent["say_time"][0], agent["ball_seen"][0] = NEVER, NOW - 1
    assert said(agent, KICK, 100.0, 0.0).startswith("1"), "a pass is told even when the ball is not seen"
    agent["say_time"][0] = NEVER
    assert not said(agent, TURN, 10.0).startswith("1")


def test_the_nearest_opponent_seen_close_by_is_told():
    agent = player((-5.0, 3.0))
    know(agent, OPPONENTS, (-5.0, 5.9))
    know(agent, OPPONENTS + 1, (-5.0, 5.0))
    own = "0" + bytes([hearing.encode(-4.4, 106.0), hearing.encode(3.0, 68.0)]).decode()
    place = bytes([hearing.encode(-5.0, 106.0), hearing.encode(5.0, 68.0)]).decode()
    assert said(agent, DASH, 100.0) == "9" + place + "1" + own
    agent["say_time"][0] = NEVER
    ball(agent, (0.0, 0.0))
    assert said(agent) == ball_info(0.0, 0.0, 0.0, 0.0, 1) + "9" + place + "1", "no room for more"


def test_the_own_position_is_told_only_while_it_is_fresh():
    agent = player()
    agent["player_seen"][0, 0] = NOW - 8
    assert said(agent) == ""


def test_players_speak_once_per_hear_decay():
    agent = player()
    assert said(agent)
    assert not said(agent)
    agent["now"][0] += 1
    agent["player_seen"][0, 0] += 1
    assert said(agent)


def test_a_lost_ball_is_found_by_what_is_heard():
    agent = player()
    hearing.listen(agent, PARAMS, heard(ball_info(5.0, -3.0, 1.0, 0.5, 1)))
    vx, vy = (hearing.decode(hearing.encode(v, 5.4), 5.4) for v in (1.0, 0.5))
    x, y = hearing.decode(hearing.encode(5.0, 106.0), 106.0), hearing.decode(hearing.encode(-3.0, 68.0), 68.0)
    assert tuple(agent["ball_pos"][0]) == pytest.approx((x + vx, y + vy))
    assert tuple(agent["ball_vel"][0]) == pytest.approx((0.94 * vx, 0.94 * vy))
    assert agent["ball_seen"][0] == NOW - 2
    assert agent["hear_time"][0] == NOW


@pytest.mark.parametrize(
    ("distance", "seen", "changed", "velocity", "believed"),
    [
        (9.0, 0, 0, 1.0, False),  # seen just now
        (9.0, 1, 1, 1.0, True),  # velocity older than the message's, and another one
        (9.0, 1, 1, 0.1, False),  # the same velocity
        (2.0, 1, 1, 1.0, False),  # near: own eyes are better
        (9.0, 4, 4, 0.1, True),  # old
        (9.0, 1, 4, 0.1, False),  # position newer than the message's, and the same velocity
    ],
)
def test_when_a_heard_ball_is_believed(distance, seen, changed, velocity, believed):
    agent = player()
    ball(agent, (distance, 0.0), age=seen)
    agent["ball_change"][0] = NOW - changed
    hearing.listen(agent, PARAMS, heard(ball_info(5.0, 5.0, velocity, 0.0, 0)))
    assert (agent["ball_pos"][0, 1] != 0.0) == believed
    assert (agent["hear_time"][0] == NOW) == believed


def test_heard_opponents_are_believed_when_newer():
    agent = player()
    know(agent, OPPONENTS, (3.0, 3.0), (0.3, 0.0), age=2)
    know(agent, OPPONENTS + 1, (3.0, 3.0), (0.3, 0.0), age=3)
    hearing.listen(agent, PARAMS, heard("8AA19AA1"))
    assert tuple(agent["player_pos"][0, OPPONENTS]) == (3.0, 3.0)
    place = hearing.decode(ord("A"), 106.0), hearing.decode(ord("A"), 68.0)
    assert tuple(agent["player_pos"][0, OPPONENTS + 1]) == pytest.approx(place)
    assert tuple(agent["player_vel"][0, OPPONENTS + 1]) == (0.0, 0.0)
    assert agent["player_seen"][0, OPPONENTS + 1] == NOW - 2


def test_heard_teammates_by_number_but_never_oneself():
    agent = player(unum=1)
    hearing.listen(agent, PARAMS, heard("jAA1kAA1"))
    assert agent["player_seen"][0, 1] == NOW - 1
    assert tuple(agent["player_pos"][0, 0]) == (0.0, 0.0)


@pytest.mark.parametrize("text", ["0AA", "", "5A", "6AA7"])
def test_own_positions_and_unused_units_change_nothing(text):
    agent = player()
    before = agent.copy()
    hearing.listen(agent, PARAMS, heard(text))
    assert (agent == before).all()


@pytest.mark.parametrize("text", ["1AA", "1AAAA1xx", "2AA", "Z", "1AA AA1", '1AA"AA1', "8AA18A"])
def test_what_is_not_the_language_is_ignored_as_a_whole(text):
    agent = player()
    before = agent.copy()
    hearing.listen(agent, PARAMS, heard(text))
    assert (agent == before).all()


def test_numbers_are_rounded_the_same_way_everywhere():
    values = np.linspace(-53.0, 52.99, 500)
    cells = [math.floor((v + 53.0) / 106.0 * 73.0) for v in values]
    assert [hearing.ALPHABET.index(bytes([hearing.encode(v, 106.0)])) for v in values] == cells
