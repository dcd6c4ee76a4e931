from __future__ import annotations

import math
from collections import defaultdict
from itertools import pairwise

import numpy as np
import pytest
from scipy import stats
from simulation_samples import COMPILED, FREE, QUIET, World, player, rows

from rcss_hat.protocol.records import COLLIDED_BALL, COLLIDED_PLAYER, COLLIDED_POST
from rcss_hat.simulation import commands, cycle, posts
from rcss_hat.simulation.clock import view_angle
from rcss_hat.simulation.state import BEFORE_KICK_OFF, C_DASH, C_KICK

State = dict[str, dict[str, str]]
_TOUCHING = "coll_player_dash_2"  # two players exactly touch: the printed precision decides whether they collide


def _scenarios() -> dict[str, dict[int, State]]:
    found: dict[str, dict[int, State]] = defaultdict(lambda: defaultdict(dict))
    for row in rows("physics-vectors.csv.gz"):
        found[row["scenario"]][int(row["t"])][row["obj"]] = row
    return found


def _set(world: World, state: State) -> None:
    m = world.match
    for name, row in state.items():
        world.put(name, *(float(row[key]) for key in ("x", "y", "vx", "vy")))
        if name == "b":
            continue
        i = player(name)
        world.face(name, float(row["body"]), float(row["neck"]))
        for key in ("stamina", "effort", "recovery", "capacity"):
            m[key][0, i] = float(row[key])
        m["tackle_cycles"][0, i] = int(row["tackle_expires"] or 0)
        m["command_done"][0, i] = m["tackle_cycles"][0, i] > 0


def _got(world: World, name: str) -> dict[str, float]:
    m = world.match
    if name == "b":
        (x, y), (vx, vy) = m["ball_pos"][0], m["ball_vel"][0]
        return {"x": x, "y": y, "vx": vx, "vy": vy}
    i = player(name)
    (x, y), (vx, vy) = m["pos"][0, i], m["vel"][0, i]
    got = {"x": x, "y": y, "vx": vx, "vy": vy, "tackle_expires": m["tackle_cycles"][0, i]}
    got |= {key: m[key][0, i] for key in ("stamina", "effort", "recovery", "capacity")}
    got |= {key: math.degrees(m[key][0, i]) for key in ("body", "neck")}
    return got


def _wrong(got: dict[str, float], row: dict[str, str]) -> list[str]:
    found = []
    for key, value in got.items():
        if row[key] == "":
            continue
        want = float(row[key])
        error = abs(value - want)
        tolerance = 1.2e-5 * max(1.0, abs(want)) + 3e-5
        if key in ("body", "neck"):
            # Angles beyond 100 degrees are printed, and so read back, in steps of 0.001 degrees.
            error, tolerance = min(error, 360.0 - error), tolerance + 1.1e-3
        if error > tolerance:
            found.append(f"{key}: {value} instead of {want}")
    return found


def test_every_recorded_step_is_reproduced() -> None:
    world = World("l1 l2 l3 r1 r2 r3", **FREE, **QUIET, ball_stuck_area=0.0).play()
    world.match["version"][0, player("r3")] = 12
    checked, wrong = 0, []
    for name, cycles in _scenarios().items():
        times = sorted(cycles)[: None if COMPILED or name == "stamina_exhaust" else 8]
        for now, then in pairwise(times):
            _set(world, cycles[now])
            for obj, row in cycles[now].items():
                if obj != "b":
                    world.command(obj, row["commands"])
            cycle.step(world.state)
            for obj, row in cycles[then].items():
                checked += 1
                faults = _wrong(_got(world, obj), row)
                if faults and name != _TOUCHING:
                    wrong.append((name, now, obj, faults))
    assert wrong == []
    assert checked > (13_000 if COMPILED else 5_000)


def _noise_samples() -> dict[str, list[list[dict[str, str]]]]:
    """Rows t = 0, 1, 2 of every repetition, by kind of scenario and object."""
    found: dict[str, list[list[dict[str, str]]]] = defaultdict(list)
    last = ""
    for row in rows("physics-noise.csv.gz"):
        kind = "side" if row["scenario"].startswith("noise_side") else "front"
        key = f"{kind} {row['obj']}"
        if row["scenario"] != last:
            last = row["scenario"]
            seen: set[str] = set()
        if key not in seen:
            seen.add(key)
            found[key].append([])
        found[key][-1].append(row)
    return found


