"""What players believe after a sense_body message."""

from __future__ import annotations

import math

import pytest
from player.beliefs import NOW, PARAMS, ball, know, player

from rcss_hat.player.bodily import feel
from rcss_hat.player.records import OPPONENTS
from rcss_hat.protocol.records import (
    COUNT_DASH,
    COUNT_KICK,
    COUNT_TURN,
    COUNT_TURN_NECK,
    DASH,
    KICK,
    SENSE_BODY,
    TURN,
    empty,
)

DECAY = 0.4


def sense(agent, speed=0.0, direction=0.0, head=0.0, **counts):
    record = empty(SENSE_BODY)
    record["time"][0] = agent["now"][0] + 1
    record["effort"][0] = 1.0
    record["speed"][0], record["speed_direction"][0], record["head_angle"][0] = speed, direction, head
    for name, index in (("kick", COUNT_KICK), ("dash", COUNT_DASH), ("turn", COUNT_TURN), ("neck", COUNT_TURN_NECK)):
        record["counts"][0, index] = counts.get(name, 0)
    return record


def sent(agent, kind, a, b=0.0, neck=0.0):
    agent["sent_time"][0] = agent["now"][0]
    agent["sent_kind"][0], agent["sent_a"][0], agent["sent_b"][0], agent["sent_neck"][0] = kind, a, b, neck


def test_the_sensed_speed_moves_the_player():
    agent = player((1.0, 2.0), body=90.0)
    feel(agent, PARAMS, sense(agent, 0.36, 0.0), True)
    assert agent["now"][0] == NOW + 1
    assert tuple(agent["pos"][0]) == pytest.approx((1.0, 2.0 + 0.36 / DECAY))
    assert tuple(agent["vel"][0]) == pytest.approx((0.0, 0.36))


def test_more_than_the_speed_limit_is_not_believed():
    agent = player()
    feel(agent, PARAMS, sense(agent, 0.44), True)
    assert tuple(agent["pos"][0]) == pytest.approx((1.05, 0.0))


def test_a_confirmed_turn_turns_by_what_the_speed_left_of_it():
    agent = player(vel=(0.2, 0.0))
    sent(agent, TURN, 60.0, neck=-15.0)
    # sensed after decay: it turned while rolling 0.2 m/cycle, so by half of the moment
    feel(agent, PARAMS, sense(agent, 0.08, 0.0, head=-15.0, turn=1, neck=1), True)
    assert agent["body"][0] == pytest.approx(30.0)
    assert agent["neck"][0] == pytest.approx(15.0)


@pytest.mark.parametrize(("counts", "age"), [({}, 1), ({"turn": 1}, 3), ({"dash": 1}, 1)])
def test_commands_that_were_not_executed_are_not_predicted(counts, age):
    agent = player()
    sent(agent, TURN, 60.0)
    agent["now"][0] += age - 1
    feel(agent, PARAMS, sense(agent, **counts), True)
    assert agent["body"][0] == 0.0


def test_the_ball_rolls_and_stops_at_an_opponent():
    agent = player((-9.0, 0.0))
    ball(agent, (0.0, 0.0), (1.0, 0.5))
    feel(agent, PARAMS, sense(agent), True)
    assert tuple(agent["ball_pos"][0]) == pytest.approx((1.0, 0.5))
    assert tuple(agent["ball_vel"][0]) == pytest.approx((0.94, 0.47))
    know(agent, OPPONENTS, (2.0, 1.5))
    feel(agent, PARAMS, sense(agent), True)
    assert tuple(agent["ball_vel"][0]) == (0.0, 0.0)


def test_a_confirmed_kick_moves_the_ball_as_the_server_does():
    agent = player(body=30.0)
    ball(agent, (0.5, 0.2), (0.1, 0.0))
    sent(agent, KICK, 60.0, 45.0)
    feel(agent, PARAMS, sense(agent, kick=1), True)
    angle = abs(math.degrees(math.atan2(0.2, 0.5)) - 30.0) / 180.0
    gap = (math.hypot(0.5, 0.2) - 0.385) / 0.7
    push = 60.0 * 0.027 * (1.0 - 0.25 * angle - 0.25 * gap)
    vx = 0.1 + push * math.cos(math.radians(75.0))
    vy = push * math.sin(math.radians(75.0))
    assert tuple(agent["ball_pos"][0]) == pytest.approx((0.5 + vx, 0.2 + vy))
    assert tuple(agent["ball_vel"][0]) == pytest.approx((0.94 * vx, 0.94 * vy))
    assert agent["kicked"][0]
    feel(agent, PARAMS, sense(agent, kick=1), True)
    assert not agent["kicked"][0]


