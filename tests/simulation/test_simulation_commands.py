from __future__ import annotations

import math

import numpy as np
import pytest
from simulation_samples import FREE, QUIET, World, player

from fake_server.soccer.tackle import tackle
from rcss_hat.protocol import records as r
from rcss_hat.simulation import commands, cycle
from rcss_hat.simulation.state import (
    BENCH_Y,
    C_ATTENTIONTO,
    C_CHANGE_VIEW,
    C_DASH,
    C_KICK,
    C_SAY,
    C_TACKLE,
    C_TURN,
    C_TURN_NECK,
    F_KICK,
    F_KICK_FAULT,
    F_TACKLE,
    F_TACKLE_FAULT,
    connect,
    disconnect,
)


def world_at_play(players: str = "l1 r1", profile: str = "19.0", **changes: float) -> World:
    return World(players, profile, **FREE, **QUIET, **changes).play().put("l1", 0.0, 0.0).put("b", 0.7, 0.0)


def step(world: World) -> None:
    cycle.step(world.state)


def test_the_first_body_command_of_a_cycle_wins() -> None:
    world = world_at_play()
    world.command("l1", "(turn 30)(dash 100)(kick 10 0)(turn 60)")
    step(world)
    m = world.match
    assert m["body"][0, 0] == pytest.approx(math.radians(30.0))
    assert [m["counts"][0, 0, c] for c in (C_TURN, C_DASH, C_KICK)] == [1, 0, 0]
    world.command("l1", "(dash 100)")
    step(world)
    assert m["counts"][0, 0, C_DASH] == 1


def test_neck_turns_beside_body_commands_once_and_within_limits() -> None:
    world = world_at_play()
    world.command("l1", "(turn_neck 170)(turn 10)(turn_neck -20)")
    step(world)
    assert world.match["neck"][0, 0] == pytest.approx(math.radians(90.0))
    assert world.match["counts"][0, 0, C_TURN_NECK] == 1


def test_arguments_are_clamped() -> None:
    world = world_at_play()
    world.command("l1", "(turn 1000)")
    step(world)
    assert abs(world.match["body"][0, 0]) == pytest.approx(math.pi)
    world.face("l1", 0.0).put("b", 20.0, 0.0)
    world.command("l1", "(dash 1000)")
    step(world)
    assert world.match["vel"][0, 0, 0] == pytest.approx(0.6 * 0.4)


def test_dash_directions_are_rounded_to_whole_degrees() -> None:
    world = world_at_play().put("b", 20.0, 0.0)
    assert commands.dash(world.state, 0, 100.0, 44.6)
    step(world)
    vx, vy = world.match["vel"][0, 0]
    assert math.degrees(math.atan2(vy, vx)) == pytest.approx(45.0)
    assert math.hypot(vx, vy) == pytest.approx(0.4 * 0.6 * 0.7)


def test_tackling_players_are_immobile_for_ten_cycles() -> None:
    world = world_at_play()
    world.command("l1", "(tackle 100)")
    assert world.match["counts"][0, 0, C_TACKLE] == 1
    for cycles in range(9, 0, -1):
        step(world)
        assert world.match["tackle_cycles"][0, 0] == cycles
        assert world.match["flags"][0, 0] & F_TACKLE
        world.command("l1", "(dash 100)(turn_neck 1)")
    step(world)
    assert world.match["counts"][0, 0, C_DASH] == 0
    assert world.match["counts"][0, 0, C_TURN_NECK] == 9
    world.command("l1", "(dash 100)")
    step(world)
    assert world.match["counts"][0, 0, C_DASH] == 1


def test_tackles_behind_fail_since_19() -> None:
    for profile, moved in (("19.0", False), ("11.1", True)):
        world = world_at_play(profile=profile).put("b", -0.45, 0.0)
        done = False
        for _ in range(20):
            world.match["command_done"][0, 0] = 0
            world.command("l1", "(tackle 100)")
            done = done or bool(world.match["ball_acc"][0].any())
            world.put("b", -0.3, 0.0)
        assert done == moved
        assert bool(world.match["flags_next"][0, 0] & F_TACKLE) == moved
        assert profile == "11.1" or world.match["flags_next"][0, 0] & F_TACKLE_FAULT


def test_intended_fouls_leave_the_tackler_mobile() -> None:
    world = world_at_play().put("r1", 1.2, 0.0)
    world.match["version"][0, 0] = 14
    tackle(world.state, 0, 0.0, True)
    assert world.match["tackle_cycles"][0, 0] == 0
    assert world.match["ball_acc"][0, 0] > 0.0


