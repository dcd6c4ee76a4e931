from __future__ import annotations

import itertools
import math
from collections import Counter
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats
from simulation_samples import COMPILED, World, player, rows

from rcss_hat.protocol import records as r
from rcss_hat.protocol.landmarks import LANDMARK_NAMES, LINE_NAMES
from rcss_hat.simulation import commands, observation, vision

ALL = np.ones(55, dtype=np.uint8)
NONE = np.zeros(55, dtype=np.uint8)
NAMES = list(LANDMARK_NAMES)
_WIDTHS = {"narrow": r.NARROW, "normal": r.NORMAL, "wide": r.WIDE}
_CLOSE = {"B": r.CLOSE_BALL, "P": r.CLOSE_PLAYER, "F": r.CLOSE_FLAG, "G": r.CLOSE_GOAL, "b": r.BALL}


def see(world: World, name: str = "l1", wanted: NDArray[np.uint8] = NONE) -> NDArray[np.void]:
    out = r.empty(r.SEE)
    landmarks = np.flatnonzero(wanted).astype(np.uint8)
    vision.see(world.state, player(name), landmarks, True, out)
    return out


def objects(out: NDArray[np.void], *codes: int) -> list[dict[str, Any]]:
    """The objects of a message with one of some codes; all without codes."""
    fields = [name for name in r.SEE.names or () if name not in ("time", "n")]
    found = [{name: out[name][0, k].item() for name in fields} for k in range(out["n"][0])]
    return [entry for entry in found if not codes or entry["code"] in codes]


def _number(text: str) -> float:
    """What a parser reads; -0 keeps its sign."""
    return float(text)


def _world_of(row: dict[str, str], world: World) -> World:
    """Set the world so that the observer and the object of a sample are alone in it."""
    m = world.match
    name, obj = row["observer"], row["object"]
    world.put(name, *(float(row[key]) for key in ("ox", "oy", "ovx", "ovy")))
    world.face(name, float(row["obody"]), float(row["oneck"]))
    i = player(name)
    m["quality"][0, i] = r.HIGH if row["quality"] == "high" else r.LOW
    m["width"][0, i] = _WIDTHS[row["width"]]
    world.put("b", 1e6, 1e6)
    alone = [i]
    if obj == "b":
        world.put("b", *(float(row[key]) for key in ("tx", "ty", "tvx", "tvy")))
    elif _is_player(obj):
        world.put(obj, *(float(row[key]) for key in ("tx", "ty", "tvx", "tvy")))
        world.face(obj, float(row["tbody"]), float(row["tneck"]))
        alone.append(player(obj))
    m["n_players"][0] = len(alone)
    m["players"][0, : len(alone)] = sorted(alone)
    return world


def _is_player(obj: str) -> bool:
    return obj[0] in "lr" and obj[1:].isdigit()


def _expected_code(row: dict[str, str]) -> int:
    name, seen = row["object"], row["seen_name"]
    if seen in _CLOSE:
        return _CLOSE[seen]
    if seen.startswith("p"):
        return r.PLAYER
    return r.LINE + LINE_NAMES.index(seen) if name.startswith("line") else NAMES.index(seen)


def _near(a: float, b: float, step: float) -> bool:
    """Same number, or one step off where rounding falls on the printed precision of the truth."""
    return abs(a - b) < 1.001 * step


def _compare(row: dict[str, str], entry: dict[str, Any], odd: Counter[str]) -> None:
    """Compare what is not random; count what differs in the last place."""
    numbers = [word for word in row["seen_fields"].split() if word not in ("t", "k")]
    high = row["quality"] == "high"
    if high:
        assert f"{entry['distance']:g}" == numbers[0], row
    direction = numbers[1] if high else numbers[0]
    if f"{entry['direction']:g}" != direction:
        assert _near(entry["direction"], float(direction), 1.0), row
        odd["direction"] += 1
    if len(numbers) < 4 or not entry["fields"] & r.HAS_CHANGE:
        return
    assert (f"{entry['distance_change']:g}", f"{entry['direction_change']:g}") == tuple(numbers[2:4]), row
    if entry["fields"] & r.HAS_FACING:
        for got, want in zip((entry["body"], entry["head"]), numbers[4:6], strict=True):
            if f"{got:g}" != want:
                assert _near(got, float(want), 1.0), row
                odd["facing"] += 1


