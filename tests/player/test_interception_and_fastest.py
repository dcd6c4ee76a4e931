"""The searches that skip what cannot matter, against the same searches without skipping."""

from __future__ import annotations

import math

import numpy as np
import pytest
from player.beliefs import NOW, PARAMS, ball, know, player, scattered

from rcss_hat.player import fastest, interception, motion
from rcss_hat.player.objects import is_known
from rcss_hat.player.records import NOBODY, OPPONENTS
from rcss_hat.protocol.records import DASH, LEFT, RIGHT, TURN

KICK_DIST, TOP = 1.085, 1.05


def miss(agent, x, y, cycles):
    forward, side = motion.to_body(agent, x - agent["pos"][0, 0], y - agent["pos"][0, 1])
    v_forward, v_side = motion.to_body(agent, *agent["vel"][0])
    return motion.miss_after(agent, PARAMS, forward, side, v_forward, v_side, cycles)


def choose_cycle_plainly(agent):
    """Reference 6.7: all points, one after the other."""
    known_aim = agent["now"][0] - agent["aim_time"][0] <= 2
    aim = agent["aim"][0]
    first = best = 100
    old, nearest, smallest = None, 100.0, 10.0
    before = None
    for t in range(31):
        if t > first + 20:
            break
        point = np.array(motion.ball_after(agent, PARAMS, t))
        velocity = agent["ball_vel"][0] if before is None else point - before
        before = point
        if math.dist(motion.roll_out(agent, min(t, 4)), point) / TOP > t + KICK_DIST:
            continue
        off = miss(agent, *point, t)
        if off >= KICK_DIST:
            continue
        if first == 100:
            first = best = t
        gap = math.dist(point, aim) if known_aim else 1000.0
        if gap < min(1.0, nearest) and off < 0.7 * KICK_DIST and np.linalg.norm(velocity) > 0.6:
            old, smallest, nearest = t, off, gap
        elif off < smallest and smallest > 0.5 * KICK_DIST and (t <= best + 3 or (old is not None and t <= old + 3)):
            best, smallest = t, off
            if old is not None and old == best - 1:
                old = best
    return old if old is not None and best <= old + 2 else first


def test_interception_without_skipping_chooses_the_same_cycle():
    rng = np.random.default_rng(5)
    outcomes, sticky = set(), 0
    for trial in range(400):
        agent = scattered(rng, LEFT if trial % 2 else RIGHT)
        if trial % 3:
            t = int(rng.integers(1, 15))
            agent["aim"][0] = np.array(motion.ball_after(agent, PARAMS, t)) + rng.normal(0.0, 0.3, 2)
            agent["aim_time"][0] = NOW - 1
        expected = choose_cycle_plainly(agent)
        assert interception._choose_cycle(agent, PARAMS) == expected
        agent["aim_time"][0] = -1000
        sticky += expected != choose_cycle_plainly(agent)
        outcomes.add(expected)
    assert len(outcomes) > 10
    assert sticky > 5, "the remembered point must matter in some of the trials"


def known(agent, first, end):
    return [o for o in range(end - 1, first - 1, -1) if is_known(agent, o)]


def quickest(agent, slots, point, cycles):
    best, fewest = NOBODY, 100
    for o in slots:
        if math.dist(agent["player_pos"][0, o], point) < TOP * (cycles + 1):
            n = fastest.cycles_to_point(agent, PARAMS, o, *point)
            if n < fewest:
                best, fewest = o, n
    return best, fewest


def fastest_plainly(agent):
    """Reference 5.5: fastest team mate and opponent."""
    own, others = known(agent, 0, 11), known(agent, OPPONENTS, 22)
    teammate = opponent = None
    for t in range(31):
        point = motion.ball_after(agent, PARAMS, t)
        mate, n_mate = quickest(agent, own, point, t)
        foe, n_foe = quickest(agent, others, point, t)
        if teammate is None and (n_mate <= t or t == 30):
            teammate = mate
        if opponent is None and (n_foe <= t or t == 30):
            opponent = foe
            if teammate is None:
                teammate, _ = quickest(agent, own, point, 1000)
    return teammate, opponent


@pytest.mark.parametrize("side", [LEFT, RIGHT])
def test_fastest_without_skipping_is_the_same(side):
    rng = np.random.default_rng(6)
    found = set()
    for _ in range(250):
        agent = scattered(rng, side)
        teammate, opponent = fastest_plainly(agent)
        assert fastest.fastest_teammate(agent, PARAMS) == teammate
        assert fastest.fastest_opponent(agent, PARAMS) == opponent
        found.update((teammate, opponent))
    assert len(found) >= 4