def test_a_kick_of_a_ball_out_of_reach_has_no_effect_on_it():
    agent = player()
    ball(agent, (2.0, 0.0))
    sent(agent, KICK, 60.0, 45.0)
    feel(agent, PARAMS, sense(agent, kick=1), True)
    assert tuple(agent["ball_pos"][0]) == (2.0, 0.0)


def test_running_into_the_ball_is_noticed_by_the_lost_speed():
    agent = player(vel=(0.4, 0.0))
    ball(agent, (1.2, 0.0))
    sent(agent, DASH, 100.0)
    feel(agent, PARAMS, sense(agent, 0.0, dash=1), True)
    assert agent["collided"][0]
    assert tuple(agent["pos"][0]) == pytest.approx((1.0, 0.0))
    assert tuple(agent["vel"][0]) == (0.0, 0.0)
    assert tuple(agent["ball_pos"][0]) == pytest.approx((1.2, 0.0)), "0.2 m in front"
    assert not agent["withheld"][0]
    feel(agent, PARAMS, sense(agent, 0.0, dash=1), True)
    # still touching it, with nothing sensed: a collision again; then the ball is away
    ball(agent, (5.0, 0.0))
    feel(agent, PARAMS, sense(agent, 0.0, dash=1), True)
    assert not agent["collided"][0]


def test_a_collision_that_swallowed_the_command_withholds_the_next():
    agent = player(vel=(0.4, 0.0))
    ball(agent, (0.6, 0.0))
    sent(agent, KICK, 50.0)
    feel(agent, PARAMS, sense(agent, 0.0), True)
    assert agent["collided"][0]
    assert agent["withheld"][0]


def test_a_collision_with_a_player_leaves_the_ball_alone():
    agent = player(vel=(0.4, 0.0))
    know(agent, 1, (0.5, 0.0))
    ball(agent, (0.3, 0.6), (0.2, 0.0))
    feel(agent, PARAMS, sense(agent, 0.0), True)
    assert agent["collided"][0]
    assert tuple(agent["ball_pos"][0]) == pytest.approx((0.5, 0.6))


def test_teammates_roll_except_number_one():
    agent = player((-9.0, -9.0), unum=3)
    for slot in (0, 1):
        know(agent, slot, (3.0, slot), (0.3, -0.1))
    feel(agent, PARAMS, sense(agent), True)
    assert tuple(agent["player_pos"][0, 0]) == (3.0, 0.0)
    assert tuple(agent["player_pos"][0, 1]) == pytest.approx((3.3, 0.9))
    assert tuple(agent["player_vel"][0, 1]) == pytest.approx((0.12, -0.04))
    assert agent["player_time"][0, 0] == agent["player_time"][0, 1] == NOW + 1


@pytest.mark.parametrize(("ball_vx", "drift"), [(0.0, -0.25), (0.5, 0.25), (1.5, 0.5), (-1.5, -0.5)])
def test_the_fastest_opponent_chases_the_ball_and_others_drift(ball_vx, drift):
    agent = player((-9.0, -9.0))
    ball(agent, (0.0, 0.0), (ball_vx, 0.0))
    know(agent, OPPONENTS, (3.0, 4.0), body=-120.0)
    far = 9.0 if ball_vx < 0.0 else -9.0
    know(agent, OPPONENTS + 1, (far, 9.0))
    feel(agent, PARAMS, sense(agent), True)
    bx = agent["ball_pos"][0, 0]
    away = math.hypot(3.0 - bx, 4.0)
    assert tuple(agent["player_pos"][0, OPPONENTS]) == pytest.approx(
        (3.0 - 0.3 * (3.0 - bx) / away, 4.0 - 0.3 * 4.0 / away)
    )
    assert tuple(agent["player_pos"][0, OPPONENTS + 1]) == pytest.approx((far + drift, 9.0))


def test_others_stay_when_the_next_see_shows_them():
    agent = player()
    ball(agent, (0.0, 5.0))
    know(agent, OPPONENTS, (3.0, 4.0))
    feel(agent, PARAMS, sense(agent), False)
    assert tuple(agent["player_pos"][0, OPPONENTS]) == (3.0, 4.0)