def _same_distribution(recorded: list[float], simulated: list[float]) -> None:
    assert stats.ks_2samp(recorded, simulated).pvalue > 0.01


@pytest.mark.parametrize("kind", ["front", "side"])
def test_noise_of_a_kicked_ball_is_distributed_as_recorded(kind: str) -> None:
    samples = _noise_samples()
    balls, kickers = samples[f"{kind} b"], samples[f"{kind} l1"]
    world = World("l1", **FREE, ball_stuck_area=0.0).play()
    recorded, simulated = [], []
    for _ in range(8 if COMPILED else 2):
        for ball, kicker in zip(balls, kickers, strict=True):
            before, after = ball[0], ball[1]
            world.put("b", *(float(before[key]) for key in ("x", "y", "vx", "vy")))
            world.put("l1", *(float(kicker[0][key]) for key in ("x", "y", "vx", "vy")), float(kicker[0]["body"]))
            world.command("l1", kicker[0]["commands"])
            cycle.step(world.state)
            simulated.append(world.match["ball_pos"][0].copy())
            recorded.append([float(after["x"]), float(after["y"])])
    for axis in range(2):
        _same_distribution([r[axis] for r in recorded[: len(balls)]], [s[axis] for s in simulated])


def test_noise_of_turn_and_dash_is_distributed_as_recorded() -> None:
    samples = _noise_samples()
    turners, dashers = samples["front l2"], samples["front l3"]
    world = World("l2 l3", **FREE, ball_stuck_area=0.0).play().put("b", 50.0, 30.0)
    turned, dashed = [], []
    for turner, dasher in zip(turners * 4, dashers * 4, strict=True):
        for name, who in (("l2", turner), ("l3", dasher)):
            row = who[0]
            world.put(name, *(float(row[key]) for key in ("x", "y", "vx", "vy")), float(row["body"]))
            world.match["stamina"][0, player(name)] = 8000.0
            world.command(name, row["commands"])
        cycle.step(world.state)
        turned.append(math.degrees(world.match["body"][0, player("l2")]))
        dashed.append(world.match["pos"][0, player("l3")].copy())
    _same_distribution([float(turner[1]["body"]) for turner in turners], turned)
    for axis, key in enumerate("xy"):
        _same_distribution([float(dasher[1][key]) for dasher in dashers], [place[axis] for place in dashed])


def test_noise_of_motion_is_square_in_version_11() -> None:
    world = World("", "11.1", **FREE, ball_stuck_area=0.0).play()
    moves = []
    for _ in range(2000 if COMPILED else 300):
        world.put("b", 0.0, 0.0, 2.0, 0.0)
        cycle.step(world.state)
        moves.append(world.match["ball_pos"][0].copy())
    x, y = np.array(moves).T
    for value, middle in ((x, 2.0), (y, 0.0)):
        assert stats.kstest((value - middle) / 0.1, stats.uniform(-1.0, 2.0).cdf).pvalue > 0.01


# Scenarios of physics-noise-11.1.2: where ball and player start, at which speed, and what the player commands.
SCENARIOS_11 = {
    ("ball", 0.5): ((20.0, 0.5), 0.0, ""),
    ("ball", 2.5): ((20.0, 2.5), 0.0, ""),
    ("player", 0.8): ((20.0, 0.0), 0.8, ""),
    ("dash", 100.0): ((20.0, 0.0), 0.0, "(dash 100)"),
    ("turn", 60.0): ((20.0, 0.0), 0.0, "(turn 60)"),
    ("kick", 50.0): ((0.7, 0.0), 0.0, "(kick 50 0)"),
}


def _moves_11(kind: str, value: float, n: int) -> list[tuple[float, float]]:
    """Play a scenario some times; returns how far the result is from that without noise, in two coordinates."""
    (ball, ball_speed), speed, command = SCENARIOS_11[kind, value]
    world = World("l1", "11.1", **FREE, ball_stuck_area=0.0, kick_rand=0.1).play()
    kicked = 50 * 0.027 * (1.0 - 0.25 * (0.7 - 0.385) / 0.7)
    away = {"ball": ball + value, "player": value, "dash": 0.6, "turn": value, "kick": ball + kicked}[kind]
    moves = []
    for _ in range(n):
        world.put("b", ball, 0.0, ball_speed, 0.0).put("l1", 0.0, 0.0, speed)
        world.match["stamina"][0, 0] = 4000.0
        world.command("l1", command)
        cycle.step(world.state)
        x, y = world.match["ball_pos" if kind in ("ball", "kick") else "pos"][0].reshape(-1, 2)[0]
        if kind == "turn":
            x, y = round(math.degrees(world.match["body"][0, 0])), 0.0
        moves.append((x - away, y))
    return moves