def test_recorded_objects_look_the_same() -> None:
    worlds = {angle: World("l1 l2 l3 r1 r2 r3", visible_angle=angle) for angle in (90.0, 360.0)}
    for world in worlds.values():
        world.match["goalie"][0, player("r3")] = 1
    counts: Counter[str] = Counter()
    odd: Counter[str] = Counter()
    # Anonymous objects were assigned by nearest place; where two were near, a few are swapped.
    for k, row in enumerate(rows("perception-samples.csv.gz")):
        if row["match"] == "nearest" or (not COMPILED and k % 10):
            continue
        world = _world_of(row, worlds[float(row["visible_angle_param"])])
        wanted = NONE
        if row["object"] in NAMES:
            wanted = NONE.copy()
            wanted[NAMES.index(row["object"])] = 1
        out = objects(see(world, row["observer"], wanted))
        if not row["object"].startswith("line"):
            out = [entry for entry in out if not r.LINE <= entry["code"] < r.LINE + 4]
        if not row["seen_name"]:
            counts["unseen"] += 1
            odd["unseen"] += len(out)
            continue
        code = _expected_code(row)
        seen = [entry for entry in out if entry["code"] == code]
        assert len(seen) == 1, row
        _compare(row, seen[0], odd)
        counts["changes"] += bool(seen[0]["fields"] & r.HAS_CHANGE)
        counts["seen"] += 1
    assert counts["seen"] > (3000 if COMPILED else 300)
    assert counts["changes"] > (500 if COMPILED else 50)
    assert counts["unseen"] > (1000 if COMPILED else 100)
    # The truth is known to six digits; at the edges of rounding that decides.
    assert sum(odd.values()) <= 12


def _loss(kind: str) -> tuple[list[float], list[bool]]:
    """Reported distances and whether the detail was there, of the recorded objects of a kind at risk."""
    distances, kept = [], []
    for row in rows("perception-samples.csv.gz"):
        numbers = [word for word in row["seen_fields"].split() if word not in ("t", "k")]
        if row["quality"] != "high" or not numbers or row["seen_name"] in "BPFG":
            continue
        if kind == "landmark" and row["object"] in NAMES:
            there = len(numbers) == 4
        elif kind == "player" and row["seen_name"].startswith('p "'):
            there = len(row["seen_name"].split()) > 2
        else:
            continue
        if 20.0 < float(numbers[0]) < 40.0:
            distances.append(float(numbers[0]))
            kept.append(there)
    return distances, kept


@pytest.mark.parametrize("kind", ["landmark", "player"])
def test_recorded_loss_of_detail_grows_linearly_from_20_to_40_m(kind: str) -> None:
    distances, kept = _loss(kind)
    p = 1.0 - (np.array(distances) - 20.0) / 20.0
    assert len(p) > 150
    assert abs(np.sum(kept) - p.sum()) < 3.0 * math.sqrt(np.sum(p * (1.0 - p)))


def _share(world: World, repeats: int, test: Any) -> float:
    return float(np.mean([test(see(world)) for _ in range(repeats)]))


def test_our_loss_of_detail_follows_the_same_law() -> None:
    n = 4000 if COMPILED else 300
    world = World("l1 r1", visible_angle=360.0).put("l1", 0.0, 0.0).put("r1", 30.0, 0.0).put("b", 0.0, 30.0, 1.0)
    dist = objects(see(world), r.BALL)[0]["distance"]
    p = 1.0 - (dist - 20.0) / 20.0
    spread = 4.0 * math.sqrt(p * (1.0 - p) / n)
    ball = _share(world, n, lambda out: objects(out, r.BALL)[0]["fields"] & r.HAS_CHANGE > 0)
    number = _share(world, n, lambda out: objects(out, r.PLAYER)[0]["unum"] > 0)
    assert abs(ball - p) < spread
    assert abs(number - p) < spread


