"""The server options that make a server play a Keepaway task."""

from __future__ import annotations

from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.params import Value

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
