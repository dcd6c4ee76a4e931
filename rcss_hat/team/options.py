"""The server options that make a server play a Keepaway task."""

from __future__ import annotations

from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.params import Value

CYCLE_MS = 100
TICK_MS = 10
"""Of a server's loop in real time."""
SHORTEST_TICKS = 2
TOLERANCE = 0.01
"""Relative deviation of a pace that nobody notices."""
# Server 19 with these behaves like 11.1 but for the shape of the motion noise (measured, see the reference).
_ELEVEN_ON_NINETEEN: dict[str, Value] = {
    "ball_speed_max": 2.7,
    "kick_rand": 0.0,
    "player_speed_max": 1.2,
    "player_speed_max_min": 0.8,
    "stamina_max": 4000.0,
}
REFEREED_BY_TRAINER: dict[str, Value] = {"keepaway": False, "coach": True}
"""Changes for a server whose referee is a trainer of ours."""


def option(name: str, value: Value) -> str:
    """Write a server option: ``server::name=value``."""
    if isinstance(value, bool):
        value = int(value)
    return f"server::{name}={value:g}" if isinstance(value, float) else f"server::{name}={value}"


def pace_options(speed: float) -> dict[str, Value]:
    """Return the parameters that let a server play so many times faster than real time.

    Servers look at their clocks every 10 ms, so a cycle is a multiple of that. With cycles of 10 ms there would be no
    time to see and to act within a cycle.

    Parameters
    ----------
    speed : float
        Times real time, which has cycles of 100 ms.

    Raises
    ------
    ValueError
        Naming the nearest speeds there are.
    """
    wanted = CYCLE_MS / speed
    step = TICK_MS * max(round(wanted / TICK_MS), SHORTEST_TICKS)
    if abs(step / wanted - 1.0) > TOLERANCE:
        around = sorted({max(int(wanted // TICK_MS) + k, SHORTEST_TICKS) for k in (0, 1)}, reverse=True)
        speeds = " or ".join(f"{CYCLE_MS / TICK_MS / ticks:.3g}" for ticks in around)
        raise ValueError(
            f"servers cannot play {speed:g} times as fast: their cycles are multiples of {TICK_MS} ms, from "
            f"{SHORTEST_TICKS * TICK_MS} ms; try {speeds}"
        )
    if step == CYCLE_MS:
        return {}
    return {
        "simulator_step": step,
        "sense_body_step": step,
        "send_step": step * 3 // 2,  # as 150 to 100
        "recv_step": min(step // 10, TICK_MS),
    }


def server_options(task: Task, *, real: bool, **changes: Value) -> list[str]:
    """Return the command line of a server for a task.

    Parameters
    ----------
    task : Task
    real : bool
        For the original, which has no profiles: profile 11.1 is then approximated by parameters.
    **changes : Value
        Further parameters, for example ``port=6000``.
    """
    values = task.server_values()
    if real and task.profile == "11.1":
        values.update(_ELEVEN_ON_NINETEEN)
    values.update({"game_logging": False, "text_logging": False})
    values.update(changes)
    options = [option(name, value) for name, value in values.items()]
    return options if real else [f"--profile={task.profile}", *options]
