"""Player parameters: the table of what ``player::name=value`` may set and what ``(player_param ...)`` tells clients."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from rcss_hat.protocol.params import PROFILES, Parameter, Value, checked
from rcss_hat.simulation.player_types import PLAYER_PARAMETERS as DEFAULTS

_KINDS: dict[str, type] = {
    "allow_mult_default_type": bool, "player_types": int, "pt_max": int, "random_seed": int, "subs_max": int,
}  # fmt: skip
"""The others are numbers."""
_SINCE = {
    "allow_mult_default_type": 12, "catchable_area_l_stretch_max": 14, "catchable_area_l_stretch_min": 14,
    "foul_detect_probability_delta_factor": 14, "kick_power_rate_delta_max": 14, "kick_power_rate_delta_min": 14,
    "new_dash_power_rate_delta_max": 8, "new_dash_power_rate_delta_min": 8, "new_stamina_inc_max_delta_factor": 8,
    "random_seed": 8,
}  # fmt: skip
"""First protocol version whose player_param message contains them; the others are as old as the message, 7."""


def _parameter(name: str, defaults: tuple[float, float]) -> Parameter:
    kind = _KINDS.get(name, float)
    return Parameter(name, kind, kind(defaults[0]), kind(defaults[1]), _SINCE.get(name, 7))


PLAYER_PARAMETERS: tuple[Parameter, ...] = tuple(
    _parameter(name, defaults) for name, defaults in sorted(DEFAULTS.items())
)
"""All player parameters, in byte order of their names (19.0.0 and 11.1.2, src/playerparam)."""

BY_NAME: dict[str, Parameter] = {parameter.name: parameter for parameter in PLAYER_PARAMETERS}


class PlayerParams(Mapping[str, Value]):
    """The player parameters of one server.

    Parameters
    ----------
    profile : {"19.0", "11.1"}
        Whose defaults to start from.
    **changes : Value
        Parameters that differ from the default.

    Raises
    ------
    KeyError
        For a name that no server knows.
    TypeError
        For a value of the wrong kind.
    """

    def __init__(self, profile: str = "19.0", **changes: Value) -> None:
        if profile not in PROFILES:
            raise ValueError(f"unknown profile {profile!r}; known are {', '.join(PROFILES)}")
        self._values: dict[str, Value] = {
            name: _KINDS.get(name, float)(defaults[PROFILES.index(profile)]) for name, defaults in DEFAULTS.items()
        }
        for name, value in changes.items():
            self.set(name, value)

    def set(self, name: str, value: Value) -> None:
        """Change one parameter."""
        if name not in BY_NAME:
            raise KeyError(f"unknown player parameter {name!r}")
        self._values[name] = checked(BY_NAME[name], value)

    def __getitem__(self, name: str) -> Value:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def numbers(self) -> dict[str, float]:
        """Return all of them as numbers, for the player types."""
        return {name: float(value) for name, value in self._values.items()}

    def for_version(self, version: int) -> Iterable[tuple[str, Value]]:
        """Yield name and value of what a client of a protocol version is told, in byte order of the names."""
        for parameter in PLAYER_PARAMETERS:
            if parameter.since is not None and parameter.since <= version:
                yield parameter.name, self._values[parameter.name]
