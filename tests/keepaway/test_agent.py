"""The three kernels of a player: perceive, decide, act."""

from __future__ import annotations

import math

import numpy as np
import pytest
from player.beliefs import NOW, PARAMS, Sight, ball, know, parameters, player

from rcss_hat.keepaway import agent as kernels
from rcss_hat.keepaway.agent import FIRST, FOLLOW_THROUGH, NO_DECISION, STEP, UNKNOWN
from rcss_hat.keepaway.getting_open import open_point
from rcss_hat.keepaway.holding import hold_ball, pass_ball
from rcss_hat.keepaway.marking import mark, most_open_opponent
from rcss_hat.player.objects import ball_is_known, is_known
from rcss_hat.player.records import NEVER, NOBODY, OPPONENTS
from rcss_hat.protocol.records import ACTION, DASH, HEARD, KICK, LEFT, RIGHT, SEE, SENSE_BODY, TURN, empty

STATE = np.zeros(13)


def holder(**more):
    """A keeper with the ball, everybody known, takers far."""
    agent = player((0.0, 0.0), **more)
    know(agent, 1, (8.0, 0.0))
    know(agent, 2, (-8.0, 3.0))
    know(agent, OPPONENTS, (0.0, 8.0))
    know(agent, OPPONENTS + 1, (1.0, 9.0))
    ball(agent, (0.6, 0.0))
    return agent


def decide(agent):
    return kernels.decide(agent, STATE)


def act(agent, status=NO_DECISION, choice=0):
    action = empty(ACTION)
    kernels.act(agent, PARAMS, status, choice, action)
    return action


def refresh(agent, cycles=1):
    """Some cycles later everything is as before."""
    agent["now"][0] += cycles
    for name in ("player_seen", "player_time", "player_change", "ball_seen", "ball_change", "see_time"):
        agent[name][0] = agent["now"][0]


def nothing_heard():
    record = empty(HEARD)
    record["time"][0] = -1
    return record


def sense(time):
    record = empty(SENSE_BODY)
    record["time"][0], record["effort"][0] = time, 1.0
    return record


def perceive(agent, time, see=None, started=False, heard=None):
    seen = empty(SEE) if see is None else see
    kernels.perceive(agent, PARAMS, sense(time), seen, see is not None, heard or nothing_heard(), started)


# -- decisions --------------------------------------------------------------------------------------------------------
def test_every_cycle_with_the_ball_is_a_decision():
    agent = holder()
    assert decide(agent).status == FIRST
    assert STATE[1:5] == pytest.approx([8.0, math.hypot(8, 3), 8.0, math.hypot(1, 9)])
    act(agent, FIRST, 0)
    refresh(agent)
    assert decide(agent)[:2] == (STEP, 1.0)
    act(agent, STEP, 0)
    refresh(agent, 7)
    assert decide(agent)[:2] == (STEP, 7.0)


def test_a_pass_is_followed_through_without_asking():
    agent = holder()
    act(agent, decide(agent).status, 2)
    refresh(agent)
    assert decide(agent).status == FOLLOW_THROUGH
    action = act(agent, FOLLOW_THROUGH, 0)
    assert action["kind"][0] == KICK
    assert abs(action["b"][0]) > 150, "still to the keeper behind"
    refresh(agent, 20)
    assert decide(agent)[:2] == (STEP, 20.0), "counted from the last kick of the pass"


def test_without_the_ball_there_is_no_decision():
    agent = holder()
    ball(agent, (3.0, 0.0))
    assert decide(agent).status == NO_DECISION
    ball(agent, (0.5, 0.0), age=11)
    assert decide(agent).status == NO_DECISION


def test_an_undefined_state_means_hold_and_no_credit():
    agent = holder()
    act(agent, decide(agent).status, 0)
    refresh(agent)
    agent["player_seen"][0, OPPONENTS] = NEVER
    assert decide(agent).status == UNKNOWN
    expected = hold_ball(agent, PARAMS, 0.7)
    action = act(agent, UNKNOWN, 2)
    assert (action["kind"][0], action["a"][0]) == (expected[0], math.trunc(expected[1]))
    refresh(agent)
    assert decide(agent)[:2] == (STEP, 2.0)


