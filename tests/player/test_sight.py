"""What players believe after a see message."""

from __future__ import annotations

import math

import pytest
from player.beliefs import NOW, PARAMS, Sight, ball, know, parameters, player

from rcss_hat.player.objects import ball_is_known, is_known
from rcss_hat.player.records import NEVER, OPPONENTS
from rcss_hat.player.sight import shows_everyone, watch
from rcss_hat.protocol.records import (
    CLOSE_BALL,
    CLOSE_PLAYER,
    LEFT,
    OTHER_TEAM,
    OWN_TEAM,
    RIGHT,
    UNKNOWN_TEAM,
)

POSE = (2.0, 1.0, 30.0)
LEFT_BEHIND = (9.0, -8.0)


def looking(agent, time=NOW):
    agent["now"][0] = time
    return Sight(time).landmarks(POSE, agent["wanted"][0])


def observer(**more):
    return player(POSE[:2], POSE[2], **more)


def at(agent, distance, direction):
    """Where something is that is seen at a distance and direction, from the believed pose."""
    way = math.radians(agent["neck"][0] + direction)
    return agent["pos"][0, 0] + distance * math.cos(way), agent["pos"][0, 1] + distance * math.sin(way)


def test_a_numbered_player_is_taken_over():
    agent = observer()
    agent["speed"][0], agent["speed_direction"][0] = 0.2, 90.0
    sight = looking(agent).player(
        OTHER_TEAM, 2, 10.0, 40.0, distance_change=0.5, direction_change=-1.2, body=170.0, head=100.0
    )
    watch(agent, PARAMS, sight.line(POSE).see)
    o = OPPONENTS + 1
    assert tuple(agent["player_pos"][0, o]) == pytest.approx(at(agent, 10.0, 40.0))
    way = math.radians(agent["neck"][0] + 40.0)
    around = math.radians(-1.2) * 10.0
    own = agent["vel"][0]
    assert math.hypot(*own) == pytest.approx(0.2)
    assert tuple(agent["player_vel"][0, o]) == pytest.approx(
        (
            own[0] + 0.5 * math.cos(way) - around * math.sin(way),
            own[1] + 0.5 * math.sin(way) + around * math.cos(way),
        )
    )
    assert (agent["player_body"][0, o] - agent["neck"][0]) % 360.0 == pytest.approx(170.0)
    assert agent["player_seen"][0, o] == agent["player_change"][0, o] == NOW
    assert is_known(agent, o)
    assert not is_known(agent, OPPONENTS)


def test_impossible_speeds_are_cut():
    agent = observer()
    watch(agent, PARAMS, looking(agent).player(OTHER_TEAM, 1, 10.0, 0.0, distance_change=5.0).line(POSE).see)
    assert math.hypot(*agent["player_vel"][0, OPPONENTS]) == pytest.approx(1.05)
    watch(agent, PARAMS, looking(agent).ball(10.0, 90.0, distance_change=8.0).line(POSE).see)
    assert math.hypot(*agent["ball_vel"][0]) == pytest.approx(3.0)


def test_ball_velocity_is_averaged_with_the_prediction_when_they_agree():
    agent = observer()
    watch(agent, PARAMS, looking(agent).ball(10.0, 0.0, distance_change=1.0).line(POSE).see)
    seen = agent["ball_vel"][0].copy()
    for predicted, expected in ((1.05 * seen, 1.025 * seen), (1.4 * seen, seen)):
        agent["ball_vel"][0] = predicted
        watch(agent, PARAMS, looking(agent).ball(10.0, 0.0, distance_change=1.0).line(POSE).see)
        assert tuple(agent["ball_vel"][0]) == pytest.approx(tuple(expected), abs=1e-4)


def test_a_ball_at_an_opponents_feet_lies_still():
    agent = observer()
    sight = looking(agent).ball(10.0, 0.0, distance_change=-1.0)
    watch(agent, PARAMS, sight.player(OTHER_TEAM, 1, 10.6, 1.0).line(POSE).see)
    assert tuple(agent["ball_vel"][0]) == (0.0, 0.0)
    near = looking(agent, NOW + 1).ball(1.0, 0.0, distance_change=-0.1).player(OTHER_TEAM, 1, 1.6, 1.0)
    watch(agent, PARAMS, near.line(POSE).see)
    assert math.hypot(*agent["ball_vel"][0]) == pytest.approx(0.1), "not when the player itself can kick it"


