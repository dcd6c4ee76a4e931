"""State variables and fixed policies."""

from __future__ import annotations

import csv
import gzip
import math
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from player.beliefs import NOW, ball, know, player

from rcss_hat.keepaway.policies import hand, hold, random_action
from rcss_hat.keepaway.state import n_state_variables, state_names, state_ranges, state_variables
from rcss_hat.numeric import rng
from rcss_hat.player.records import OPPONENTS

DECISIONS = Path(__file__).parents[1] / "data" / "hat" / "handcoded-decisions.csv.gz"


def situation(keepers, takers, ball_at, unum=1):
    agent = player(keepers[unum - 1], unum=unum, n=len(keepers), m=len(takers))
    for i, pos in enumerate(keepers):
        know(agent, i, pos)
    for j, pos in enumerate(takers):
        know(agent, OPPONENTS + j, pos)
    ball(agent, ball_at)
    return agent


def angle(at, a, b):
    u, v = np.subtract(a, at), np.subtract(b, at)
    return math.degrees(math.acos(np.clip(u @ v / np.linalg.norm(u) / np.linalg.norm(v), -1.0, 1.0)))


def test_hand_made_state_of_3v2():
    k1, k2, k3, t1, t2 = (3.0, 4.0), (0.0, 4.0), (3.0, -8.0), (3.0, 2.0), (-3.0, 4.0)
    agent = situation([k3, k1, k2], [t2, t1], (3.1, 4.0), unum=2)
    state = np.zeros(13)
    assert state_variables(agent, state)
    expected = [5, 3, 12, 2, 6, 4, math.hypot(3, 8), math.hypot(3, 2), 5]
    expected += [3.0, 10.0, angle(k1, k2, t2), angle(k1, k3, t1)]
    assert state == pytest.approx(expected)
    assert state[11] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("n", "m", "count"), [(3, 2, 13), (4, 3, 19), (5, 4, 25)])
def test_any_number_of_players(n, m, count):
    draws = np.random.default_rng(n)
    keepers, takers = (
        [tuple(p) for p in draws.uniform(-15, 15, (n, 2))],
        [tuple(p) for p in draws.uniform(-15, 15, (m, 2))],
    )
    agent = situation(keepers, takers, keepers[n - 1], unum=2)
    state = np.full(n_state_variables(n, m), np.nan)
    assert len(state) == count == len(state_names(n, m)) == len(state_ranges(n, m))
    assert state_variables(agent, state)
    holder = keepers[n - 1]
    others = sorted(keepers[: n - 1], key=lambda p: math.dist(p, holder))
    near = sorted(takers, key=lambda p: math.dist(p, holder))
    expected = [math.hypot(*holder)]
    expected += [math.dist(p, holder) for p in (*others, *near)]
    expected += [math.hypot(*p) for p in (*others, *near)]
    expected += [min(math.dist(k, t) for t in takers) for k in others]
    expected += [min(angle(holder, k, t) for t in takers) for k in others]
    assert state == pytest.approx(expected)


def test_names_and_ranges_follow_the_order():
    assert state_names(3, 2) == [
        "dist(K1,C)", "dist(K1,K2)", "dist(K1,K3)", "dist(K1,T1)", "dist(K1,T2)", "dist(K2,C)", "dist(K3,C)",
        "dist(T1,C)", "dist(T2,C)", "min_dist(K2,T)", "min_dist(K3,T)", "min_ang(K2,K1,T)", "min_ang(K3,K1,T)",
    ]  # fmt: skip
    far = math.hypot(25.0, 25.0)
    assert state_ranges(3, 2) == pytest.approx([far / 2, *[far] * 4, *[far / 2] * 6, 180.0, 180.0])


@pytest.mark.parametrize("unknown", [1, 2, OPPONENTS, OPPONENTS + 1])
def test_the_state_is_undefined_when_anybody_is_unknown(unknown):
    agent = situation([(0.0, 0.0), (5.0, 5.0), (-5.0, 5.0)], [(3.0, 0.0), (4.0, 0.0)], (0.5, 0.0))
    state = np.zeros(13)
    agent["player_seen"][0, unknown] = NOW - 12
    assert state_variables(agent, state)
    agent["player_seen"][0, unknown] = NOW - 13
    assert not state_variables(agent, state)


def recorded():
    with gzip.open(DECISIONS, "rt", newline="") as file:
        for row in csv.DictReader(file):
            yield np.array([float(row[f"s{i}"]) for i in range(13)]), int(row["action"])


def test_the_hand_coded_rule_agrees_with_the_original_players():
    rows = list(recorded())
    assert len(rows) > 800
    for state, action in rows:
        if abs(state[3] - 5.0) > 5e-5:  # printed 5.0000 may be a hair more
            assert hand(state, 3, 2) == action
        assert state[1] <= state[2]
        assert state[3] <= state[4]
        assert 0.0 <= state[11:].min() <= state[11:].max() <= 180.0


def test_the_hand_coded_rule_in_larger_games_and_on_ties():
    state = np.zeros(19)
    state[4] = 5.0
    state[13:16], state[16:19] = (5.0, 10.0, 2.0), (70.0, 50.0, 82.0)
    assert hand(state, 4, 3) == 0, "holding wins ties"
    state[17] = 50.1
    assert hand(state, 4, 3) == 2
    state[4] = 5.001
    assert hand(state, 4, 3) == 0


def test_random_actions_are_uniform_and_hold_holds():
    stream = rng.stream(1, rng.POLICY)
    counts = Counter(random_action(stream, 3) for _ in range(6000))
    assert sorted(counts) == [0, 1, 2]
    assert max(abs(count - 2000) for count in counts.values()) < 150
    assert hold() == 0
