from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from simulation_samples import COMPILED, DATA, KEEPAWAY, QUIET, World, player, rows

from fake_server.game import Game
from fake_server.options import ServerOptions
from rcss_hat.protocol import records as r
from rcss_hat.protocol.params import ServerParams
from rcss_hat.simulation import clock, commands, cycle, keepaway, vision
from rcss_hat.simulation.state import (
    BEFORE_KICK_OFF,
    E_DROP_BALL,
    E_EPISODE_OUT,
    E_EPISODE_TAKEN,
    E_PLAY_ON,
    KICK_OFF_LEFT,
    PLAY_ON,
    connect,
)

LENGTH = 20.0


def started(players: str = "l1 l2 l3 r1 r2", seed: int = 1, profile: str = "19.0", **changes: float) -> World:
    world = World(players, profile, seed, **{**KEEPAWAY, **changes})
    keepaway.kick_off(world.state)
    return world


def step(world: World) -> int:
    cycle.step(world.state)
    return int(world.match["events"][0])


def _corner(x: float, y: float) -> int:
    """Corner square of the region a point is in: 0 upper left, then clockwise; -1 none."""
    if not (7.0 <= abs(x) <= 10.0 and 7.0 <= abs(y) <= 10.0):
        return -1
    return {(-1, -1): 0, (1, -1): 1, (1, 1): 2, (-1, 1): 3}[int(np.sign(x)), int(np.sign(y))]


def test_kick_off_counts_the_teams_and_starts_episode_1() -> None:
    world = started("l1 l2 l3 l4 r1 r2 r3")
    m = world.match
    assert (m["n_keepers"][0], m["n_takers"][0], m["episode"][0], m["episode_start"][0]) == (4, 3, 1, 0)
    assert (m["mode"][0], m["time"][0], m["events"][0]) == (PLAY_ON, 0, E_PLAY_ON)
    assert step(world) == 0
    assert m["time"][0] == 1


def test_keepers_take_the_corners_in_a_random_rotation() -> None:
    world = started()
    first: Counter[int] = Counter()
    n = 900 if COMPILED else 150
    places = []
    for _ in range(n):
        keepaway.reset_field(world.state)
        corners = [_corner(*world.match["pos"][0, i]) for i in range(3)]
        assert corners in ([0, 1, 2], [1, 2, 0], [2, 0, 1])
        assert [_corner(*world.match["pos"][0, i]) for i in (11, 12)] == [3, 3]
        assert list(world.match["ball_pos"][0]) == [-6.0, -6.0]
        first[corners[0]] += 1
        places.append(np.abs(world.match["pos"][0, 0]) - 7.0)
    assert all(abs(count - n / 3) < 4.0 * math.sqrt(n * 2 / 9) for count in first.values())
    inside = np.array(places) / 3.0
    assert np.all(np.abs(inside.mean(axis=0) - 0.5) < 0.06) and inside.min() >= 0.0 and inside.max() <= 1.0


def test_further_keepers_start_in_the_middle() -> None:
    world = started("l1 l2 l3 l4 l5 r1 r2 r3 r4")
    for _ in range(20):
        keepaway.reset_field(world.state)
        corners = [_corner(*world.match["pos"][0, i]) for i in range(5)]
        start = corners.index(0)
        assert corners[start:] + corners[:start] == [0, 1, 2, -1, -1]
        middle = [np.abs(world.match["pos"][0, i]).max() for i in range(5) if corners[i] == -1]
        assert max(middle) <= 1.0


def test_recorded_placements_are_rotations_too() -> None:
    positions = _recorded_run()
    starts = [int(line.split("\t")[2]) for line in _log()]
    for time in starts:
        corners = [_corner(*positions[time][f"l{unum}"][:2]) for unum in (1, 2, 3)]
        assert corners in ([0, 1, 2], [1, 2, 0], [2, 0, 1]), time


def test_angles_stay_and_stamina_is_restored_except_in_11() -> None:
    for profile, stamina in (("19.0", 8000.0), ("11.1", 123.0)):
        world = started(profile=profile)
        world.match["body"][0, 0] = 1.5
        world.match["stamina"][0, 0] = 123.0
        keepaway.reset_field(world.state)
        assert world.match["body"][0, 0] == 1.5
        assert world.match["stamina"][0, 0] == stamina


