from __future__ import annotations

import math

import pytest
from simulation_samples import FREE, QUIET, World, player

from fake_server.soccer import referee as soccer_referee
from fake_server.soccer import step as cycle
from fake_server.soccer.catch import catch_ball, catch_probability
from rcss_hat.protocol.records import LEFT, NO_SIDE
from rcss_hat.simulation import commands, pitch, placement, referee
from rcss_hat.simulation.state import (
    BEFORE_KICK_OFF,
    CATCH_FAULT_LEFT,
    DROP_BALL,
    E_CAUGHT,
    E_DROP_BALL,
    E_HALF_TIME,
    E_TIME_EXTENDED,
    E_TIME_UP,
    E_WITHOUT_A_TEAM,
    FOUL_CHARGE_LEFT,
    FREE_KICK_LEFT,
    FREE_KICK_RIGHT,
    GOAL_KICK_RIGHT,
    GOAL_LEFT,
    INDIRECT_FREE_KICK_RIGHT,
    KICK_OFF_RIGHT,
    OFFSIDE_LEFT,
    PLAY_ON,
    TIME_OVER,
    disconnect,
)


def step(world: World, times: int = 1) -> int:
    """Step some times; the events of all of them."""
    events = 0
    for _ in range(times):
        cycle.step(world.state)
        events |= int(world.match["events"][0])
    return events


def test_players_cannot_leave_the_world() -> None:
    world = World("l1", **FREE, **QUIET).play().put("l1", 10.0, 38.95, body=90.0).put("b", 0.0, 0.0)
    for _ in range(3):
        world.command("l1", "(dash 100)")
        step(world)
    assert list(world.match["pos"][0, 0]) == [10.0, 39.0]
    assert world.match["vel"][0, 0, 1] > 0.1
    assert pitch.nearest_in_world(60.0, 50.0) == (57.5, 39.0)
    assert pitch.nearest_in_world(-60.0, 3.0) == (-57.5, 3.0)


def test_time_stands_still_before_kick_off() -> None:
    world = World("l1", **FREE).put("l1", -10.0, 0.0)
    world.command("l1", "(dash 100)(turn_neck 20)")
    step(world, 3)
    m = world.match
    assert (m["time"][0], m["stopped"][0]) == (0, 3)
    assert list(m["pos"][0, 0]) == [-10.0, 0.0]
    assert m["neck"][0, 0] == pytest.approx(math.radians(20.0))


def test_half_times_and_the_end() -> None:
    world = (
        World("l1 r1", half_time=2, extra_half_time=1, use_offside=0).play().put("l1", -9.0, 0.0).put("r1", 9.0, 0.0)
    )
    m = world.match
    world.put("b", 0.0, -20.0)
    assert step(world, 19) == 0
    assert step(world) == E_HALF_TIME
    assert (m["mode"][0], m["time"][0], m["half_count"][0]) == (BEFORE_KICK_OFF, 20, 1)
    assert list(m["ball_pos"][0]) == [0.0, 0.0]
    m["mode"][0] = PLAY_ON
    assert step(world, 20) == E_TIME_EXTENDED
    assert (m["mode"][0], m["time"][0]) == (BEFORE_KICK_OFF, 40)
    for end, event in ((50, E_TIME_EXTENDED), (60, E_TIME_UP)):
        m["mode"][0] = PLAY_ON
        assert step(world, 10) == event
        assert m["time"][0] == end
    assert m["mode"][0] == TIME_OVER
    step(world)
    assert m["time"][0] == 60


def test_a_decided_game_has_no_extra_time() -> None:
    world = World("l1 r1", half_time=1, use_offside=0).play()
    world.match["score"][0] = 1, 0
    world.match["half_count"][0] = 1
    world.match["time"][0] = 19
    assert step(world) == E_TIME_UP


def test_a_game_without_a_team_is_over() -> None:
    world = World("l1", half_time=1, use_offside=0).play()
    world.match["half_count"][0] = 1
    world.match["time"][0] = 19
    assert step(world) == E_TIME_UP | E_WITHOUT_A_TEAM