@pytest.mark.parametrize(("kind", "value"), SCENARIOS_11)
def test_noise_of_11_is_distributed_as_recorded(kind: str, value: float) -> None:
    recorded = [
        (float(row["dx"]), float(row["dy"]))
        for row in rows("physics-noise-11.1.2.csv.gz")
        if row["scenario"] == kind and float(row["value"]) == value
    ]
    simulated = _moves_11(kind, value, 1500 if COMPILED else 300)
    for axis in range(1 if kind == "turn" else 2):
        _same_distribution([move[axis] for move in recorded], [move[axis] for move in simulated])


def test_kick_noise_is_drawn_for_negative_powers_too() -> None:
    world = World("l1", **FREE, player_rand=0.0, ball_rand=0.0).play()
    speeds = set()
    for _ in range(5):
        world.put("b", 0.7, 0.0).put("l1", 0.0, 0.0)
        world.command("l1", "(kick -50 0)")
        cycle.step(world.state)
        speeds.add(float(world.match["ball_vel"][0, 1]))
    assert len(speeds) == 5


def test_failed_kick_uses_the_command_up_in_19_and_not_in_11() -> None:
    for profile, dashes in (("19.0", 0), ("11.1", 1)):
        world = World("l1", profile, **FREE).play().put("b", 3.0, 0.0).put("l1", 0.0, 0.0)
        world.command("l1", "(kick 50 0)(dash 50)")
        cycle.step(world.state)
        assert world.match["counts"][0, 0, C_KICK] == 0
        assert world.match["counts"][0, 0, C_DASH] == dashes


def test_backward_dash_is_worth_nothing_since_version_17() -> None:
    for profile, speed in (("19.0", 0.0), ("11.1", -0.24)):
        world = World("l1", profile, **FREE, **QUIET).play().put("l1", 0.0, 0.0).put("b", 9.0, 9.0)
        world.command("l1", "(dash -100)")
        cycle.step(world.state)
        assert world.match["vel"][0, 0, 0] == pytest.approx(speed)


def test_effort_recovers_from_30_percent_on_in_version_11() -> None:
    for profile, effort in (("19.0", 0.8), ("11.1", 0.81)):
        world = World("l1", profile, **FREE).play()
        world.match["stamina"][0, 0] = 0.4 * world.params["stamina_max"][0]
        world.match["effort"][0, 0] = 0.8
        cycle.step(world.state)
        assert world.match["effort"][0, 0] == pytest.approx(effort)


def test_back_tackles_and_old_kicks_have_their_own_noise() -> None:
    world = World("l1", **FREE, max_back_tackle_power=100.0).play().put("l1", 0.0, 0.0).put("b", 0.5, 0.0)
    world.command("l1", "(tackle -100)")
    ax, ay = world.match["ball_acc"][0]
    assert -2.7 - 0.4 < ax < -2.7 + 0.4 and ay != 0.0
    old = World("l1", "11.1", **FREE, kick_rand=0.1).play().put("l1", 0.0, 0.0).put("b", 0.385, 0.0)
    pushes = []
    for _ in range(400):
        old.match["command_done"][0, 0] = 0
        old.put("b", 0.385, 0.0)
        old.command("l1", "(kick 50 0)")
        pushes.append(old.match["ball_acc"][0] - [50 * 0.027, 0.0])
    x, y = np.array(pushes).T
    for value in (x, y):
        assert stats.kstest(value / 0.05, stats.uniform(-1.0, 2.0).cdf).pvalue > 0.001


def test_slow_upper_half() -> None:
    for y, speed in ((5.0, 0.6), (-5.0, 0.3)):
        for name, side in (("l1", "left"), ("r1", "right")):
            world = World(name, **FREE, **QUIET, **{f"slowness_on_top_for_{side}_team": 2.0}).play()
            world.put(name, 0.0, y).put("b", 9.0, 9.0)
            world.command(name, "(dash 100)")
            cycle.step(world.state)
            assert world.match["vel"][0, player(name), 0] == pytest.approx(0.4 * speed)