def test_the_end_of_an_episode_is_told_once_with_the_last_reward():
    agent = holder()
    agent["episodes"][0] = 1
    point = decide(agent)
    assert not point.ended
    act(agent, point.status, 1)
    perceive(agent, NOW + 30, started=True)
    point = decide(agent)
    assert (point.status, point.ended, point.acted, point.final_reward) == (NO_DECISION, True, True, 30.0)
    assert not decide(agent).ended
    perceive(agent, NOW + 60, started=True)
    point = decide(agent)
    assert (point.ended, point.acted) == (True, False), "told to keepers that never acted too"
    refresh(agent)
    ball(agent, tuple(agent["pos"][0] + 0.4))
    assert decide(agent).status == FIRST


def test_the_first_beginning_ends_nothing():
    agent = kernels.new_agent(LEFT, 1, 3, 2, PARAMS, 0)
    perceive(agent, 1, started=True)
    assert not decide(agent).ended


# -- perception -------------------------------------------------------------------------------------------------------
def test_a_new_episode_forgets_everybody():
    agent = holder()
    perceive(agent, NOW + 1, started=True)
    assert not ball_is_known(agent)
    assert not any(is_known(agent, o) for o in (1, 2, OPPONENTS, OPPONENTS + 1))


def sight(agent, time):
    see = Sight(time).landmarks((0.0, 0.0, 0.0), agent["wanted"][0])
    return see.ball(5.0, 0.0).player(2, 1, 5.0, 90.0).line((0.0, 0.0, 0.0)).see


def test_a_see_of_the_cycle_before_is_applied_before_the_sense():
    late, fresh = holder(), holder()
    for agent, time in ((late, NOW), (fresh, NOW + 1)):
        perceive(agent, NOW + 1, sight(agent, time))
    assert late["ball_seen"][0] == NOW
    assert fresh["ball_seen"][0] == NOW + 1
    # seen in cycle NOW, the opponent has since gone 0.3 m towards the ball
    assert tuple(fresh["player_pos"][0, OPPONENTS]) == pytest.approx((0.0, 5.0), abs=0.1)
    gap = late["player_pos"][0, OPPONENTS] - fresh["player_pos"][0, OPPONENTS]
    assert math.hypot(*gap) == pytest.approx(0.3, abs=0.02)


def test_a_heard_message_is_applied_last():
    agent = holder()
    record = nothing_heard()
    text = b"9AA1"
    record["time"][0], record["n"][0] = NOW + 1, len(text)
    record["text"][0, :4] = np.frombuffer(text, dtype=np.uint8)
    agent["player_seen"][0, OPPONENTS + 1] = NOW - 5
    perceive(agent, NOW + 1, heard=record)
    assert agent["player_seen"][0, OPPONENTS + 1] == NOW - 1


def test_the_guessed_ending_follows_the_ball():
    agent = holder()
    ball(agent, (9.0, 0.0), (0.5, 0.0))
    perceive(agent, NOW + 1)
    assert agent["taken_guess"][0]
    ball(agent, (9.0, 0.0), (1.5, 0.0))
    perceive(agent, NOW + 2)
    assert not agent["taken_guess"][0]


# -- actions ----------------------------------------------------------------------------------------------------------
def test_numbers_of_actions_are_whole_and_cut_towards_zero():
    agent = holder(body=33.3)
    action = act(agent, decide(agent).status, 1)
    assert action["kind"][0] == KICK
    _, *planned = pass_ball(holder(body=33.3), PARAMS, 1)
    for name, number in zip("ab", planned, strict=True):
        assert number != action[name][0] == math.trunc(number)
        assert agent[f"sent_{name}"][0] == action[name][0]
    assert not action["turns_neck"][0], "with the ball the neck is left alone"
    assert action["say_n"][0] > 0


