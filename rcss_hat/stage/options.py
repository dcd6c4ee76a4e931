"""The server options that make a server play a Keepaway task."""

from __future__ import annotations

import re

from rcss_hat.keepaway.conditions import CYCLE_MS, ELEVEN_ON_NINETEEN
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.params import Value

TICK_MS = 10
"""Of a server's loop in real time."""
SHORTEST_TICKS = 2
TOLERANCE = 0.01
"""Relative deviation of a pace that nobody notices."""
_PLAIN_TEXT = re.compile(r"(?!//|on|off|true|false)[A-Za-z._~/][^\s:\"'=]*", re.IGNORECASE)
"""Texts that rcssserver reads without quotes; others it takes for numbers, switches, comments or the next parameter."""
REFEREED_BY_TRAINER: dict[str, Value] = {"keepaway": False, "coach": True}
"""Changes for a server whose referee is a trainer of ours."""


def option(name: str, value: Value) -> str:
    """Write a server option: ``server::name=value``."""
    if isinstance(value, bool):
        value = int(value)
    return f"server::{name}={value:g}" if isinstance(value, float) else f"server::{name}={value}"


def _arguments(name: str, value: Value) -> list[str]:
    """Return the arguments that set a parameter; rcssserver takes blanks only in an argument that is all quoted."""
    if not isinstance(value, str) or _PLAIN_TEXT.fullmatch(value):
        return [option(name, value)]
    escaped = value.replace("'", "\\'")
    return [f"server::{name}=", f"'{escaped}'"]


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
        values.update(ELEVEN_ON_NINETEEN)
    values.update({"game_logging": False, "text_logging": False})
    values.update(changes)
    options = [argument for name, value in values.items() for argument in _arguments(name, value)]
    return options if real else [f"--profile={task.profile}", *options]