def test_players_bounce_from_goal_posts_too() -> None:
    world = World("l1", **FREE, **QUIET).play().put("l1", 51.9, 7.07, 0.9).put("b", 0.0, 0.0)
    cycle.step(world.state)
    assert world.match["collided"][0, 0] == COLLIDED_POST
    assert world.match["vel"][0, 0, 0] == pytest.approx(-0.36)
    world.put("b", 52.0, 7.07, 1.0)
    cycle.step(world.state)
    assert world.match["ball_vel"][0, 0] == pytest.approx(-0.94)


def test_one_leg_dashes_turn_the_body_and_share_the_stamina() -> None:
    world = World("l1", **FREE, **QUIET).play().put("l1", 0.0, 0.0).put("b", 9.0, 9.0)
    assert commands.dash_legs(world.match, world.params, 0, commands.LEFT_LEG, 100.0, 0.0)
    assert not commands.dash_legs(world.match, world.params, 0, commands.LEFT_LEG, 50.0, 0.0)
    cycle.step(world.state)
    m = world.match
    assert m["vel"][0, 0, 0] == pytest.approx(0.4 * 0.3)
    assert m["body"][0, 0] == pytest.approx(0.6 / 0.6)
    assert m["stamina"][0, 0] == pytest.approx(8000.0 - 50.0 + 45.0)


def test_objects_on_the_same_spot_part_in_a_random_direction() -> None:
    world = World("l1 r1", **FREE, **QUIET).play().put("b", 30.0, 0.0)
    angles = []
    for _ in range(50):
        world.put("l1", 5.0, 5.0).put("r1", 5.0, 5.0)
        cycle.step(world.state)
        (x, y), other = world.match["pos"][0, 0], world.match["pos"][0, 11]
        assert math.hypot(x - other[0], y - other[1]) == pytest.approx(0.6, abs=1e-4)
        assert world.match["collided"][0, 0] == COLLIDED_PLAYER
        angles.append(math.atan2(y - 5.0, x - 5.0))
    assert max(angles) > 1.5 and min(angles) < -1.5


def test_waiting_ball_stays_and_the_player_gives_way() -> None:
    world = World("l1", **FREE, **QUIET).put("b", 0.0, 0.0)
    world.match["mode"][0] = BEFORE_KICK_OFF
    assert commands.move(world.state, 0, 0.1, 0.0)
    assert list(world.match["ball_pos"][0]) == [0.0, 0.0]
    assert world.match["pos"][0, 0, 0] == pytest.approx(0.385)
    assert world.match["collided"][0, 0] == COLLIDED_BALL


def test_ball_bounces_from_a_goal_post_without_loss() -> None:
    rng = World().rng
    x, y, vx, vy, touched = posts.move_past_posts(14.02, 51.0, 7.07, 2.0, 0.0, 0.085, rng)
    assert touched
    # Head on: reversed at 52.44 - 0.145, with the rest of the way back.
    assert (vx, vy) == pytest.approx((-2.0, 0.0), abs=1e-9)
    assert (x, y) == pytest.approx((52.295 - (2.0 - 1.295), 7.07), abs=1e-6)
    *_, vx, vy, touched = posts.move_past_posts(14.02, 51.0, 7.15, 2.0, 0.0, 0.085, rng)
    assert touched and vy > 0.5
    assert math.hypot(vx, vy) == pytest.approx(2.0)
    *_, touched = posts.move_past_posts(14.02, 51.0, 7.3, 2.0, 0.0, 0.085, rng)
    assert not touched


def test_ball_put_into_a_post_comes_out() -> None:
    rng = World().rng
    x, y, *_ = posts.move_past_posts(14.02, 52.44, 7.07, 0.0, 0.0, 0.085, rng)
    assert math.hypot(x - 52.44, y - 7.07) >= 0.145


def test_far_from_the_posts_nothing_is_looked_at() -> None:
    assert not posts.near_posts(14.02, 10.0, 0.0, 2.0, 2.0, 0.085)
    assert posts.near_posts(14.02, 51.0, 7.0, 2.0, 0.0, 0.085)


def test_view_angles() -> None:
    world = World("l1", visible_angle=90.0)
    angles = []
    for synch in (0, 1):
        world.match["synch_see"][0, 0] = synch
        for width in range(3):
            world.match["width"][0, 0] = width
            angles.append(view_angle(world.match, world.params, 0))
    assert angles == pytest.approx([45.0, 90.0, 180.0, 60.0, 120.0, 180.0])
