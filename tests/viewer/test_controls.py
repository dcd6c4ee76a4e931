from __future__ import annotations

import pytest

from rcss_hat.viewer.controls import KeyChannel
from rcss_hat.viewer.frames import Frame
from rcss_hat.viewer.narrator import make_frame
from rcss_hat.viewer.situation import around, state_variables

from .audience import SETUP, player, snapshot

FIELD = {"l1": (-7.0, -7.0), "l2": (7.0, -7.0), "l3": (7.0, 8.0), "r1": (-7.0, 7.0), "r2": (-6.0, 7.0)}
AT_L1, AT_L2, LOOSE = (-6.5, -7.0), (6.5, -7.0), (0.0, -7.0)
STATE = [0.0] * 13
"""Of a keeper whose own order of team mates does not matter here."""


def frame(time: int, ball: tuple[float, float] = AT_L1) -> Frame:
    return make_frame(snapshot(time, ball, **FIELD), SETUP, 1, 0)


def test_no_key_is_hold() -> None:
    keys = KeyChannel()
    keys.observe(frame(1))
    assert [keys.take(1, cycle, STATE) for cycle in (1, 2, 3)] == [0, 0, 0]
    assert keys.taken is None


def test_a_key_is_taken_up_once_by_the_keeper_with_the_ball() -> None:
    keys = KeyChannel()
    keys.observe(frame(1))
    assert keys.press(2)
    assert keys.take(3, 2, STATE) == 0
    assert keys.take(1, 2, STATE) == 2
    assert keys.taken == (2, 2)
    assert keys.take(1, 3, STATE) == 0


def test_the_last_key_counts_and_hold_takes_it_back() -> None:
    keys = KeyChannel()
    keys.observe(frame(1))
    keys.press(1)
    keys.press(2)
    shown = frame(2)
    keys.observe(shown)
    assert shown["pending"] == 2
    assert keys.take(1, 2, STATE) == 2
    keys.press(1)
    assert keys.press(0)
    assert keys.take(1, 3, STATE) == 0


def test_a_key_dies_with_the_possession_it_was_pressed_in() -> None:
    """A second press for a pass on its way must not make the receiver pass at once."""
    keys = KeyChannel()
    keys.observe(frame(1))
    keys.press(1)
    assert keys.take(1, 1, STATE) == 1
    keys.press(1)
    keys.observe(frame(2, LOOSE))
    assert keys.pending is None
    keys.observe(frame(3, AT_L2))
    assert keys.take(2, 3, STATE) == 0


@pytest.mark.parametrize(("cycle", "action"), [(10, 1), (15, 1), (16, 0)])
def test_a_key_before_the_ball_arrives_waits_some_cycles(cycle: int, action: int) -> None:
    keys = KeyChannel(grace=5)
    keys.observe(frame(10, LOOSE))
    keys.press(1)
    assert keys.take(2, cycle, STATE) == action


def test_a_waiting_key_lapses_in_the_picture_too() -> None:
    keys = KeyChannel(grace=5)
    keys.observe(frame(10, LOOSE))
    keys.press(1)
    for time in range(11, 17):
        shown = frame(time, LOOSE)
        keys.observe(shown)
        assert shown["pending"] == (1 if time <= 15 else None)


def test_only_allowed_actions_are_offered_and_taken() -> None:
    keys = KeyChannel(actions=(0, 1))
    shown = frame(1)
    keys.observe(shown)
    assert [c["name"] for c in shown["choices"]] == ["PASS1"]
    assert not keys.press(2) and not keys.press(7) and not keys.press_mate("l3")
    assert keys.pending is None
    assert keys.press_mate("l2")
    assert keys.take(1, 1, STATE) == 1


def test_a_team_mate_is_meant_whatever_number_the_keeper_gives_him() -> None:
    """l2 is a little nearer than l3; the keeper believes it to be the other way round when it decides."""
    keys = KeyChannel()
    keys.observe(frame(1))
    assert keys.press_mate("l2")
    me = player("l1", *FIELD["l1"])
    believed = [player("l2", 16.0, -7.0), *(player(n, *FIELD[n]) for n in ("l3", "r1", "r2"))]
    state = state_variables(around(me, [me, *believed], None))
    assert state is not None
    assert keys.take(1, 2, state) == 2
    keys.press(1)
    assert keys.take(1, 3, state) == 1


def test_a_team_mate_who_got_the_ball_himself_is_no_target() -> None:
    keys = KeyChannel()
    keys.observe(frame(1, LOOSE))
    keys.press_mate("l2")
    keys.observe(frame(2, AT_L2))
    assert keys.take(2, 2, STATE) == 0
    assert not keys.press_mate("l2") and not keys.press_mate("r1") and not keys.press_mate("")


@pytest.mark.parametrize("actions", [(), (0,), (-1, 1), ("pass1",)])
def test_actions_must_be_hold_and_passes(actions: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="at least one pass"):
        KeyChannel(actions)


def seen(keys: KeyChannel, time: int, ball: tuple[float, float] = AT_L1) -> int | None:
    """What a frame says of a key that came too late."""
    shown = frame(time, ball)
    keys.observe(shown)
    return shown["lapsed"]


def test_a_key_that_nobody_took_up_is_shown_for_a_while() -> None:
    keys = KeyChannel()
    assert seen(keys, 1) is None
    keys.press(2)
    assert [seen(keys, 2, LOOSE), seen(keys, 9, LOOSE), seen(keys, 10, LOOSE)] == [2, 2, None]
    keys.press(1)
    assert [seen(keys, 15, LOOSE), seen(keys, 16, LOOSE)] == [None, 1], "it waited for a keeper"
    assert seen(keys, 3) is None, "another match"


def test_keys_that_were_played_or_taken_back_do_not_lapse() -> None:
    keys = KeyChannel()
    seen(keys, 1)
    keys.press(2)
    keys.press(0)
    assert seen(keys, 2, LOOSE) is None
    seen(keys, 20)
    keys.press(1)
    assert keys.take(1, 20, STATE) == 1
    keys.press(1)  # once more for the same pass
    assert seen(keys, 21, LOOSE) is None and keys.pending is None
    assert keys.presses == 4