def test_a_close_ball_seen_without_velocity_gets_it_from_where_it_was():
    agent = observer(params=parameters(visible_angle=90.0))
    watch(agent, PARAMS, looking(agent).ball(2.0, 0.0).line(POSE).see)
    first = agent["ball_pos"][0].copy()
    watch(agent, PARAMS, looking(agent, NOW + 1).add(CLOSE_BALL, 2.5, 0.0).line(POSE).see)
    moved = agent["ball_pos"][0] - first - agent["shift"][0]
    assert tuple(agent["ball_vel"][0]) == pytest.approx(tuple(0.94 * moved))
    second = agent["ball_pos"][0].copy()
    watch(agent, PARAMS, looking(agent, NOW + 3).add(CLOSE_BALL, 2.9, 0.0).line(POSE).see)
    moved = agent["ball_pos"][0] - second - agent["shift"][0]
    assert tuple(agent["ball_vel"][0]) == pytest.approx(tuple(0.94 * 0.94 * moved / 1.94))


def test_everyone_is_shown_only_when_all_known_players_are():
    agent = observer()
    know(agent, 1, (0.0, 0.0))
    know(agent, OPPONENTS, (3.0, 0.0), age=12)
    know(agent, OPPONENTS + 1, (3.0, 0.0), age=13)
    sight = looking(agent).player(OWN_TEAM, 2, 4.0, 0.0)
    assert not shows_everyone(agent, sight.see)
    assert shows_everyone(agent, sight.player(OTHER_TEAM, 1, 4.0, 0.0).see)


# -- strangers --------------------------------------------------------------------------------------------------------
def test_a_stranger_between_two_numbers_is_the_one_between():
    agent = observer(unum=2)
    sight = looking(agent).player(OWN_TEAM, 1, 5.0, 0.0).player(OWN_TEAM, 0, 25.0, 50.0)
    watch(agent, PARAMS, sight.player(OWN_TEAM, 4, 5.0, 90.0).line(POSE).see)
    assert tuple(agent["player_pos"][0, 2]) == pytest.approx(at(agent, 25.0, 50.0))
    assert agent["player_known"][0, 2]
    assert agent["player_seen"][0, 2] == NOW


def test_a_stranger_near_a_known_unseen_player_is_taken_for_it():
    agent = observer()
    know(agent, OPPONENTS + 1, at(agent, 24.0, 10.0), age=3)
    watch(agent, PARAMS, looking(agent).player(OTHER_TEAM, 0, 25.0, 10.0).line(POSE).see)
    assert tuple(agent["player_pos"][0, OPPONENTS + 1]) == pytest.approx(at(agent, 25.0, 10.0))
    assert tuple(agent["player_vel"][0, OPPONENTS + 1]) == (0.0, 0.0)
    assert not agent["player_known"][0, OPPONENTS + 1]
    assert not is_known(agent, OPPONENTS)


def test_a_stranger_far_from_everybody_takes_the_first_free_place():
    agent = observer()
    know(agent, OPPONENTS, at(agent, 25.0, 100.0), age=1)
    watch(agent, PARAMS, looking(agent).player(OTHER_TEAM, 0, 25.0, 10.0).line(POSE).see)
    assert tuple(agent["player_pos"][0, OPPONENTS + 1]) == pytest.approx(at(agent, 25.0, 10.0))
    # ... and gives it back when the player is seen with another number near by
    sight = looking(agent, NOW + 1).player(OTHER_TEAM, 3, 25.0, 10.0)
    agent["player_seen"][0, OPPONENTS + 1] = NOW - 1
    watch(agent, PARAMS, sight.line(POSE).see)
    assert agent["player_seen"][0, OPPONENTS + 1] == NEVER
    assert is_known(agent, OPPONENTS + 2)


