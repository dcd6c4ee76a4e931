from __future__ import annotations

from collections import Counter

import numpy as np
from simulation_samples import COMPILED, FREE, World, player

from rcss_hat.protocol import records as r
from rcss_hat.simulation import commands, cycle, hearing
from rcss_hat.simulation.hearing import HEAR_FULL, HEAR_PART, HEAR_SELF
from rcss_hat.simulation.state import (
    EAR_OTHER_COMPLETE,
    EAR_OTHER_PARTIAL,
    EAR_OWN_COMPLETE,
    EAR_OWN_PARTIAL,
    MAX_MESSAGES,
)


def say(world: World, name: str, text: str) -> bool:
    letters = np.zeros(r.SAY_SIZE, dtype=np.uint8)
    raw = text.encode()[: r.SAY_SIZE]
    letters[: len(raw)] = list(raw)
    return bool(commands.say(world.match, world.params, player(name), letters, len(text)))


def listen(world: World, name: str) -> list[tuple[str, int]]:
    """What a player hears: text and how."""
    order = np.zeros((MAX_MESSAGES, 2), dtype=np.int32)
    n = hearing.deliver(world.state, player(name), order)
    return [(_text(world, m), how) for m, how in order[:n].tolist()]


def _text(world: World, m: int) -> str:
    return bytes(world.match["heard"][0, m, : world.match["heard_n"][0, m]]).decode()


def match(players: str = "l1 l2 l3 r1 r2", **changes: float) -> World:
    world = World(players, **FREE, **changes).play().put("b", 0.0, -30.0)
    for k, name in enumerate(players.split()):
        world.put(name, 3.0 * k, 20.0)
    return world


def step(world: World) -> None:
    cycle.step(world.state)


def test_messages_are_heard_one_cycle_later_by_all_and_by_the_speaker_himself() -> None:
    world = match()
    assert say(world, "l1", "hello")
    assert listen(world, "l2") == []
    step(world)
    assert listen(world, "l1") == [("hello", HEAR_SELF)]
    assert listen(world, "l2") == [("hello", HEAR_FULL)]
    assert listen(world, "r2") == [("hello", HEAR_FULL)]
    step(world)
    assert listen(world, "l3") == []


def test_one_message_per_team_is_heard_in_full() -> None:
    world = match()
    world.match["ear_off"] = 0
    for name in ("l1", "l2", "r1", "r2"):
        say(world, name, name)
    step(world)
    heard = listen(world, "l3")
    assert len(heard) == 4
    by_team = {side: [how for text, how in heard if text[0] == side] for side in "lr"}
    assert by_team == {"l": [HEAR_FULL, HEAR_PART], "r": [HEAR_FULL, HEAR_PART]}


def test_the_order_is_random_unless_a_player_is_attended_to() -> None:
    world = match()
    first: Counter[str] = Counter()
    n = 600 if COMPILED else 60
    for attend in (False, True):
        for _ in range(n):
            if attend:
                commands.attention_to(world.match, player("l3"), r.LEFT, 2)
            say(world, "l1", "a")
            say(world, "l2", "b")
            step(world)
            heard = listen(world, "l3")
            first[f"{heard[0][0]} {attend}"] += 1
    assert abs(first["a False"] - n / 2) < 4.0 * (n / 4) ** 0.5
    assert first["b True"] == n


def test_far_away_nothing_is_heard() -> None:
    world = match().put("l2", 0.0, 20.0).put("l1", -50.5, 20.0).put("l3", -49.0, 20.0)
    say(world, "l2", "far")
    step(world)
    assert listen(world, "l1") == []
    assert listen(world, "l3") == [("far", HEAR_FULL)]


def test_range_counts_when_it_is_said() -> None:
    world = match().put("l2", 0.0, 20.0).put("l1", -40.0, 20.0)
    say(world, "l2", "near")
    world.put("l1", -57.0, 20.0)
    step(world)
    assert listen(world, "l1") == [("near", HEAR_FULL)]


def test_ears_can_be_stopped() -> None:
    for off, heard in (
        (EAR_OWN_COMPLETE, [("b", HEAR_FULL), ("b", HEAR_PART)]),
        (EAR_OWN_COMPLETE | EAR_OWN_PARTIAL, [("b", HEAR_FULL), ("b", HEAR_PART)]),
        (EAR_OTHER_COMPLETE, [("a", HEAR_FULL), ("a", HEAR_PART)]),
        (EAR_OWN_PARTIAL | EAR_OTHER_COMPLETE | EAR_OTHER_PARTIAL, [("a", HEAR_FULL)]),
    ):
        world = match()
        world.match["ear_off"][0, player("l3")] = off
        for name, text in (("l1", "a"), ("l2", "a"), ("r1", "b"), ("r2", "b")):
            say(world, name, text)
        step(world)
        assert listen(world, "l3") == heard, off


def test_long_messages_are_dropped() -> None:
    world = match()
    assert not say(world, "l1", "12345678901")
    assert say(world, "l1", "1234567890")
    assert not World(say_msg_size=5).params["say_msg_size"][0] > 5
    short = match(say_msg_size=5)
    assert not say(short, "l1", "123456")


def test_what_a_player_gets_is_what_is_delivered() -> None:
    out = r.empty(r.HEARD)
    for seed in range(20):
        worlds = [match(), match()]
        for world in worlds:
            world.streams[:] = World(seed=seed).streams
            say(world, "l1", "one")
            say(world, "l2", "two")
            say(world, "r1", "no")
            step(world)
        full = [text for text, how in listen(worlds[0], "l3") if how == HEAR_FULL and text != "no"]
        hearing.hear_teammate(worlds[1].state, player("l3"), out)
        assert bytes(out["text"][0, : out["n"][0]]).decode() == full[-1]
        assert out["unum"][0] == (1 if full[-1] == "one" else 2)
        assert out["time"][0] == 1
        assert np.array_equal(worlds[0].streams, worlds[1].streams)


def test_voices_come_from_a_direction_relative_to_the_body() -> None:
    world = match("l1 l2").put("l1", 0.0, 0.0).put("l2", 10.0, 0.0)
    world.face("l1", 29.9, 45.0)
    say(world, "l2", "x")
    step(world)
    out = r.empty(r.HEARD)
    hearing.hear_teammate(world.state, 0, out)
    assert out["direction"][0] == -29.0


def test_nothing_heard() -> None:
    world = match()
    say(world, "r1", "x")
    step(world)
    out = r.empty(r.HEARD)
    hearing.hear_teammate(world.state, 0, out)
    assert out["time"][0] == -1


def test_nobody_hears_in_part_who_has_not_asked_for_it() -> None:
    world = match()
    for name in ("l1", "l2", "r1", "r2"):
        say(world, name, name)
    step(world)
    assert [how for _, how in listen(world, "l3")] == [HEAR_FULL, HEAR_FULL]


def test_messages_beyond_the_room_are_lost_without_harm() -> None:
    world = match()
    world.match["ear_off"] = 0
    said = [say(world, "l1", "x") for _ in range(MAX_MESSAGES + 5)]
    assert said == [True] * MAX_MESSAGES + [False] * 5
    step(world)
    assert len(listen(world, "l2")) == MAX_MESSAGES