@pytest.mark.parametrize(("profile", "known"), [("19.0", 0.5), ("11.1", 1.0)])
def test_team_fades_from_40_to_60_m_since_19(profile: str, known: float) -> None:
    n = 2000 if COMPILED else 200
    world = World("l1 r1", profile, visible_angle=360.0).put("l1", -25.0, 0.0).put("r1", 25.0, 0.0)
    world.params["quantize_step"][0] = 0.0
    share = _share(world, n, lambda out: objects(out, r.PLAYER)[0]["team"] == r.OTHER_TEAM)
    assert abs(share - known) < 4.0 * 0.5 / math.sqrt(n)
    world.put("r1", 40.0, 0.0)
    assert objects(see(world), r.PLAYER)[0]["team"] == r.UNKNOWN_TEAM


def test_clients_of_version_18_always_know_the_team() -> None:
    world = World("l1 r1", visible_angle=360.0).put("l1", -40.0, 0.0).put("r1", 40.0, 0.0)
    world.match["version"][0, 0] = 18
    assert all(objects(see(world), r.PLAYER)[0]["team"] == r.OTHER_TEAM for _ in range(50))


def test_landmarks_left_out_change_nothing_else() -> None:
    def messages(wanted: NDArray[np.uint8]) -> list[list[dict[str, Any]]]:
        world = World("l1 r1", visible_angle=360.0, seed=5).put("l1", 0.0, 0.0).put("r1", 30.0, 0.0).put("b", 0.0, 25.0)
        return [objects(see(world, "l1", wanted)) for _ in range(40)]

    some = NONE.copy()
    some[[0, 5, 20, 33]] = 1
    full = messages(ALL)
    assert [[o for o in message if o["code"] > 54] for message in full] == messages(NONE)
    assert [[o for o in message if o["code"] > 54 or some[o["code"]]] for message in full] == messages(some)


def test_loss_of_landmarks_is_independent() -> None:
    world = World("l1", visible_angle=360.0).put("l1", 0.0, 0.0, body=50.0)
    at_risk = [NAMES.index(name) for name in ("f c t", "f c b", "f p l c", "f p r c")]
    n = 3000 if COMPILED else 300
    kept = np.zeros((n, 4), dtype=bool)
    for k in range(n):
        entries = {o["code"]: o["fields"] for o in objects(see(world, "l1", ALL), *at_risk)}
        kept[k] = [entries[code] & r.HAS_CHANGE > 0 for code in at_risk]
    correlation = np.corrcoef(kept.T.astype(float)) - np.eye(4)
    assert np.abs(correlation).max() < 4.5 / math.sqrt(n)
    assert np.all(np.abs(kept.mean(axis=0) - [0.3, 0.3, 0.2, 0.2]) < 0.05 + 1.0 / math.sqrt(n))


def test_negative_zero_is_kept_in_changes_and_never_in_directions() -> None:
    world = World("l1", visible_angle=360.0).put("l1", 10.0, 10.0).put("b", 9.0, 9.0)
    ball = objects(see(world), r.BALL)[0]
    assert math.copysign(1.0, ball["distance_change"]) == -1.0
    world.put("b", 15.0, 10.0 - 1e-5)
    assert math.copysign(1.0, objects(see(world), r.BALL)[0]["direction"]) == 1.0


def test_objects_straight_behind_are_close_at_360_degrees() -> None:
    world = World("l1 l2", visible_angle=360.0).put("l1", 0.0, 0.0).put("l2", -3.0, 0.0).put("b", -5.0, 0.0)
    entries = objects(see(world), r.CLOSE_PLAYER, r.PLAYER, r.BALL, r.CLOSE_BALL)
    assert [(o["code"], o["distance"], o["direction"]) for o in entries] == [(r.CLOSE_PLAYER, 3.0, 180.0)]


def test_message_order_and_line() -> None:
    world = World("l2 l1 r1", visible_angle=360.0).put("l1", 0.0, 0.0, body=-60.0).put("l2", 5.0, 0.0)
    out = see(world.put("r1", 0.0, 5.0).put("b", 3.0, 3.0), "l1", ALL)
    codes = [o["code"] for o in objects(out)]
    assert codes == [*range(55), r.BALL, r.PLAYER, r.PLAYER, r.LINE + 2]
    assert [o["team"] for o in objects(out, r.PLAYER)] == [r.OWN_TEAM, r.OTHER_TEAM]
    top = objects(out, r.LINE + 2)[0]
    # 34 m away at 30 degrees from the line's normal; the line runs at 60 degrees from the line of sight.
    assert top["distance"] == pytest.approx(34.0 / math.cos(math.radians(30.0)), rel=0.01)
    assert top["direction"] == 60.0


