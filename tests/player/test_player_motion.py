"""Predictions of motion, against the same predictions done in the plane with vectors and angles."""

from __future__ import annotations

import math

import numpy as np
import pytest
from player.beliefs import PARAMS, ball, player

from rcss_hat.player import geometry, motion
from rcss_hat.player.moving import move_to, search_ball, turn_neck_to
from rcss_hat.protocol.records import DASH, TURN

DECAY, RATE, TOP, INERTIA = 0.4, 0.006, 1.05, 5.0
KICK_DIST = 1.085


def unit(degrees: float) -> np.ndarray:
    return np.array([math.cos(math.radians(degrees)), math.sin(math.radians(degrees))])


def angle_between(start: float, end: float) -> float:
    return (end - start + 180.0) % 360.0 - 180.0


class Runner:
    """A player of the reference: position, velocity and body angle in the plane."""

    def __init__(self, pos, vel, body):
        self.pos, self.vel, self.body = np.array(pos, float), np.array(vel, float), float(body)

    def roll(self, cycles):
        return self.pos + self.vel * sum(DECAY**i for i in range(cycles))

    def step(self, kind, amount):
        if kind == TURN:
            self.body += amount / (1.0 + INERTIA * np.linalg.norm(self.vel))
        else:
            self.vel = self.vel + amount * RATE * unit(self.body)
        speed = np.linalg.norm(self.vel)
        if speed > TOP:
            self.vel = self.vel * TOP / speed
        self.pos = self.pos + self.vel
        self.vel = self.vel * DECAY

    def power(self, target, cycles):
        forward = float((target - self.pos) @ unit(self.body))
        speed = min(forward * (1.0 - DECAY) / (1.0 - DECAY**cycles), TOP)
        return min(max((speed - float(self.vel @ unit(self.body))) / RATE, -100.0), 100.0)

    def off_line(self, target, ahead, body):
        dx, dy = target - ahead
        return abs(dx * math.sin(math.radians(body)) - dy * math.cos(math.radians(body)))

    def plan(self, target, cycles, back=2.5):
        """Reference 6.3 (b), literally."""
        ahead = self.roll(min(cycles, 4))
        distance = np.linalg.norm(target - self.pos)
        limit = KICK_DIST * (3.0 if distance > 20.0 else 2.0 if distance > 10.0 else 0.9)
        far = np.linalg.norm(target - ahead)
        way = math.degrees(math.atan2(*(target - ahead)[::-1]))
        inertia = 1.0 + INERTIA * np.linalg.norm(self.vel)

        def must_turn(body):
            return self.off_line(target, ahead, body) > limit or (far > back and abs(angle_between(body, way)) > 90.0)

        if not must_turn(self.body):
            return DASH, self.power(target, max(cycles, 1))
        moment = float(np.clip(angle_between(self.body, way) * inertia, -180, 180))
        if must_turn(self.body + moment / inertia) and cycles < 4 and far < back:
            other = float(np.clip(angle_between(self.body, way + 180.0) * inertia, -180, 180))
            if self.off_line(target, ahead, self.body + other / inertia) < 0.9 * KICK_DIST:
                return TURN, other
        return TURN, moment


def runners(n, seed=1):
    rng = np.random.default_rng(seed)
    for _ in range(n):
        pos, vel, body = rng.uniform(-9, 9, 2), rng.uniform(-0.3, 0.3, 2), rng.uniform(-180, 180)
        target = pos + rng.uniform(0.3, 12.0) * unit(rng.uniform(-180, 180))
        yield Runner(pos, vel, body), player(tuple(pos), body, tuple(vel)), target, int(rng.integers(1, 12))


def test_planned_move_agrees_with_vectors():
    kinds = set()
    for runner, agent, target, cycles in runners(400):
        kind, amount = motion.planned_move(agent, PARAMS, *target, cycles, 2.5)
        expected, wanted = runner.plan(target, cycles)
        assert kind == expected
        assert amount == pytest.approx(wanted, abs=1e-6)
        kinds.add((kind, cycles < 4))
    assert len(kinds) == 4


def test_miss_after_agrees_with_moving_step_by_step():
    for runner, agent, target, cycles in runners(300, 2):
        for i in range(cycles):
            runner.step(*runner.plan(target, cycles - i))
        forward, side = motion.to_body(agent, *(target - agent["pos"][0]))
        v_forward, v_side = motion.to_body(agent, *agent["vel"][0])
        miss = motion.miss_after(agent, PARAMS, forward, side, v_forward, v_side, cycles)
        assert miss == pytest.approx(np.linalg.norm(target - runner.pos), abs=1e-9)


@pytest.mark.parametrize(("kind", "amount"), [(DASH, 80.0), (DASH, -50.0), (TURN, 90.0), (TURN, -180.0)])
def test_own_state_after_a_command(kind, amount):
    for runner, agent, _, _ in runners(20, 3):
        before = runner.body
        runner.step(kind, amount)
        x, y, vx, vy, turned = motion.own_state_after(agent, PARAMS, kind, amount)
        assert (x, y) == pytest.approx(runner.pos)
        assert (DECAY * vx, DECAY * vy) == pytest.approx(runner.vel)
        assert turned == pytest.approx(runner.body - before)