@pytest.mark.parametrize(
    ("mode", "wait", "then"),
    [
        (OFFSIDE_LEFT, 30, FREE_KICK_RIGHT),
        (FOUL_CHARGE_LEFT, 30, FREE_KICK_RIGHT),
        (GOAL_LEFT, 50, KICK_OFF_RIGHT),
    ],
)
def test_stoppages_end_with_a_restart(mode: int, wait: int, then: int) -> None:
    world = World("l1 r1", **FREE).put("l1", 3.0, 20.0).put("r1", 20.0, 0.0).put("b", 0.0, 20.0)
    referee.change_play_mode(world.state, mode)
    step(world, wait)
    assert (world.match["mode"][0], world.match["time"][0], world.match["stopped"][0]) == (mode, 0, wait)
    step(world)
    assert (world.match["mode"][0], world.match["time"][0], world.match["stopped"][0]) == (then, 1, 0)
    if mode != GOAL_LEFT:
        # The guilty side was cleared from the ball.
        assert math.hypot(*(world.match["pos"][0, 0] - world.match["ball_pos"][0])) > 9.45


def test_a_foul_in_the_own_penalty_area_gives_an_indirect_free_kick() -> None:
    world = World("l1 r1", **FREE).put("b", -45.0, 0.0).put("l1", 0.0, 0.0).put("r1", 20.0, 0.0)
    referee.change_play_mode(world.state, FOUL_CHARGE_LEFT)
    step(world, 31)
    assert world.match["mode"][0] == INDIRECT_FREE_KICK_RIGHT


def test_a_free_kick_nobody_takes_is_dropped() -> None:
    world = World("l1 r1", **FREE).put("l1", -20.0, 0.0).put("r1", 3.0, 0.0)
    soccer_referee.free_kick(world.state, LEFT, 1.0, 0.0)
    assert math.hypot(*(world.match["pos"][0, player("r1")] - [1.0, 0.0])) > 9.45
    assert step(world, 99) == 0
    assert step(world) & E_DROP_BALL
    assert world.match["mode"][0] == PLAY_ON


def test_a_goal_kick_ends_when_the_ball_leaves_the_penalty_area() -> None:
    world = World("l1 r1", **FREE).put("l1", -20.0, 0.0).put("r1", 47.0, 0.0).put("b", 47.0, 9.0)
    referee.change_play_mode(world.state, GOAL_KICK_RIGHT)
    step(world)
    assert world.match["mode"][0] == GOAL_KICK_RIGHT
    world.put("b", 35.0, 9.0)
    step(world)
    assert world.match["mode"][0] == PLAY_ON


def test_a_ball_a_trainer_has_dropped_waits_for_a_kick() -> None:
    world = World("l1 r1", **FREE, **QUIET).put("l1", 3.0, 0.0).put("r1", 0.0, 3.0).put("b", 0.0, 0.0)
    referee.change_play_mode(world.state, DROP_BALL)
    assert step(world, 150) == 0
    assert world.match["mode"][0] == DROP_BALL
    assert min(math.hypot(*world.match["pos"][0, i]) for i in (0, 11)) > 9.45
    world.put("b", 0.0, 0.0, 1.0)
    step(world)
    assert world.match["mode"][0] == PLAY_ON


def test_a_goalie_may_catch_and_move_with_the_ball() -> None:
    world = World("l1 r1", **FREE, **QUIET).play().put("l1", -48.0, 0.0).put("b", -47.0, 0.0).put("r1", 0.0, 0.0)
    m, p = world.match, world.params
    assert not catch_ball(world.state, 0, 0.0)
    step(world)
    m["goalie"][0, 0] = 1
    world.put("b", -47.0, 0.0)
    assert catch_ball(world.state, 0, 0.0)
    assert (m["mode"][0], m["catcher"][0]) == (FREE_KICK_LEFT, 0)
    assert m["events"][0] & E_CAUGHT
    assert m["pos"][0, 0] == pytest.approx([-47.385, 0.0])
    step(world)
    for moves in range(3):
        assert commands.too_many_moves(m, p, 0) == (moves == 2)
        assert commands.move(world.state, 0, -44.0, 3.0 + moves)
        step(world)
    # Not moved a third time; the ball goes with him.
    assert list(m["pos"][0, 0]) == [-44.0, 4.0]
    assert m["ball_pos"][0] == pytest.approx([-44.0 + 0.385, 4.0])