def test_two_lines_are_seen_from_outside() -> None:
    world = World("l1").put("l1", -55.0, 0.0).put("b", -90.0, 0.0)
    lines = objects(see(world, "l1"))
    assert [(o["code"], o["direction"]) for o in lines] == [(r.LINE, 90.0), (r.LINE + 1, 90.0)]


def test_low_quality_has_directions_only() -> None:
    world = World("l1 r1", visible_angle=360.0).put("l1", 0.0, 0.0).put("r1", 5.0, 5.0).put("b", 3.0, 0.0)
    assert commands.change_view(world.match, 0, r.NORMAL, r.LOW)
    out = objects(see(world, "l1", ALL))
    assert {o["fields"] for o in out} == {0}
    assert {o["distance"] for o in out} == {0.0}
    assert objects(see(world), r.PLAYER)[0]["unum"] == 1


@pytest.mark.parametrize("step", [0.0, 0.01, 0.05, 0.1, 0.3])
def test_distances_follow_the_formula_in_any_step(step: float) -> None:
    world = World("l1", visible_angle=360.0, quantize_step=step).put("l1", 0.0, 0.0)
    for dist in (0.5, 1.7, 12.34, 55.5, 110.0):
        world.put("b", dist, 0.0)
        want = math.exp(round(math.log(dist) / step) * step) if step else dist
        assert objects(see(world), r.BALL)[0]["distance"] == round(10.0 * want) / 10.0


@pytest.mark.parametrize("step", [0.01, 0.1])
def test_tabulated_distances_are_those_of_the_formula_to_the_last_bit(step: float) -> None:
    edges = _changes_of_tenths(step)
    assert len(edges) > 50
    for edge in edges:
        for dist in (math.nextafter(edge, 0.0), edge, math.nextafter(edge, math.inf), edge + 0.01):
            assert observation.quantized_tenths(dist, step) == observation.tenths_by_logarithm(dist, step)
    assert observation.quantized_tenths(0.0, step) == 0.0


def _changes_of_tenths(step: float) -> list[float]:
    """Distances up to 128 m at which the reported distance changes, found by halving."""
    found, places = [], np.linspace(0.04, 127.9, 4000)
    for low, high in itertools.pairwise(float(x) for x in places):
        before, after = (observation.tenths_by_logarithm(x, step) for x in (low, high))
        while before != after and math.nextafter(low, high) < high:
            middle = 0.5 * (low + high)
            low, high = (low, middle) if observation.tenths_by_logarithm(middle, step) == after else (middle, high)
        if before != after:
            found.append(high)
    return found


def test_landmarks_without_motion_are_at_the_same_places() -> None:
    world = World("l1", visible_angle=360.0).put("l1", 3.0, -4.0, body=20.0)
    out = r.empty(r.SEE)
    vision.see(world.state, 0, np.arange(55, dtype=np.uint8), False, out)
    still, full = objects(out), objects(see(world, "l1", ALL))
    assert len(still) == len(full)
    places = [[(o["code"], o["distance"], o["direction"]) for o in message] for message in (still, full)]
    assert places[0] == places[1]
    assert {o["fields"] for o in still if o["code"] < 55} == {r.HAS_DISTANCE}


def test_close_players_have_no_names() -> None:
    world = World("l1 l2", visible_angle=90.0).put("l1", 0.0, 0.0).put("l2", 0.0, 2.0).put("b", 40.0, 0.0)
    assert [(o["fields"], o["unum"]) for o in objects(see(world), r.CLOSE_PLAYER)] == [(r.HAS_DISTANCE, 0)]
    commands.change_view(world.match, 0, r.NORMAL, r.LOW)
    assert [(o["fields"], o["direction"]) for o in objects(see(world), r.CLOSE_PLAYER)] == [(0, 90.0)]


