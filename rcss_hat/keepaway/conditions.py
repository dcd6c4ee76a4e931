"""What a server tells about the match it plays (``server_param``), and whether that is the task."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import replace

from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.params import KERNEL_PARAMETERS, PROFILES, ServerParams, Value

SETTINGS: frozenset[str] = frozenset({"field", "vision", "profile"})
"""What a task and a server can disagree about, as the command line calls it."""
OTHER = "other"
CYCLE_MS = 100
_TASKS_OWN = frozenset(
    {
        "half_time", "nr_normal_halfs", "nr_extra_halfs", "extra_half_time", "golden_goal", "use_offside",
        "forbid_kick_off_offside", "keepaway", "keepaway_length", "keepaway_width", "synch_mode", "synch_offset",
        "synch_see_offset", "simulator_step", "send_step", "visible_angle", "drop_ball_time", "goalie_max_moves",
        "catch_ban_cycle", "catch_probability", "catchable_area_l", "catchable_area_w", "min_catch_angle",
        "max_catch_angle", "say_msg_size",
    }
)  # fmt: skip
"""Kernel parameters that are no physics, or that Keepaway never comes to."""
PHYSICS: tuple[str, ...] = tuple(name for name in KERNEL_PARAMETERS if name not in _TASKS_OWN)
ELEVEN_ON_NINETEEN: dict[str, Value] = {
    "ball_speed_max": 2.7,
    "kick_rand": 0.0,
    "player_speed_max": 1.2,
    "player_speed_max_min": 0.8,
    "stamina_max": 4000.0,
}
"""Server 19 with these behaves like 11.1 but for the shape of the motion noise (measured, see the reference)."""
_TOLD_DIGITS = 1e-4
"""Relative precision of what servers tell."""
_MOST_NAMED = 3
Told = Mapping[str, Value]
"""Parameters by name, as ``(server_param ...)`` told them; possibly not all."""


class Mismatch(ValueError):
    """A server does not play the task; the message says in one line what would be right."""


def _differing(told: Told, expected: Mapping[str, Value]) -> dict[str, Value]:
    def same(mine: Value, theirs: Value) -> bool:
        return abs(float(mine) - float(theirs)) <= _TOLD_DIGITS * max(abs(float(mine)), 1e-3)

    return {name: told[name] for name in PHYSICS if name in told and not same(expected[name], told[name])}


def physics(told: Told) -> tuple[str, dict[str, Value]]:
    """Name the physics of a server.

    Returns
    -------
    str
        ``"19.0"``, ``"11.1"`` (of a server 11.1, or of 19 with the parameters that make it alike), or ``"other"``.
    dict
        For ``"other"``: the parameters that differ from the profile with the fewest differences.
    """
    plays: Mapping[str, Value] = {"stamina_inc_max": Task().server_values()["stamina_inc_max"]}
    candidates: list[tuple[str, Mapping[str, Value]]] = [
        (profile, {**ServerParams(profile), **plays}) for profile in PROFILES
    ]
    candidates.append(("11.1", {**ServerParams("19.0"), **plays, **ELEVEN_ON_NINETEEN}))
    found = [(name, _differing(told, expected)) for name, expected in candidates]
    name, differing = min(found, key=lambda pair: len(pair[1]))
    return (OTHER, differing) if differing else (name, {})


def physics_text(told: Told) -> str:
    """Write the physics of a server: ``19.0``, or ``other (kick_rand 0.05, ...)``."""
    name, differing = physics(told)
    if not differing:
        return name
    shown = [f"{name} {value:g}" for name, value in list(differing.items())[:_MOST_NAMED]]
    more = ["..."] if len(differing) > _MOST_NAMED else []
    return f"{OTHER} ({', '.join(shown + more)})"


def pace_text(told: Told) -> str:
    """Write how fast a server plays: ``synch mode``, ``real time``, or ``real time, cycles of 50 ms``."""
    if told.get("synch_mode"):
        return "synch mode"
    step = told.get("simulator_step", CYCLE_MS)
    return "real time" if step == CYCLE_MS else f"real time, cycles of {step:g} ms"


def agreed(task: Task, told: Told, typed: Set[str] = SETTINGS, refereed: bool = False) -> Task:
    """Return the task a server plays.

    Parameters
    ----------
    task : Task
        What was asked for.
    told : mapping of str to Value
        The server's parameters.
    typed : set of str
        Which of `SETTINGS` somebody asked for; the others are the server's.
    refereed : bool
        A trainer referees instead of the server.

    Returns
    -------
    Task

    Raises
    ------
    Mismatch
        When the server does not play Keepaway, or something else than what was asked for.
    """
    if not refereed and "keepaway" in told and not told["keepaway"]:
        raise Mismatch(
            "the server plays soccer, not Keepaway: start it with server::keepaway=1, or with server::coach=1 for "
            "--referee trainer"
        )
    region = float(told.get("keepaway_length", task.length)), float(told.get("keepaway_width", task.width))
    vision = float(told.get("visible_angle", task.vision))
    profile, _ = physics(told)
    wanted = {
        "field": (task.field, f"{region[0]:g}x{region[1]:g}"),
        "vision": (f"{task.vision:g}", f"{vision:g}"),
        "profile": (task.profile, profile),
    }
    for setting, (asked, plays) in wanted.items():
        if setting in typed and asked != plays:
            remedy = f"give --{setting} {plays}" if plays != OTHER else "start it with the parameters of a profile"
            detail = physics_text(told) if setting == "profile" else plays
            raise Mismatch(f"the server plays {setting} {detail}, not {asked}: {remedy}, or use another server")
    try:
        return replace(
            task,
            length=region[0],
            width=region[1],
            vision=round(vision),
            profile=task.profile if profile == OTHER else profile,
        )
    except ValueError as error:
        raise Mismatch(f"the server plays no task known here: {error}") from None
