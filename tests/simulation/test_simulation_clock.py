from __future__ import annotations

import json
import re

import numpy as np
import pytest
from simulation_samples import DATA, World

from rcss_hat.protocol import records as r
from rcss_hat.simulation import clock

# What arrives between two thinks with synch_offset 60: S see, b sense_body, t think; repeated.
CADENCES = {
    (r.NORMAL, r.HIGH): "Sbt bSt bt",
    (r.NARROW, r.HIGH): "bSt Sbt SbSt",
    (r.WIDE, r.HIGH): "bSt bt bt",
    (r.NARROW, r.LOW): "SbSSt SbSSt SbSt",
    (r.NORMAL, r.LOW): "bSt Sbt SbSt",
    (r.WIDE, r.LOW): "bSt bt Sbt",
}


def _cycles(world: World, n: int) -> list[str]:
    """Messages of player l1 in n cycles, from one think to the next."""
    due = np.zeros(22, dtype=np.uint8)
    found = []
    for _ in range(n):
        clock.sees_after_think(world.match, world.params, due)
        text = "S" * due[0] + "b"
        clock.sees_before_think(world.match, world.params, due)
        found.append(text + "S" * due[0] + "t")
    return found


def _world(offset: int, width: int = r.NORMAL, quality: int = r.HIGH, ticks: int = 0) -> World:
    world = World("l1", synch_mode=1, synch_offset=offset)
    world.match["width"][0, 0], world.match["quality"][0, 0] = width, quality
    world.match["see_ticks"][0, 0] = ticks
    world.match["clock"][0] = clock.think_offset(world.params)
    return world


def _rotations(cadence: str) -> set[str]:
    groups = cadence.split()
    return {" ".join(groups[k:] + groups[:k]) for k in range(len(groups))}


@pytest.mark.parametrize(("view", "cadence"), CADENCES.items())
def test_cadences_in_synch_mode(view: tuple[int, int], cadence: str) -> None:
    found = set()
    for ticks in range(8):
        world = _world(60, *view)
        world.match["see_ticks"][0, 0] = ticks % clock.see_interval(world.match, 0)
        found.add(" ".join(_cycles(world, 3)))
    assert found & _rotations(cadence)
    assert all(text.count("S") == cadence.count("S") for text in found)


@pytest.mark.parametrize(("width", "every"), [(r.NARROW, 1), (r.NORMAL, 2), (r.WIDE, 3)])
def test_synch_see_comes_with_the_step(width: int, every: int) -> None:
    world = _world(60, width)
    world.match["synch_see"][0, 0] = 1
    text = "".join(_cycles(world, 12))
    assert re.fullmatch("(bSt|bt)*", text)
    assert text.count("S") == 12 // every


def test_recorded_cadences_with_offset_80() -> None:
    ours = {" ".join(_cycles(_world(80, ticks=ticks), 3)) for ticks in range(4)}
    patterns = set().union(*(_rotations(text) for text in ours))
    recorded = json.loads((DATA / "cadence-offset-80.json").read_text())
    assert len(recorded) == 5
    for text in recorded.values():
        groups = re.findall("[Sb]+t", text)[1:]
        assert " ".join(groups[:3]) in patterns
        assert groups[3:] == groups[:-3]


def test_with_offset_90_no_see_is_late() -> None:
    for ticks in range(4):
        assert "S" not in [text[0] for text in _cycles(_world(90, ticks=ticks), 30)]


@pytest.mark.parametrize("offset", [30, 60, 80, 90])
@pytest.mark.parametrize("view", CADENCES)
def test_ticks_and_whole_cycles_are_the_same_clock(offset: int, view: tuple[int, int]) -> None:
    whole, ticking = _world(offset, *view), _world(offset, *view)
    due = np.zeros(22, dtype=np.uint8)
    text = ""
    for _ in range(100 * 12 // clock.TICK_MS):
        what = clock.tick(ticking.match, ticking.params, due)
        if what & clock.STEP_DUE:
            text += "b"
        text += "S" * due[0]
        if what & clock.THINK_DUE:
            text += "t"
    assert text == "".join(_cycles(whole, 12))
    assert whole.match["clock"][0] == ticking.match["clock"][0]


def test_visual_ticks_of_the_server_loop() -> None:
    world = _world(60, r.NARROW, r.LOW)
    world.match["clock"][0] = 0
    due = np.zeros(22, dtype=np.uint8)
    seen = []
    for ms in range(10, 310, 10):
        clock.tick(world.match, world.params, due)
        if due[0]:
            seen.append(ms)
    assert seen == [40, 80, 120, 150, 190, 230, 270, 300]


def test_fast_send_steps_give_one_see_per_loop() -> None:
    world = World("l1", send_step=20, synch_offset=60)
    world.match["width"][0, 0], world.match["quality"][0, 0] = r.NARROW, r.LOW
    due = np.zeros(22, dtype=np.uint8)
    clock.sees_before_think(world.match, world.params, due)
    assert due[0] == 7
