from __future__ import annotations

import math
import re

import numpy as np
import pytest
from numpy.typing import NDArray
from simulation_samples import FREE, World, json_lines, player

from rcss_hat.protocol import records as r
from rcss_hat.simulation import body, commands, cycle
from rcss_hat.simulation.state import (
    C_ATTENTIONTO,
    C_CATCH,
    C_CHANGE_VIEW,
    C_DASH,
    C_KICK,
    C_MOVE,
    C_POINTTO,
    C_SAY,
    C_TACKLE,
    C_TURN,
    C_TURN_NECK,
)

_FULL_COUNTS = (C_KICK, C_DASH, C_TURN, C_CATCH, C_MOVE, C_TURN_NECK, C_CHANGE_VIEW, C_SAY)
_WIDTHS = {"narrow": r.NARROW, "normal": r.NORMAL, "wide": r.WIDE}


def sense(world: World, name: str = "l1") -> NDArray[np.void]:
    out = r.empty(r.SENSE_BODY)
    body.sense_body(world.state, player(name), out)
    return out


def _numbers(pattern: str, text: str) -> list[float]:
    found = re.search(pattern, text)
    assert found, text
    return [float(word) for word in found[1].split()]


def _fill(world: World, name: str, full: str, text: str) -> None:
    """Set a match from a fullstate message (and from the sense_body what only that has)."""
    m, i = world.match, player(name)
    side, unum = name[0], name[1:]
    own = _numbers(rf"\(\(p {side} {unum} 0\) ([^(]*)\(", full)
    world.put(name, *own[:4]).face(name, own[4], own[5])
    m["stamina"][0, i], m["effort"][0, i], m["recovery"][0, i] = _numbers(
        rf"\(p {side} {unum} 0\).*?stamina ([^)]*)", full
    )
    m["time"][0] = int(full.split()[1])
    found = re.search(r"vmode (\w+) (\w+)", full)
    assert found
    m["quality"][0, i] = r.HIGH if found[1] == "high" else r.LOW
    m["width"][0, i] = _WIDTHS[found[2]]
    for counter, value in zip(_FULL_COUNTS, _numbers(r"\(count ([^)]*)\) \(arm", full), strict=True):
        m["counts"][0, i, counter] = value
    m["arm_movable"][0, i], m["arm_expires"][0, i] = (
        _numbers(r"movable (\d+)", full)[0],
        _numbers(r"expires (\d+)", full)[0],
    )
    if len(own) > 6:
        angle = own[7] + m["body"][0, i] + m["neck"][0, i]
        m["arm_pos"][0, i] = own[0] + own[6] * math.cos(angle), own[1] + own[6] * math.sin(angle)
    m["counts"][0, i, C_POINTTO] = _numbers(r"\(arm .*?count (\d+)", full)[0]
    m["counts"][0, i, C_ATTENTIONTO] = _numbers(r"\(focus .*?count (\d+)", text)[0]
    m["counts"][0, i, C_TACKLE] = _numbers(r"\(tackle .*?count (\d+)", text)[0]
    m["tackle_cycles"][0, i] = _numbers(r"\(tackle \(expires (\d+)", text)[0]
    target = re.search(r"target (l|r) (\d+)", text)
    m["focus_side"][0, i] = r.NO_SIDE if target is None else r.LEFT if target[1] == "l" else r.RIGHT
    m["focus_unum"][0, i] = 0 if target is None else int(target[2])


def _words(out: NDArray[np.void]) -> list[str]:
    """All numbers of the message in its order."""
    arm, focus = (
        [f"{out[key][0]:g}" for key in ("arm_movable", "arm_expires", "arm_distance", "arm_direction", "arm_count")],
        [],
    )
    if out["focus_side"][0]:
        focus = [f"{out['focus_unum'][0]}"]
    head = [f"{out[key][0]:g}" for key in ("time", "stamina", "effort", "speed", "speed_direction", "head_angle")]
    tail = [f"{out[key][0]:g}" for key in ("focus_count", "tackle_expires", "tackle_count")]
    return head + [f"{count}" for count in out["counts"][0]] + arm + focus + tail


def test_recorded_messages_are_reproduced() -> None:
    names = {"k1": "l1", "k2": "l2", "k3": "l3", "t1": "r1", "t2": "r2"}
    world = World()
    samples = json_lines("sense-body.jsonl.gz")
    cut_below = 0
    for sample in samples:
        name, text = names[sample["client"]], sample["sense_body"]
        _fill(world, name, sample["fullstate"], text)
        sensed = sense(world, name)
        assert ("high" in text) == (sensed["quality"][0] == r.HIGH)
        assert f"{('narrow', 'normal', 'wide')[sensed['width'][0]]})" in text
        # Angles are cut to whole degrees; which side of one they are on is not in the six digits of the truth.
        for got, want in zip(_words(sensed), re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", text), strict=True):
            if got != want:
                assert abs(abs(float(got)) - abs(float(want))) == 1.0, text
                cut_below += 1
    assert len(samples) == 400
    assert cut_below < 110


def test_versions_have_what_they_know() -> None:
    world = World("l1 r1", **FREE).play().put("l1", 0.0, 0.0).put("r1", 0.5, 0.0).put("b", 20.0, 0.0)
    cycle.step(world.state)
    for version, capacity, collision in (
        (11, -1.0, 0),
        (12, -1.0, r.COLLIDED_PLAYER),
        (13, 130600.0, r.COLLIDED_PLAYER),
    ):
        world.match["version"][0, 0] = version
        out = sense(world)
        assert out["capacity"][0] == capacity
        assert (out["has_collision"][0], out["collision"][0]) == (version >= 12, collision)


def test_standing_players_move_against_their_face() -> None:
    world = World().put("l1", 0.0, 0.0, body=30.9)
    assert sense(world)["speed_direction"][0] == -30.0


def test_arm_counts_down() -> None:
    world = World("l1", **FREE).play().put("l1", 0.0, 0.0).put("b", 20.0, 0.0)
    assert commands.point_to(world.match, world.params, 0, 10.04, 20.0)
    assert not commands.point_to(world.match, world.params, 0, 3.0, 0.0)
    seen = []
    for _ in range(21):
        cycle.step(world.state)
        out = sense(world)
        seen.append((int(out["arm_movable"][0]), int(out["arm_expires"][0]), float(out["arm_distance"][0])))
    assert seen[0] == (4, 19, 10.0)
    assert seen[4] == (0, 15, 10.0)
    assert seen[19:] == [(0, 0, 0.0)] * 2
    assert out["arm_count"][0] == 1
    assert out["arm_direction"][0] == 0.0


def test_angles_are_cut_towards_zero() -> None:
    world = World("l1", **FREE).play().put("l1", 0.0, 0.0).put("b", 20.0, 0.0)
    for neck, shown in ((29.9, 29.0), (-29.9, -29.0), (-0.5, 0.0)):
        world.face("l1", 0.0, neck)
        out = sense(world)
        assert out["head_angle"][0] == shown
        assert math.copysign(1.0, out["head_angle"][0]) == math.copysign(1.0, shown) or shown != 0.0


@pytest.mark.parametrize(("stamina", "read"), [(7903.0, 7903.0), (1234.56789, 1234.57), (0.000123456789, 0.000123457)])
def test_stamina_is_read_from_six_digits(stamina: float, read: float) -> None:
    world = World()
    world.match["stamina"][0, 0] = stamina
    assert sense(world)["stamina"][0] == read