def _log() -> list[str]:
    return [line for line in (DATA / "keepaway-run.kwy").read_text().splitlines() if not line.startswith("#")]


def _recorded_run() -> dict[int, dict[str, list[float]]]:
    found: dict[int, dict[str, list[float]]] = {}
    for row in rows("keepaway-run.csv.gz"):
        found.setdefault(int(row["t"]), {})[row["obj"]] = [float(row[key]) for key in ("x", "y", "vx", "vy")]
    return found


def test_recorded_run_ends_its_episodes_when_the_server_did() -> None:
    positions = _recorded_run()
    ends = {int(line.split("\t")[2]): line.split("\t")[4] for line in _log()}
    world = started()
    m = world.match
    found: dict[int, str] = {}
    for time in range(1, max(positions) + 1):
        m["time"][0] = time
        m["events"][0] = 0
        if time in ends:
            # The message shows the new episode; where the ball went is in its last velocity.
            x, y, vx, vy = positions[time - 1]["b"]
            world.put("b", x + vx, y + vy)
            if ends[time] == "o":
                assert max(abs(x + 1.3 * vx), abs(y + 1.3 * vy)) >= 0.5 * LENGTH - 1.5
                world.put("b", 10.0, 0.0)
        else:
            for name, state in positions[time].items():
                world.put(name, *state)
        keepaway.analyse_keepaway(world.state)
        if m["events"][0]:
            found[time] = "t" if m["events"][0] & E_EPISODE_TAKEN else "o"
            episode = keepaway.last_episode(m)
            number, start, end = (int(episode[key][0]) for key in ("episode", "start", "end"))
            assert f"{number}\t{start}\t{end}\t{end - start}\t{found[time]}" in _log()
            for name, state in positions[time].items():
                world.put(name, *state)
    assert found == ends


def _taken_counts(world: World, near: str) -> list[int]:
    """Events of steps in which a taker (t), a keeper (k), both (b) or nobody (n) is near the ball."""
    events = []
    for who in near:
        world.put("b", 0.0, 0.0).put("l1", 5.0, 5.0).put("r1", -5.0, 5.0)
        if who in "kb":
            world.put("l1", 0.9, 0.0)
        if who in "tb":
            world.put("r1", -0.9, 0.0)
        world.match["events"][0] = 0
        keepaway.analyse_keepaway(world.state)
        events.append(int(world.match["events"][0]))
    return events


@pytest.mark.parametrize(
    ("near", "ends_at"),
    [("ttttt", 4), ("ttttk", 4), ("ttttn", 4), ("tntnntnttt", 8), ("bbbbk", 4), ("tttktttt", None), ("kkkkkk", None)],
)
def test_takers_need_four_steps_and_a_fifth(near: str, ends_at: int | None) -> None:
    events = _taken_counts(started("l1 r1"), near)
    assert [k for k, event in enumerate(events) if event][:1] == ([] if ends_at is None else [ends_at])
    if ends_at is not None:
        assert events[ends_at] == E_EPISODE_TAKEN


@pytest.mark.parametrize(
    ("x", "y", "out"), [(9.99, 0.0, False), (10.0, 0.0, True), (0.0, -10.0, True), (3.0, 9.9, False)]
)
def test_ball_on_the_border_is_out(x: float, y: float, out: bool) -> None:
    world = started().put("b", x, y)
    for name in ("l1", "l2", "l3", "r1", "r2"):
        world.put(name, 0.0, 3.0 * player(name) / 5.0)
    assert step(world) == (E_EPISODE_OUT if out else 0)
    assert keepaway.last_episode(world.match)["end"][0] == (1 if out else 0)


def test_kickable_area_of_the_default_type_decides() -> None:
    world = started("l1 r1")
    for distance, taken in ((1.0849, 1), (1.0851, 0)):
        world.match["taken"][0] = 0
        world.put("b", 0.0, 0.0).put("l1", 5.0, 5.0).put("r1", distance, 0.0)
        keepaway.analyse_keepaway(world.state)
        assert world.match["taken"][0] == taken


def test_late_players_are_placed_but_not_counted() -> None:
    world = started("l1 l2 r1")
    connect(world.match, world.params, player("l3"), 11, False)
    keepaway.reset_field(world.state)
    assert world.match["n_keepers"][0] == 2
    assert {_corner(*world.match["pos"][0, i]) for i in range(3)} <= {0, 1}