def test_gaussian_landmarks() -> None:
    world = World("l1", visible_angle=360.0).put("l1", 0.0, 0.0, body=50.0)
    commands.gaussian_see(world.match, 0)
    only = NONE.copy()
    only[NAMES.index("g r")] = 1
    n = 2000 if COMPILED else 200
    dist = np.array([objects(see(world, "l1", only))[0]["distance"] for _ in range(n)])
    assert stats.kstest((dist - 52.5) / (52.5 * 0.0025), "norm").pvalue > 0.001


def test_tackling_and_kicking_players_are_marked() -> None:
    world = World("l1 r1", visible_angle=360.0).play().put("l1", 0.0, 0.0).put("r1", 5.0, 0.0).put("b", 5.5, 0.0)
    world.match["kick_cycles"][0, :] = 0
    world.command("r1", "(kick 10 0)")
    assert not objects(see(world), r.PLAYER)[0]["fields"] & r.IS_KICKING  # version 11 does not know the mark
    world.match["version"][0, 0] = 13
    assert objects(see(world), r.PLAYER)[0]["fields"] & r.IS_KICKING
    world.match["tackle_cycles"][0, player("r1")] = 3
    marks = objects(see(world), r.PLAYER)[0]["fields"] & (r.IS_KICKING | r.IS_TACKLING)
    assert marks == r.IS_TACKLING


def test_pointing_directions_are_normal_around_the_truth() -> None:
    world = World("l1 l2", visible_angle=360.0).put("l1", 0.0, 0.0).put("l2", 15.0, 0.0)
    assert commands.point_to(world.match, world.params, player("l2"), 10.0, 90.0)
    n = 3000 if COMPILED else 200
    seen = [objects(see(world), r.PLAYER)[0] for _ in range(n)]
    assert all(o["fields"] & r.HAS_POINTING for o in seen)
    sigma = math.degrees((15.0 / 125.096) ** 4 * (math.pi - math.radians(1.25)) + math.radians(1.25))
    noise = np.array([o["pointing"] for o in seen]) - 90.0
    # Spread to a continuous value before the comparison: the message has whole degrees.
    smooth = noise + np.random.default_rng(1).uniform(-0.5, 0.5, n)
    assert abs(noise.mean()) < 5.0 * sigma / math.sqrt(n)
    assert stats.kstest(smooth / math.hypot(sigma, math.sqrt(1.0 / 12.0)), "norm").pvalue > 0.001


def test_gaussian_see_and_focus_point() -> None:
    world = World("l1", visible_angle=360.0).put("l1", 0.0, 0.0).put("b", 10.0, 0.0)
    world.match["version"][0, 0] = 18
    plain = objects(see(world), r.BALL)[0]["distance"]
    commands.change_focus(world.match, world.params, 0, 8.0, 0.0)
    focused = objects(see(world), r.BALL)[0]["distance"]
    assert plain == 10.0 and focused == 10.0
    world.put("b", 10.6, 0.0)
    # Errors at 10.6 m (10 reported) and at 2.6 m from the focus point (2.7) are averaged.
    near, focus_near = math.exp(round(math.log(10.6) * 10.0) / 10.0), math.exp(round(math.log(2.6) * 10.0) / 10.0)
    want = 10.6 - ((2.6 - focus_near) + (10.6 - near)) / 2.0
    assert objects(see(world), r.BALL)[0]["distance"] == pytest.approx(round(want, 1))
    commands.gaussian_see(world.match, 0)
    n = 3000 if COMPILED else 200
    dist = np.array([objects(see(world), r.BALL)[0]["distance"] for _ in range(n)])
    sigma = 0.0125 * (10.6 + 2.6)
    assert stats.kstest((dist - 10.6) / sigma, "norm").pvalue > 0.001


def test_far_objects_are_not_seen_since_19() -> None:
    for profile, seen in (("19.0", 0), ("11.1", 1)):
        world = World("l1", profile, visible_angle=360.0).put("l1", -57.0, -39.0).put("b", 70.0, 39.0)
        assert len(objects(see(world), r.BALL)) == seen