def test_kick_flags_show_in_the_frame_of_their_step() -> None:
    world = world_at_play()
    world.command("l1", "(kick 10 0)")
    assert world.match["flags"][0, 0] == 0
    step(world)
    assert world.match["flags"][0, 0] == F_KICK
    assert world.match["kick_cycles"][0, 0] == 1
    world.put("b", 9.0, 0.0)
    world.command("l1", "(kick 10 0)")
    step(world)
    assert world.match["flags"][0, 0] == F_KICK | F_KICK_FAULT
    step(world)
    assert (world.match["flags"][0, 0], world.match["kick_cycles"][0, 0]) == (0, 0)


def test_move_mirrors_the_right_team() -> None:
    world = World("l1 r1", **FREE)
    for name in ("l1", "r1"):
        assert commands.move(world.state, player(name), -10.0, 5.0)
    assert list(world.match["pos"][0, 0]) == [-10.0, 5.0]
    assert list(world.match["pos"][0, 11]) == [10.0, -5.0]
    world.play()
    step(world)
    assert not commands.move(world.state, 0, 0.0, 0.0)


def test_views() -> None:
    world = world_at_play()
    assert commands.change_view(world.match, 0, r.WIDE, r.LOW)
    assert (world.match["width"][0, 0], world.match["quality"][0, 0]) == (r.WIDE, r.LOW)
    assert commands.synch_see(world.match, 0)
    assert not commands.change_view(world.match, 0, r.WIDE, r.LOW)
    assert commands.change_view(world.match, 0, r.NARROW, r.HIGH)
    assert not commands.change_view(world.match, 0, 7, r.HIGH)
    assert world.match["counts"][0, 0, C_CHANGE_VIEW] == 2


def test_attention() -> None:
    world = world_at_play()
    m = world.match
    assert not commands.attention_to(m, 0, r.LEFT, 1)
    assert not commands.attention_to(m, 0, r.RIGHT, 12)
    assert commands.attention_to(m, 0, r.RIGHT, 11)
    assert (m["focus_side"][0, 0], m["focus_unum"][0, 0]) == (r.RIGHT, 11)
    assert commands.attention_off(m, 0)
    assert (m["focus_side"][0, 0], m["counts"][0, 0, C_ATTENTIONTO]) == (r.NO_SIDE, 2)


def test_arm_may_be_taken_down_after_the_ban() -> None:
    world = world_at_play()
    commands.point_to(world.match, world.params, 0, 5.0, 0.0)
    assert not commands.point_to_off(world.match, world.params, 0)
    for _ in range(5):
        step(world)
    assert commands.point_to_off(world.match, world.params, 0)
    assert world.match["arm_expires"][0, 0] == 0
    assert commands.point_to(world.match, world.params, 0, 5.0, 0.0)


@pytest.mark.parametrize("kind", [r.NO_COMMAND, r.DASH, r.TURN, r.KICK])
def test_act_does_what_the_commands_do(kind: int) -> None:
    acting, commanding = world_at_play(), world_at_play()
    for world in (acting, commanding):
        world.match["version"][0, 0] = 12
    action = r.empty(r.ACTION)
    action["kind"][0], action["a"][0] = kind, 80.0
    action["b"][0] = 20.0 if kind == r.KICK else 0.0
    action["turns_neck"][0], action["neck"][0] = 1, -30.0
    action["say_n"][0], action["say"][0, :2] = 2, (72, 105)
    accepted = commands.act(acting.state, 0, action)
    m, p = commanding.match, commanding.params
    texts = {r.DASH: "(dash 80)", r.TURN: "(turn 80)", r.KICK: "(kick 80 20)"}
    commanding.command("l1", texts.get(kind, ""))
    commanding.command("l1", "(turn_neck -30)")
    commands.say(m, p, 0, np.array([72, 105], dtype=np.uint8), 2)
    assert acting.match.tobytes() == commanding.match.tobytes()
    assert accepted == (kind in (r.DASH, r.TURN, r.KICK))
    assert m["counts"][0, 0, C_SAY] == 1


def test_players_connect_and_go() -> None:
    world = World("")
    m, p = world.match, world.params
    connect(m, p, player("r2"), 18, True)
    connect(m, p, player("l3"), 11, False)
    assert list(m["players"][0, :2]) == [2, 12]
    assert (m["n_players"][0], m["goalie"][0, 12], m["synch_see"][0, 12], m["synch_see"][0, 2]) == (2, 1, 1, 0)
    assert list(m["pos"][0, 12]) == [6.0, BENCH_Y] and list(m["pos"][0, 2]) == [-9.0, BENCH_Y]
    # The right team looks to the left until the first step.
    assert (m["body"][0, 12], m["body"][0, 2]) == (math.pi, 0.0)
    step(world)
    assert m["body"][0, 12] == 0.0
    m["pos"][0, 2] = 1.0, 1.0
    disconnect(m, player("l3"))
    assert (m["n_players"][0], list(m["players"][0, :1]), list(m["pos"][0, 2])) == (1, [12], [-9.0, BENCH_Y])