def test_held_ball_is_dropped_as_recorded() -> None:
    world = started(**QUIET)
    for profile_time in (100,):
        for time in range(1, profile_time + 1):
            world.put("b", -6.0, -6.0).put("l1", -8.47385, -8.09922).put("l2", 8.0, -8.0).put("l3", 8.0, 8.0)
            world.put("r1", -8.0, 8.0).put("r2", -9.0, 9.0)
            world.match["stuck_pos"][0] = -6.0, -6.0
            events = step(world)
            assert events == (E_PLAY_ON | E_DROP_BALL if time == profile_time else 0)
    assert world.match["pos"][0, 0] == pytest.approx([-13.2054, -12.1143], abs=1e-4)
    assert world.match["mode"][0] == PLAY_ON
    assert world.match["episode"][0] == 1
    assert list(world.match["ball_vel"][0]) == [0.0, 0.0]


def test_everybody_ends_up_far_from_a_dropped_ball() -> None:
    world = started(**QUIET)
    m = world.match
    world.put("b", -6.0, -6.0)
    for k, name in enumerate(("l1", "l2", "l3", "r1", "r2")):
        world.put(name, -6.0 + 0.7 * k, -6.5)
    m["stuck_pos"][0] = -6.0, -6.0
    m["stuck_cycles"][0] = 99
    assert step(world) & E_DROP_BALL
    for i in (0, 1, 2, 11, 12):
        assert math.hypot(*(m["pos"][0, i] - m["ball_pos"][0])) > 9.45


def test_ball_that_leaves_the_circle_is_not_stuck() -> None:
    world = started(**QUIET)
    for k in range(300 if COMPILED else 120):
        world.put("b", 4.0 * (k // 50 % 2), 0.0)
        assert not step(world) & E_DROP_BALL


def test_same_seed_same_match_and_see_phases_are_drawn() -> None:
    def play(seed: int, waited: int) -> tuple[bytes, list[int]]:
        world = World(seed=seed, **KEEPAWAY)
        due = np.zeros(22, dtype=np.uint8)
        clock.sees_before_think(world.match, world.params, due)
        for _ in range(waited):
            clock.sees_after_think(world.match, world.params, due)
            clock.sees_before_think(world.match, world.params, due)
        clock.sees_after_think(world.match, world.params, due)
        keepaway.kick_off(world.state)
        phases = [int(world.match["see_ticks"][0, i]) for i in (0, 1, 2, 11, 12)]
        out, landmarks = r.empty(r.SEE), np.arange(55, dtype=np.uint8)
        for _ in range(30):
            for i in (0, 1, 2, 11, 12):
                commands.dash(world.state, i, 80.0, 0.0)
            step(world)
            clock.sees_before_think(world.match, world.params, due)
            for i in (0, 1, 2, 11, 12):
                for _ in range(due[i]):
                    vision.see(world.state, i, landmarks, True, out)
            clock.sees_after_think(world.match, world.params, due)
        return world.match.tobytes() + out.tobytes(), phases

    assert play(3, 0) == play(3, 7)
    assert play(3, 0)[0] != play(4, 0)[0]
    assert len({phase for seed in range(10) for phase in play(seed, 0)[1]}) == 3  # joined in one of three cycles


def test_other_games_start_with_a_kick_off_and_play_on_when_the_ball_moves() -> None:
    values = {"half_time": -1, "use_offside": 0, "forbid_kick_off_offside": 0}
    game = Game(replace(ServerOptions(), params=ServerParams("19.0", **values)), seed=1)
    left, right = game.join("left", 11, False), game.join("right", 11, False)
    game.match["pos"][0, left], game.match["pos"][0, right] = (-0.5, 0.0), (3.0, 0.0)
    assert game.mode == BEFORE_KICK_OFF
    game.kick_off()
    assert game.mode == KICK_OFF_LEFT
    # Opponents are kept 9.15 m away from the ball.
    assert math.hypot(*game.match["pos"][0, right]) > 9.45
    game.step()
    assert game.mode == KICK_OFF_LEFT
    commands.kick(game.world, left, 20.0, 0.0)
    game.step()
    assert game.mode == PLAY_ON