def test_own_speed_is_limited():
    agent = player(vel=(0.9, 0.0))
    x, _, vx, _, _ = motion.own_state_after(agent, PARAMS, DASH, 100.0)
    assert (x, vx) == pytest.approx((1.05, 1.05))


def test_dash_power_spreads_a_distance_over_cycles():
    agent = player()
    assert motion.dash_power(agent, PARAMS, 0.3, 0.0, 1) == pytest.approx(50.0)
    # 0.3 + 0.12 m in two cycles of rolling
    assert motion.dash_power(agent, PARAMS, 0.42, 0.0, 2) == pytest.approx(50.0)
    assert motion.dash_power(agent, PARAMS, 9.0, 0.0, 1) == 100.0
    assert motion.dash_power(agent, PARAMS, -9.0, 0.0, 0) == -100.0


def test_ball_after_is_the_geometric_series_beyond_the_table_too():
    agent = player()
    ball(agent, (1.0, 2.0), (2.0, -1.0))
    for cycles in (0, 1, 7, 103, 150):
        travelled = sum(0.94**i for i in range(cycles))
        assert motion.ball_after(agent, PARAMS, cycles) == pytest.approx((1.0 + 2.0 * travelled, 2.0 - travelled))


def test_facing_keeps_neck_and_body_apart():
    agent = player()
    agent["head"][0] = 30.0
    motion.face(agent, 200.0)
    assert agent["neck"][0] == pytest.approx(-160.0)
    assert agent["body"][0] == pytest.approx(170.0)
    assert (agent["body_cos"][0], agent["body_sin"][0]) == pytest.approx(tuple(unit(170.0)))


def test_move_to_dashes_turns_or_brakes():
    assert move_to(player(), PARAMS, 5.0, 0.1, 7.0, 0.0) == (DASH, 100.0)
    kind, moment = move_to(player(), PARAMS, 0.0, 5.0, 7.0, 0.0)
    assert (kind, moment) == (TURN, pytest.approx(90.0))
    # Backwards only when near and allowed.
    assert move_to(player(), PARAMS, -2.0, 0.0, 25.0, 3.0) == (DASH, -100.0)
    assert move_to(player(), PARAMS, -2.0, 0.0, 25.0, 0.0)[0] == TURN
    # At 0.4 m/cycle 180 degrees take three turns: 60, then 100, then the rest; so it brakes.
    kind, power = move_to(player(vel=(0.4, 0.0)), PARAMS, -6.0, 0.0, 7.0, 0.0)
    assert (kind, power) == (DASH, pytest.approx(-0.4 / RATE))


def test_search_turns_by_sixty_degrees_to_the_side_of_the_ball():
    agent = player(body=10.0)
    ball(agent, (0.0, 5.0), age=20)
    assert search_ball(agent, PARAMS) == (TURN, pytest.approx(60.0))
    agent["now"][0] += 1
    ball(agent, (0.0, -5.0), age=20)
    assert search_ball(agent, PARAMS) == (TURN, pytest.approx(60.0)), "goes on in the direction it began with"
    agent["now"][0] += 4
    assert search_ball(agent, PARAMS) == (TURN, pytest.approx(-60.0))


def test_neck_turns_to_the_point_as_seen_after_the_body_command():
    agent = player(body=20.0)
    agent["head"][0] = 20.0
    motion.face(agent, 40.0)
    assert turn_neck_to(agent, PARAMS, 0.0, 5.0, TURN, 30.0) == pytest.approx(90.0 - 50.0 - 20.0)
    assert turn_neck_to(agent, PARAMS, -5.0, 0.0, TURN, 0.0) == pytest.approx(90.0 - 20.0), "no farther than 90 degrees"


def test_in_cone_is_the_definition_with_feet_and_distances():
    rng = np.random.default_rng(4)
    inside = 0
    for _ in range(2000):
        apex, end, o = rng.uniform(-10, 10, (3, 2))
        axis = (end - apex) / np.linalg.norm(end - apex)
        foot = apex + ((o - apex) @ axis) * axis
        length = np.linalg.norm(end - apex)
        between = np.linalg.norm(foot - apex) <= length and np.linalg.norm(foot - end) <= length
        expected = (
            between
            and np.linalg.norm(o - foot) < 0.3 * np.linalg.norm(foot - apex)
            and np.linalg.norm(o - apex) < length
        )
        assert geometry.in_cone(*o, *apex, *end, 0.3) == expected
        inside += expected
    assert inside > 50
    assert not geometry.in_cone(1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.3), "a cone without length holds nobody"


def test_intervals_of_angles_go_round():
    assert geometry.in_interval(170.0, 160.0, -160.0)
    assert geometry.in_interval(-170.0, 160.0, 200.0)
    assert not geometry.in_interval(0.0, 160.0, -160.0)
    assert geometry.in_interval(0.0, -90.0, 90.0)


def test_sign_of_zero_is_minus():
    assert (geometry.sign(0.0), geometry.sign(1e-9), geometry.sign(-3.0)) == (-1.0, 1.0, -1.0)