def cycles_to_ball_plainly(agent, slot):
    if np.linalg.norm(agent["ball_vel"][0]) < 0.01:
        return fastest.cycles_to_point(agent, PARAMS, slot, *agent["ball_pos"][0])
    t, needed = 0, 100
    while t <= needed and t < 30:
        t += 1
        point = motion.ball_after(agent, PARAMS, t)
        if math.dist(agent["player_pos"][0, slot], point) < TOP * (t + 1):
            needed = fastest.cycles_to_point(agent, PARAMS, slot, *point)
    return needed


def test_cycles_to_ball_without_skipping_are_the_same():
    rng = np.random.default_rng(7)
    for _ in range(250):
        agent = scattered(rng)
        assert fastest.cycles_to_ball(agent, PARAMS, 1) == cycles_to_ball_plainly(agent, 1)
    assert fastest.cycles_to_ball(agent, PARAMS, NOBODY) == 101


def cycles_for_distance_plainly(distance, speed):
    cycles = 0
    while distance > KICK_DIST:
        speed = min(speed + 0.6, TOP)
        distance -= speed
        speed *= 0.4
        cycles += 1
    return cycles


def test_cycles_for_a_distance_are_counted_dash_by_dash():
    agent = player()
    for distance in np.arange(0.5, 35.0, 0.37):
        for speed in (-0.2, 0.0, 0.3, 0.42):
            assert fastest.cycles_for_distance(agent, PARAMS, distance, speed) == cycles_for_distance_plainly(
                distance, speed
            )


def test_cycles_of_players_who_reach_the_speed_limit():
    params = PARAMS.copy()
    params["player_speed_max"][0] = 0.8
    # 0.6, then 0.8 m each: 5 m less the reach take 6 cycles
    assert fastest.cycles_for_distance(player(), params, 5.0, 0.0) == 6


def test_players_are_credited_the_time_since_they_were_seen():
    agent = player()
    know(agent, OPPONENTS, (5.0, 0.0), body=180.0, age=2)
    know(agent, OPPONENTS + 1, (5.0, 0.0), body=180.0, age=0)
    gain = [fastest.cycles_to_point(agent, PARAMS, OPPONENTS + k, -3.0, 0.0) for k in (0, 1)]
    assert gain[1] - gain[0] == 2
    assert fastest.cycles_to_point(agent, PARAMS, OPPONENTS, 5.5, 0.0) == 0


def test_the_fastest_is_asked_once_per_news():
    agent = player((0.0, 0.0))
    know(agent, 1, (5.0, 0.0))
    ball(agent, (1.0, 0.0))
    assert fastest.current_fastest_teammate(agent, PARAMS) == 0
    ball(agent, (5.5, 0.0))
    assert fastest.current_fastest_teammate(agent, PARAMS) == 0
    agent["see_time"][0] += 1
    assert fastest.current_fastest_teammate(agent, PARAMS) == 1


def test_a_ball_that_comes_is_awaited_facing_x():
    agent = player((0.0, 0.0), body=90.0)
    ball(agent, (6.0, 0.0), (-1.2, 0.0))
    kind, moment = interception.intercept(agent, PARAMS)
    assert (kind, moment) == (TURN, pytest.approx(-90.0))


def test_a_ball_lying_ahead_is_run_to():
    agent = player((0.0, 0.0), body=0.0)
    ball(agent, (6.0, 0.2))
    assert interception.intercept(agent, PARAMS) == (DASH, 100.0)
    assert tuple(agent["aim"][0]) == pytest.approx((6.0, 0.2))


def test_a_close_ball_is_taken_with_one_dash_when_an_opponent_is_near():
    agent = player((0.0, 0.0), body=0.0)
    ball(agent, (1.5, 0.0))
    know(agent, OPPONENTS, (2.5, 0.0))
    kind, power = interception.meet_close_ball(agent, PARAMS)
    # the far crossing of the circle of 0.502 m would need more than full power, and ends within reach
    assert (kind, power) == (DASH, 100.0)
    x, y, _, _, _ = motion.own_state_after(agent, PARAMS, kind, power)
    assert math.dist((x, y), (1.5, 0.0)) < 0.95 * KICK_DIST


def test_close_means_within_reach_of_three_cycles():
    agent = player((0.0, 0.0))
    ball(agent, (10.2, 0.0))
    assert interception.meet_close_ball(agent, PARAMS)[0] == 0
