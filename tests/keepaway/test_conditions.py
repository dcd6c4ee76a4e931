"""What a server tells about the match it plays."""

from __future__ import annotations

import pytest

from rcss_hat.keepaway.conditions import (
    ELEVEN_ON_NINETEEN,
    SETTINGS,
    Mismatch,
    agreed,
    pace_text,
    physics_text,
)
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.params import ServerParams, Value

TASK = Task()


def told(profile: str = "19.0", version: int = 19, **changes: Value) -> dict[str, Value]:
    """What a server for the usual task tells a client of a protocol version."""
    return dict(ServerParams(profile, **{**TASK.server_values(), **changes}).for_version(version))


PHYSICS = {
    "19": (told(), "19.0"),
    "19, to our players": (told(version=11), "19.0"),
    "11": (told("11.1", 11), "11.1"),
    "19 as 11": (told(**ELEVEN_ON_NINETEEN), "11.1"),
    "bare": (told(stamina_inc_max=45.0), "other (stamina_inc_max 45)"),
    "many": (
        told(ball_decay=0.9, kick_rand=0.05, player_decay=0.5, player_rand=0.2),
        "other (ball_decay 0.9, kick_rand 0.05, player_decay 0.5, ...)",
    ),
    "size only": (told(keepaway_length=30.0, visible_angle=90.0, synch_mode=False, half_time=300), "19.0"),
}


@pytest.mark.parametrize("name", PHYSICS)
def test_whose_physics(name: str) -> None:
    parameters, text = PHYSICS[name]
    assert physics_text(parameters) == text


def test_rounded_numbers_are_the_same_numbers() -> None:
    assert physics_text(told(kick_power_rate=0.0270000001)) == "19.0"


def test_how_fast() -> None:
    assert pace_text(told()) == "synch mode"
    assert pace_text(told(synch_mode=False)) == "real time"
    assert pace_text(told(synch_mode=False, simulator_step=50)) == "real time, cycles of 50 ms"


def test_a_server_that_plays_the_task_agrees() -> None:
    assert agreed(TASK, told()) == TASK
    eleven = Task(profile="11.1")
    assert agreed(eleven, told("11.1", 11)) == eleven


def test_what_was_not_asked_for_is_the_servers() -> None:
    parameters = told("11.1", 11, keepaway_length=25.0, visible_angle=90.0)
    assert agreed(TASK, parameters, frozenset()) == Task(3, 2, 25.0, 20.0, 90, "11.1")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"keepaway": False}, "plays soccer, not Keepaway: start it with server::keepaway=1"),
        ({"visible_angle": 90.0}, "give --vision 90"),
        ({"keepaway_width": 30.0}, "give --field 20x30"),
        ({"stamina_inc_max": 45.0}, r"profile other \(stamina_inc_max 45\), not 19.0: start it with the parameters"),
        (ELEVEN_ON_NINETEEN, "give --profile 11.1"),
    ],
)
def test_a_mismatch_says_in_a_line_what_would_be_right(changes: dict[str, Value], message: str) -> None:
    with pytest.raises(Mismatch, match=message) as refusal:
        agreed(TASK, told(**changes), SETTINGS)
    assert len(str(refusal.value)) <= 150


def test_a_trainer_referees_where_the_server_does_not() -> None:
    assert agreed(TASK, told(keepaway=False), SETTINGS, refereed=True) == TASK


def test_a_region_that_is_no_task_is_refused() -> None:
    with pytest.raises(Mismatch, match="8 to 100 m long"):
        agreed(TASK, told(keepaway_length=500.0), frozenset())