def test_a_catch_outside_the_penalty_area_is_a_fault() -> None:
    world = World("l1", **FREE, **QUIET).play().put("l1", -20.0, 0.0).put("b", -19.0, 0.0)
    world.match["goalie"][0, 0] = 1
    assert catch_ball(world.state, 0, 0.0)
    assert (world.match["mode"][0], world.match["catcher"][0]) == (CATCH_FAULT_LEFT, -1)


def test_a_ball_that_slips_through_the_hands_bounces() -> None:
    world = World("l1", **FREE, **QUIET, catch_probability=0.0).play().put("l1", -48.0, 0.0).put("b", -47.0, 0.0, -1.0)
    world.match["goalie"][0, 0] = 1
    assert catch_ball(world.state, 0, 0.0)
    assert world.match["mode"][0] == PLAY_ON
    assert world.match["ball_acc"][0] == pytest.approx([2.0, 0.0])


def test_a_stretched_reach_is_not_certain() -> None:
    world = World("l1", **FREE).play().put("l1", -48.0, 0.0)
    world.types["catchable_area_l_stretch"][0] = 1.3
    # 1.2 m times 1.3 long: certain up to 0.84 m, then falling to 0 at 1.56 m.
    for x, p in ((0.8, 1.0), (1.2, 0.5), (1.5599, 0.0), (1.6, -1.0)):
        world.put("b", -48.0 + x, 0.0)
        assert catch_probability(world.state, 0, 0.0) == pytest.approx(p, abs=1e-3)


def test_a_goalie_who_goes_leaves_the_ball() -> None:
    world = World("l1", **FREE).play()
    world.match["catcher"][0] = 0
    disconnect(world.match, 0)
    assert world.match["catcher"][0] == -1


def test_a_missed_catch_bans_the_next_since_19() -> None:
    for profile, ban in (("19.0", 5), ("11.1", 0)):
        world = World("l1", profile, **FREE).play().put("l1", -48.0, 0.0).put("b", -30.0, 0.0)
        world.match["goalie"][0, 0] = 1
        assert not catch_ball(world.state, 0, 0.0)
        assert world.match["catch_ban"][0, 0] == ban


def test_players_are_sent_into_their_half_before_kick_off() -> None:
    world = World("l1 l2 r1 r2").put("l1", 10.0, 5.0).put("l2", -20.0, 5.0).put("r1", 3.0, 0.0).put("r2", 20.0, 0.0)
    step(world)
    m = world.match
    assert m["pos"][0, 0, 0] < 0.0 and list(m["pos"][0, 1]) == [-20.0, 5.0]
    assert math.hypot(*m["pos"][0, 11]) >= 9.45 and list(m["pos"][0, 12]) == [20.0, 0.0]


@pytest.mark.parametrize(
    ("ball", "where"), [((0.0, -33.0), (0.0, -38.0)), ((52.0, 0.0), (57.0, 1.0)), ((52.0, 33.0), (55.0, 36.0))]
)
def test_players_near_the_border_are_cleared_along_it(ball: tuple[float, float], where: tuple[float, float]) -> None:
    world = World("l1", **FREE).play().put("b", *ball).put("l1", *where)
    world.match["mode"][0] = DROP_BALL
    placement.clear_players_from_ball(world.state, NO_SIDE)
    x, y = world.match["pos"][0, 0]
    assert abs(x) <= 57.5 and abs(y) <= 39.0
    assert math.hypot(x - ball[0], y - ball[1]) == pytest.approx(9.45, abs=2e-5)


def test_a_trainer_moves_players_and_collisions_are_resolved() -> None:
    world = World("l1 l2", **FREE).play().put("l1", 0.0, 0.0, 0.2).put("l2", 5.0, 0.0).put("b", 30.0, 0.0)
    placement.move_player_to(world.state, 0, 5.2, 0.0)
    m = world.match
    assert m["pos"][0, 0, 0] - m["pos"][0, 1, 0] == pytest.approx(0.6, abs=1e-3)
    assert m["vel"][0, 0, 0] == pytest.approx(-0.02)