def test_more_strangers_than_players_are_kept_apart():
    agent = observer()
    for o in (OPPONENTS, OPPONENTS + 1):
        know(agent, o, at(agent, 5.0, 100.0), age=1)
    watch(agent, PARAMS, looking(agent).player(OTHER_TEAM, 0, 25.0, 10.0).line(POSE).see)
    assert agent["top_other"][0] == OPPONENTS + 3


@pytest.mark.parametrize(("distance", "taken"), [(2.7, True), (30.0, False)])
def test_someone_without_team_counts_as_opponent_when_close(distance, taken):
    agent = observer()
    agent["now"][0] = 5000
    code = looking(agent, 5000).add(CLOSE_PLAYER, distance, 170.0, team=UNKNOWN_TEAM)
    watch(agent, PARAMS, code.line(POSE).see)
    assert is_known(agent, OPPONENTS) == taken


@pytest.mark.parametrize("side", [LEFT, RIGHT])
def test_the_first_strangers_of_a_side_get_the_lowest_numbers(side):
    agent = observer(side=side, unum=1, n=3, m=2)
    first, second = (OWN_TEAM, OTHER_TEAM) if side == LEFT else (OTHER_TEAM, OWN_TEAM)
    pose = POSE if side == LEFT else (-POSE[0], -POSE[1], POSE[2] + 180.0)
    sight = Sight().landmarks(pose, agent["wanted"][0])
    sight.player(first, 0, 22.0, 0.0).player(first, 3, 21.0, 20.0).player(second, 0, 23.0, 40.0)
    watch(agent, PARAMS, sight.line(pose).see)
    own = [o for o in range(11) if o != 0 and is_known(agent, o)]
    other = [o - OPPONENTS for o in range(OPPONENTS, 22) if is_known(agent, o)]
    assert (own, other) == (([1, 2], [0]) if side == LEFT else ([1], [0, 2]))


# -- ghosts -----------------------------------------------------------------------------------------------------------
def test_a_ball_not_where_it_should_be_seen_is_lost():
    agent = observer()
    ball(agent, at(agent, 8.0, 20.0), age=1)
    watch(agent, PARAMS, looking(agent).line(POSE).see)
    assert not ball_is_known(agent)
    ball(agent, at(agent, 8.0, 60.0), age=1)
    watch(agent, PARAMS, looking(agent).line(POSE).see)
    assert ball_is_known(agent), "outside of the sure view it may still be there"


def test_a_ball_may_be_hidden_by_an_unseen_opponent():
    agent = observer()
    ball(agent, at(agent, 4.0, 10.0), age=1)
    know(agent, OPPONENTS, at(agent, 4.2, 32.0), age=2)
    watch(agent, PARAMS, looking(agent).line(POSE).see)
    assert ball_is_known(agent)
    # the ball is put where that opponent was believed to be
    assert tuple(agent["ball_pos"][0]) == pytest.approx(at(agent, 4.2, 32.0), abs=0.15)


def test_teammates_in_sure_view_are_forgotten_and_opponents_step_aside():
    agent = observer()
    know(agent, 1, at(agent, 8.0, 5.0), age=1)
    know(agent, 2, at(agent, 8.0, 120.0), age=1)
    know(agent, OPPONENTS, at(agent, 8.0, 5.0), age=1)
    know(agent, OPPONENTS + 1, at(agent, 3.5, 25.0), age=4)
    watch(agent, PARAMS, looking(agent).line(POSE).see)
    assert agent["player_seen"][0, 1] == NEVER
    assert is_known(agent, 2)
    assert agent["player_seen"][0, OPPONENTS] == NEVER
    assert tuple(agent["player_pos"][0, OPPONENTS + 1]) == pytest.approx(at(agent, 3.5, 45.0), abs=0.1)


def test_an_unseen_opponent_is_never_believed_closer_than_one_can_feel():
    agent = observer()
    know(agent, OPPONENTS, at(agent, 1.0, 150.0), age=1)
    watch(agent, PARAMS, looking(agent).line(POSE).see)
    gap = agent["player_pos"][0, OPPONENTS] - agent["pos"][0]
    assert math.hypot(*gap) == pytest.approx(3.0)