def test_the_fastest_keeper_runs_and_looks_at_the_ball_others_get_open():
    agent = holder()
    ball(agent, (4.0, 0.0))
    action = act(agent, decide(agent).status)
    assert (action["kind"][0], action["a"][0], action["neck"][0]) == (DASH, 100.0, 0.0)
    agent = holder()
    ball(agent, (7.5, 1.0))
    know(agent, 0, (0.0, 0.0))
    action = act(agent, decide(agent).status)
    # alone on its side it goes down left, and looks at the centre: where it still is
    assert action["kind"][0] == TURN
    assert agent["fast_own"][0] == 1
    assert action["turns_neck"][0]


def test_a_lost_ball_is_searched_with_the_neck_straight():
    agent = holder()
    agent["head"][0] = 25.0
    agent["ball_seen"][0] = NEVER
    action = act(agent, decide(agent).status)
    assert (action["kind"][0], action["neck"][0]) == (TURN, -25.0)
    assert abs(action["a"][0]) in (59.0, 60.0)


def test_a_withheld_command_is_not_given():
    agent = holder()
    agent["withheld"][0] = 1
    action = act(agent, decide(agent).status)
    assert (action["kind"][0], action["turns_neck"][0], action["say_n"][0]) == (0, 0, 0)


def test_hold_shields_the_ball_from_the_nearest_opponent():
    agent = holder()
    know(agent, OPPONENTS, (2.0, 0.0), body=180.0)
    kind, _, direction = hold_ball(agent, PARAMS, 0.7)
    # away from it (180), 45 degrees to the side where it does not head
    place = 0.875 * np.array([math.cos(math.radians(-135.0)), math.sin(math.radians(-135.0))])
    assert kind == KICK
    kick = place - agent["ball_pos"][0]
    assert direction == pytest.approx(math.degrees(math.atan2(kick[1], kick[0])))
    know(agent, OPPONENTS, (2.0, 0.0), body=-170.0)
    assert hold_ball(agent, PARAMS, 0.7)[2] > 0.0, "the other side when it heads the other way"
    know(agent, OPPONENTS, (6.0, 0.0), body=180.0)
    assert hold_ball(agent, PARAMS, 0.7)[0] == TURN, "nobody near and the ball in front: turn to the goal"


def test_getting_open_avoids_the_others_and_closed_lanes():
    agent = player((0.0, 0.0), unum=1)
    for slot, pos in ((1, (7.0, -7.0)), (2, (-7.0, -7.0)), (OPPONENTS, (7.0, 0.0)), (OPPONENTS + 1, (-7.0, 0.0))):
        know(agent, slot, pos)
    x, y = open_point(agent, 0.0, 0.0)
    assert y == pytest.approx(7.0)
    know(agent, OPPONENTS, (0.0, 4.0))
    know(agent, OPPONENTS + 1, (3.0, 3.0))
    x, y = open_point(agent, 0.0, 0.0)
    assert not (x >= -1.0 and y > 3.0), "the lanes up and to the upper right are closed"


def test_getting_open_goes_to_the_centre_when_every_lane_is_closed():
    agent = player((5.0, 5.0), n=3, m=11)
    for k in range(11):
        way = 2.0 * math.pi * k / 11
        know(agent, OPPONENTS + k, (9.0 + 0.5 * math.cos(way), 9.0 + 0.5 * math.sin(way)))
    assert open_point(agent, 9.0, 9.0) == (0.0, 0.0)


# -- takers -----------------------------------------------------------------------------------------------------------
def taker(pos, unum=1, m=2, **more):
    agent = player(pos, side=RIGHT, unum=unum, n=3, m=m, **more)
    for k, place in enumerate(((8.0, 0.0), (-8.0, 3.0), (0.0, 9.0))):
        know(agent, OPPONENTS + k, place)
    return agent


def test_takers_chase_the_ball():
    agent = taker((0.0, 0.0))
    know(agent, 1, (5.0, 5.0))
    ball(agent, (7.5, 0.0))
    action = act(agent)
    assert (action["kind"][0], action["a"][0]) == (DASH, 100.0)


