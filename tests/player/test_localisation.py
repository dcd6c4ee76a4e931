"""Own pose from landmarks, rounded as the server rounds them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from player.beliefs import NOW, Sight, parameters, player

from rcss_hat.player.localisation import FULL_VIEW_LANDMARKS, landmarks_wanted, locate
from rcss_hat.player.sight import watch
from rcss_hat.protocol.landmarks import LANDMARK_NAMES
from rcss_hat.protocol.records import LEFT, RIGHT

PARAMS = parameters()


def poses(n, seed, size=9.0):
    rng = np.random.default_rng(seed)
    for _ in range(n):
        yield (*rng.uniform(-size, size, 2), rng.uniform(-180.0, 180.0))


def errors(agent, pose):
    x, y, neck, c, s = locate(agent, agent_sees(agent, pose))
    assert (c, s) == pytest.approx((math.cos(math.radians(neck)), math.sin(math.radians(neck))), abs=1e-9)
    return math.dist((x, y), pose[:2]), (neck - pose[2] + 180.0) % 360.0 - 180.0


def agent_sees(agent, pose, half_view=180.0, lines=True):
    sight = Sight().landmarks(pose, agent["wanted"][0], half_view)
    return (sight.line(pose) if lines else sight).see


def test_pose_is_good_to_centimetres_and_a_tenth_of_a_degree():
    found = np.array([errors(player(pose[:2], pose[2]), pose) for pose in poses(200, 1)])
    assert np.sqrt((found[:, 0] ** 2).mean()) < 0.06
    assert np.sqrt((found[:, 1] ** 2).mean()) < 0.12
    assert found[:, 0].max() < 0.2


def test_pose_is_found_after_being_moved_across_the_field():
    for pose in poses(50, 2):
        agent = player((-pose[0], pose[1] - 15.0), pose[2] + 15.0)
        off, turned = errors(agent, pose)
        assert off < 0.2
        assert abs(turned) < 0.5


def test_a_view_of_ninety_degrees_is_enough():
    params = parameters(visible_angle=90.0)
    assert landmarks_wanted(params).sum() == len(LANDMARK_NAMES)
    for pose in poses(100, 3):
        agent = player((pose[0] + 0.3, pose[1] - 0.2), pose[2] + 5.0, params=params)
        x, y, neck, _, _ = locate(agent, agent_sees(agent, pose, half_view=45.0))
        assert math.dist((x, y), pose[:2]) < 0.5
        assert abs((neck - pose[2] + 180.0) % 360.0 - 180.0) < 0.8


def test_without_a_line_the_landmarks_alone_turn_the_player():
    for pose in poses(30, 4):
        agent = player(pose[:2], pose[2] + 17.0)
        x, y, neck, _, _ = locate(agent, agent_sees(agent, pose, lines=False))
        assert math.dist((x, y), pose[:2]) < 0.2
        assert abs((neck - pose[2] + 180.0) % 360.0 - 180.0) < 0.5


def test_one_landmark_corrects_along_its_direction():
    agent = player((1.0, 0.0), 0.0)
    see = Sight().add(LANDMARK_NAMES.index("f p r c"), 36.6, 0.0).add(65, 52.9, -90.0).see
    x, y, neck, _, _ = locate(agent, see)
    assert x == pytest.approx(-0.6, abs=0.2)
    assert (y, neck) == pytest.approx((0.0, 0.0), abs=0.2)


def test_with_nothing_in_view_the_pose_stays():
    agent = player((1.0, 2.0), 30.0)
    assert locate(agent, Sight().see)[:3] == pytest.approx((1.0, 2.0, 30.0))


def test_landmarks_that_are_not_wanted_change_nothing():
    assert landmarks_wanted(PARAMS).sum() == len(FULL_VIEW_LANDMARKS)
    pose = (3.0, -4.0, 77.0)
    agent = player(pose[:2], pose[2])
    everything = Sight()
    for code in range(len(LANDMARK_NAMES)):
        if agent["wanted"][0, code]:
            one = np.zeros_like(agent["wanted"][0])
            one[code] = 1
            everything.landmarks(pose, one)
        else:
            everything.add(code, 3.3, 12.0)
    assert locate(agent, everything.line(pose).see) == locate(agent, agent_sees(agent, pose))


def test_close_flags_without_name_are_passed_over():
    pose = (0.5, 0.0, 180.0)
    agent = player(pose[:2], pose[2])
    see = Sight().add(72, 0.5, 0.0)
    see.landmarks(pose, agent["wanted"][0]).line(pose)
    x, y, _, _, _ = locate(agent, see.see)
    assert math.dist((x, y), pose[:2]) < 0.2


@pytest.mark.parametrize("side", [LEFT, RIGHT])
def test_the_right_side_sees_the_field_rotated(side):
    pose = (4.0, -5.0, 30.0)
    agent = player(side=side)
    watch(agent, PARAMS, agent_sees(agent, pose))
    sign = 1.0 if side == LEFT else -1.0
    assert tuple(sign * agent["pos"][0]) == pytest.approx(pose[:2], abs=0.15)
    turned = 0.0 if side == LEFT else 180.0
    assert (agent["neck"][0] - pose[2] - turned + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=0.3)
    assert agent["player_seen"][0, agent["me"][0]] == NOW
