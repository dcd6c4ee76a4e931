"""Kicks."""

from __future__ import annotations

import math

import numpy as np
import pytest
from player.beliefs import PARAMS, ball, know, parameters, player

from rcss_hat.player import kicking
from rcss_hat.player.records import OPPONENTS


def after(agent, power, direction):
    x, y, vx, vy = kicking.ball_after_kick(agent, PARAMS, power, direction)
    return np.array([x, y]), np.array([vx, vy]) / 0.94


@pytest.mark.parametrize(("direction", "share"), [(0.0, 1.0), (90.0, 0.875), (180.0, 0.75), (-90.0, 0.875)])
def test_kick_rate_falls_with_angle_and_distance(direction, share):
    for gap, far in ((0.0, 0.0), (0.35, 0.125), (0.7, 0.25)):
        agent = player((1.0, 2.0), body=40.0)
        way = math.radians(40.0 + direction)
        ball(agent, (1.0 + (0.385 + gap) * math.cos(way), 2.0 + (0.385 + gap) * math.sin(way)))
        assert kicking.kick_rate(agent, PARAMS) == pytest.approx(0.027 * (share - far))


def test_kicks_are_predicted_with_whole_numbers_and_limited_speed():
    agent = player(body=10.0)
    ball(agent, (0.6, 0.0))
    whole, broken = after(agent, 50.0, 20.0), after(agent, 50.9, 20.9)
    assert np.allclose(whole, broken)
    ball(agent, (0.6, 0.0), (2.5, 0.0))
    assert np.linalg.norm(after(agent, 100.0, -10.0)[1]) == pytest.approx(3.0)


@pytest.mark.parametrize(("distance", "speed"), [(5.0, 1.54), (10.0, 1.85), (15.0, 2.09), (20.0, 2.52)])
def test_passes_leave_with_the_speed_that_lets_them_arrive_at_1_2(distance, speed):
    agent = player()
    ball(agent, (0.45, 0.0))
    power, direction = kicking.kick_to(agent, PARAMS, 0.45 + distance, 0.0, 1.2)
    assert (abs(direction), power * kicking.kick_rate(agent, PARAMS)) == pytest.approx((0.0, speed), abs=0.01)


def test_kick_to_takes_the_balls_motion_into_account():
    agent = player(body=90.0)
    ball(agent, (0.4, 0.3), (0.2, -0.3))
    power, direction = kicking.kick_to(agent, PARAMS, 5.4, 0.3, 1.2)
    _, velocity = after(agent, power, direction)
    assert velocity[0] == pytest.approx(1.54, abs=0.04)
    assert velocity[1] == pytest.approx(0.0, abs=0.04)


def test_a_pass_that_needs_too_much_power_is_prepared_first():
    agent = player(body=0.0)
    ball(agent, (-0.9, 0.0))  # behind: half of the rate
    power, direction = kicking.kick_to(agent, PARAMS, 14.0, 0.0, 1.2)
    place, _ = after(agent, power, direction)
    assert power <= 100.0
    # brought in front of the body, as far as one kick does it
    assert place[0] > 0.3
    know(agent, OPPONENTS, (-2.0, 0.0))
    assert kicking.kick_to(agent, PARAMS, 14.0, 0.0, 1.2) == (power, direction), "too weak even in a hurry"


def test_in_a_hurry_a_pass_is_kicked_a_little_too_weak():
    agent = player(body=0.0)
    way = math.radians(120.0)
    ball(agent, (0.8 * math.cos(way), 0.8 * math.sin(way)))
    rate = kicking.kick_rate(agent, PARAMS)
    assert 105.0 < 2.09 / rate < 130.0
    target = agent["ball_pos"][0] + np.array([15.0, 0.0])
    calm = kicking.kick_to(agent, PARAMS, *target, 1.2)
    know(agent, OPPONENTS, tuple(agent["ball_pos"][0] + np.array([1.0, 1.0])))
    hurried = kicking.kick_to(agent, PARAMS, *target, 1.2)
    assert hurried == (100.0, pytest.approx(0.0, abs=1e-9))
    assert calm != hurried


def test_the_ball_is_not_kicked_into_the_own_body():
    agent = player((2.0, 0.0), vel=(0.0, 0.0))
    ball(agent, (1.0, 0.0))
    power, direction = kicking.kick_to(agent, PARAMS, 3.2, 0.0, 0.6)
    place, _ = after(agent, power, direction)
    assert abs(place[0] - 2.0) >= 0.385 - 0.03


def test_out_of_range_targets_are_shot_at_or_prepared():
    slow = parameters(ball_speed_max=2.0)
    agent = player(params=slow)
    ball(agent, (0.4, 0.0), (0.1, 0.3))
    power, direction = kicking.kick_to(agent, slow, 30.0, 0.0, 1.2)
    assert power == 100.0
    assert direction < 0.0, "against the ball's sideways motion"
    ball(agent, (-0.4, 0.0))
    power, direction = kicking.kick_to(agent, slow, 30.0, 0.0, 1.2)
    x, _, _, _ = kicking.ball_after_kick(agent, slow, power, direction)
    assert x == pytest.approx(0.385 + 0.7 * 0.16, abs=0.02)


def test_kick_close_puts_the_ball_where_it_should_be():
    for body in (0.0, 70.0, -130.0):
        agent = player((3.0, -2.0), body=body, vel=(0.1, 0.1))
        ball(agent, (3.3, -1.6), (0.1, 0.0))
        power, direction = kicking.kick_close(agent, PARAMS, 30.0, 0.7)
        place, _ = after(agent, power, direction)
        way = math.radians(body + 30.0)
        wanted = np.array([3.1, -1.9]) + 0.875 * np.array([math.cos(way), math.sin(way)])
        assert np.linalg.norm(place - wanted) < 0.06


def test_kick_close_keeps_the_ball_on_the_pitch():
    agent = player((0.0, 33.7), body=90.0)
    ball(agent, (0.3, 33.4))
    place, _ = after(agent, *kicking.kick_close(agent, PARAMS, 0.0, 0.7))
    assert place[1] < 33.9


def test_a_fast_ball_is_stopped_before_it_is_placed():
    agent = player(body=0.0)
    ball(agent, (0.7, 0.0), (1.3, 0.0))
    frozen = kicking.freeze(agent, PARAMS)
    assert kicking.kick_close(agent, PARAMS, 180.0, 0.7) == frozen
    _, velocity = after(agent, *frozen)
    assert np.linalg.norm(velocity) < 0.1


def test_a_ball_too_fast_to_stop_is_steered_to_the_player():
    agent = player(body=0.0)
    ball(agent, (1.0, 0.0), (0.0, 2.6))
    power, direction = kicking.freeze(agent, PARAMS)
    assert power == 100.0
    _, velocity = after(agent, power, direction)
    assert np.linalg.norm(velocity) < 2.0