def test_a_taker_leaves_the_ball_to_the_other_who_has_it():
    agent = taker((0.0, 0.0), body=0.0)
    know(agent, 1, (0.0, 5.0))
    ball(agent, (0.5, 5.0))
    action = act(agent)
    assert action["kind"][0] == TURN
    assert action["a"][0] == pytest.approx(math.degrees(math.atan2(5.0, 0.5)), abs=1.0)
    assert action["turns_neck"][0]


def test_a_taker_with_the_ball_keeps_it_close():
    agent = taker((0.0, 0.0))
    know(agent, 1, (5.0, 5.0))
    ball(agent, (0.9, 0.0), (0.3, 0.3))
    expected = hold_ball(agent, PARAMS, 0.3)
    action = act(agent)
    assert (action["kind"][0], action["a"][0]) == (expected[0], math.trunc(expected[1]))
    assert not action["turns_neck"][0]


def test_the_third_taker_marks_the_most_open_keeper():
    agent = taker((0.0, -9.0), unum=3, m=3)
    know(agent, 0, (7.0, 0.5))
    know(agent, 1, (6.0, -0.5))
    ball(agent, (7.5, 0.0))
    know(agent, 1, (0.0, 1.0))  # in the lane from keeper 1 to keeper 2
    know(agent, 0, (4.5, 4.0))  # in the lane to keeper 3
    assert most_open_opponent(agent, OPPONENTS) == OPPONENTS
    know(agent, 0, (7.0, 0.5))
    assert most_open_opponent(agent, OPPONENTS) == OPPONENTS + 2
    action = act(agent)
    kind, amount = mark(agent, PARAMS, OPPONENTS + 2)
    assert (action["kind"][0], action["a"][0]) == (kind, math.trunc(amount))


def test_marking_stands_between_opponent_and_ball():
    agent = taker((0.0, -9.0), body=90.0)
    ball(agent, (-1.0, 0.0))
    # keeper 3 at (0, 9), taken for (-1, 9): the place is (-1, 5)
    kind, amount = mark(agent, PARAMS, OPPONENTS + 2)
    assert (kind, amount) == (DASH, 100.0)
    agent["pos"][0] = (-1.5, 4.5)
    kind, moment = mark(agent, PARAMS, OPPONENTS + 2)
    assert kind == TURN
    to_keeper = math.degrees(math.atan2(4.5, 1.5))
    assert moment == pytest.approx(to_keeper - 80.0 - 90.0)
    agent["pos"][0] = (-0.2, 4.5)
    kind, moment = mark(agent, PARAMS, OPPONENTS + 2)
    assert moment == pytest.approx(math.degrees(math.atan2(4.5, 0.2)) + 80.0 - 90.0), "the ball on the other side"
    assert mark(agent, PARAMS, NOBODY)[0] in (TURN, DASH)


# -- making players ---------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("side", "unum", "n", "m", "wrong"),
    [(0, 1, 3, 2, "side"), (LEFT, 0, 3, 2, "number"), (RIGHT, 12, 3, 2, "number"), (LEFT, 1, 12, 2, "keepers")],
)
def test_impossible_players_are_refused(side, unum, n, m, wrong):
    with pytest.raises(ValueError, match=wrong):
        kernels.new_agent(side, unum, n, m, PARAMS, 0)


def test_streams_differ_by_player_and_seed():
    agents = [
        kernels.new_agent(side, unum, 3, 2, PARAMS, seed)
        for side in (LEFT, RIGHT)
        for unum in (1, 2)
        for seed in (0, 1)
    ]
    assert len({tuple(agent["rng"][0]) for agent in agents}) == len(agents)


def test_vision_decides_which_landmarks_are_wanted():
    assert kernels.landmarks_wanted(PARAMS).sum() < 20
    assert kernels.landmarks_wanted(parameters(visible_angle=90.0)).sum() == 55
