"""Player types: type 0 has the server's parameters, the others trade strengths against weaknesses.

Source: 19.0.0, src/heteroplayer.cpp and src/playerparam.cpp. The server draws with a Mersenne Twister of its own,
seeded with ``player::random_seed``; the same numbers are drawn here, so that a seed gives the types of a real server.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from rcss_hat.protocol.landmarks import PITCH_LENGTH, PITCH_WIDTH
from rcss_hat.protocol.params import ServerParams

_PITCH_DIAGONAL = math.sqrt(PITCH_LENGTH**2 + PITCH_WIDTH**2)
_MAX_TRIALS = 1000
_EPS = 1e-10

PLAYER_TYPE = np.dtype(
    [
        ("player_speed_max", "f8"),  # m/cycle
        ("stamina_inc_max", "f8"),  # per cycle
        ("player_decay", "f8"),
        ("inertia_moment", "f8"),
        ("dash_power_rate", "f8"),
        ("player_size", "f8"),  # m
        ("kickable_margin", "f8"),  # m
        ("kick_rand", "f8"),
        ("extra_stamina", "f8"),
        ("effort_max", "f8"),
        ("effort_min", "f8"),
        # since version 14
        ("kick_power_rate", "f8"),
        ("foul_detect_probability", "f8"),
        ("catchable_area_l_stretch", "f8"),
        # since version 18: distances (m) at which detail is lost, for clients of that version
        ("unum_far_length", "f8"),
        ("unum_too_far_length", "f8"),
        ("team_far_length", "f8"),
        ("team_too_far_length", "f8"),
        ("player_max_observation_length", "f8"),
        ("ball_vel_far_length", "f8"),
        ("ball_vel_too_far_length", "f8"),
        ("ball_max_observation_length", "f8"),
        ("flag_chg_far_length", "f8"),
        ("flag_chg_too_far_length", "f8"),
        ("flag_max_observation_length", "f8"),
        # since version 19
        ("dist_noise_rate", "f8"),
        ("focus_dist_noise_rate", "f8"),
        ("land_dist_noise_rate", "f8"),
        ("land_focus_dist_noise_rate", "f8"),
    ]
)
"""A player type; the fields in the order of the player_type message."""

PLAYER_PARAMETERS: dict[str, tuple[float, float]] = {
    "allow_mult_default_type": (0, 0),
    "catchable_area_l_stretch_max": (1.3, 1.0),
    "catchable_area_l_stretch_min": (1.0, 1.0),
    "dash_power_rate_delta_max": (0, 0),
    "dash_power_rate_delta_min": (0, 0),
    "effort_max_delta_factor": (-0.004, -0.002),
    "effort_min_delta_factor": (-0.004, -0.002),
    "extra_stamina_delta_max": (50, 100),
    "extra_stamina_delta_min": (0, 0),
    "foul_detect_probability_delta_factor": (0, 0),
    "inertia_moment_delta_factor": (25, 25),
    "kick_power_rate_delta_max": (0, 0),
    "kick_power_rate_delta_min": (0, 0),
    "kick_rand_delta_factor": (1, 0.5),
    "kickable_margin_delta_max": (0.1, 0.2),
    "kickable_margin_delta_min": (-0.1, 0),
    "new_dash_power_rate_delta_max": (0.0008, 0.002),
    "new_dash_power_rate_delta_min": (-0.0012, 0),
    "new_stamina_inc_max_delta_factor": (-6000, -10000),
    "player_decay_delta_max": (0.1, 0.2),
    "player_decay_delta_min": (-0.1, 0),
    "player_size_delta_factor": (-100, -100),
    "player_speed_max_delta_max": (0, 0),
    "player_speed_max_delta_min": (0, 0),
    "player_types": (18, 7),
    "pt_max": (1, 3),
    "random_seed": (-1, -1),
    "stamina_inc_max_delta_factor": (0, 0),
    "subs_max": (3, 3),
}
"""Default of every ``player::`` parameter in version 19.0.0 and in 11.1.2."""


class _Twister:
    """``mt19937`` with ``std::uniform_real_distribution<double>``, or, as in 11.1, with ``boost::uniform_real``.

    Parameters
    ----------
    seed : int
    one_word : bool
        Draw as 11.1 does, from one word of 32 bits instead of two.
    """

    def __init__(self, seed: int, one_word: bool = False) -> None:
        self._one_word = one_word
        key = np.zeros(624, dtype=np.uint32)
        word = seed & 0xFFFFFFFF
        for k in range(624):
            key[k] = word
            word = (1812433253 * (word ^ (word >> 30)) + k + 1) & 0xFFFFFFFF
        self._bits = np.random.MT19937()
        self._bits.state = {"bit_generator": "MT19937", "state": {"key": key, "pos": 624}}

    def uniform(self, low: float, high: float) -> float:
        """Draw from U[low, high); no draw when both are the same."""
        if low == high:
            return low
        low, high = min(low, high), max(low, high)
        if self._one_word:
            return float(self._bits.random_raw()) / (2.0**32 - 1.0) * (high - low) + low
        first, second = (float(word) for word in self._bits.random_raw(2))
        unit = min((first + second * 2.0**32) / 2.0**64, math.nextafter(1.0, 0.0))
        return unit * (high - low) + low


def player_parameters(params: ServerParams) -> dict[str, float]:
    """Return the ``player::`` parameters of the profile of some server parameters."""
    column = 0 if params.profile == "19.0" else 1
    return {name: values[column] for name, values in PLAYER_PARAMETERS.items()}


def player_types(params: ServerParams, seed: int, player_params: Mapping[str, float] | None = None) -> NDArray[np.void]:
    """Make the player types of a server.

    Parameters
    ----------
    params : ServerParams
    seed : int
        ``player::random_seed``.
    player_params : mapping, optional
        ``player::`` parameters that differ from the default.

    Returns
    -------
    ndarray of PLAYER_TYPE, shape (n,)
        n is ``player_types``: 18 in version 19.0, 7 in 11.1. Entry 0 has the server's parameters.
    """
    settings = player_parameters(params) | dict(player_params or {})
    twister = _Twister(seed, one_word=params.profile == "11.1")
    types = np.zeros(int(settings["player_types"]), dtype=PLAYER_TYPE)
    for k in range(len(types)):
        values = default_type(params)
        if k > 0:
            values |= _draw(params, settings, twister)
        for name, value in values.items():
            types[name][k] = value
    return types


def default_type(params: ServerParams) -> dict[str, float]:
    """Return the fields of type 0."""
    number = params.number
    return {
        "player_speed_max": number("player_speed_max"),
        "stamina_inc_max": number("stamina_inc_max"),
        "player_decay": number("player_decay"),
        "inertia_moment": number("inertia_moment"),
        "dash_power_rate": number("dash_power_rate"),
        "player_size": number("player_size"),
        "kickable_margin": number("kickable_margin"),
        "kick_rand": number("kick_rand"),
        "extra_stamina": number("extra_stamina"),
        "effort_max": number("effort_init"),
        "effort_min": number("effort_min"),
        "kick_power_rate": number("kick_power_rate"),
        "foul_detect_probability": number("foul_detect_probability"),
        "catchable_area_l_stretch": 1.0,
        "unum_far_length": 20.0,
        "unum_too_far_length": 40.0,
        "team_far_length": _PITCH_DIAGONAL,
        "team_too_far_length": _PITCH_DIAGONAL,
        "player_max_observation_length": _PITCH_DIAGONAL,
        "ball_vel_far_length": 20.0,
        "ball_vel_too_far_length": 40.0,
        "ball_max_observation_length": _PITCH_DIAGONAL,
        "flag_chg_far_length": 20.0,
        "flag_chg_too_far_length": 40.0,
        "flag_max_observation_length": _PITCH_DIAGONAL,
        "dist_noise_rate": number("dist_noise_rate"),
        "focus_dist_noise_rate": number("focus_dist_noise_rate"),
        "land_dist_noise_rate": number("land_dist_noise_rate"),
        "land_focus_dist_noise_rate": number("land_focus_dist_noise_rate"),
    }


def _draw(params: ServerParams, settings: Mapping[str, float], twister: _Twister) -> dict[str, float]:
    """Draw one type; type 0 again when no trial gives a player of a fair top speed."""
    old = params.profile == "11.1"
    for _ in range(_MAX_TRIALS):
        values = _trial(params, settings, twister)
        if values is None:
            continue
        if old:
            if not _faster_for_less(params, values):
                return values
            continue
        top_speed = params.number("maxpower") * values["dash_power_rate"] * values["effort_max"]
        top_speed /= 1.0 - values["player_decay"]
        if params.number("player_speed_max_min") - _EPS < top_speed < values["player_speed_max"] + _EPS:
            return values
    return default_type(params)


def _faster_for_less(params: ServerParams, values: dict[str, float]) -> bool:
    """Tell whether a player is faster than the default one and needs less stamina for it: 11.1 refuses those only."""

    def consumption(of: dict[str, float]) -> float:
        return of["player_speed_max"] * (1.0 - of["player_decay"]) / of["dash_power_rate"] - of["stamina_inc_max"]

    default = default_type(params)
    return values["player_speed_max"] > default["player_speed_max"] and consumption(values) < consumption(default)


def _trial(params: ServerParams, settings: Mapping[str, float], twister: _Twister) -> dict[str, float] | None:
    """Draw one candidate, None when a value leaves its range (not in 11.1). The order of draws is the server's."""
    old = params.profile == "11.1"
    number = params.number
    values: dict[str, float] = {}

    def trade(name: str, fields: dict[str, tuple[str, float]], allow_zero: frozenset[str] = frozenset()) -> bool:
        delta = twister.uniform(settings[f"{name}_delta_min"], settings[f"{name}_delta_max"])
        for field, (base, factor) in fields.items():
            values[field] = number(base) + delta * factor
            if not old and (values[field] < 0.0 or (values[field] == 0.0 and field not in allow_zero)):
                return False
        return True

    if not trade(
        "player_speed_max",
        {
            "player_speed_max": ("player_speed_max", 1.0),
            "stamina_inc_max": ("stamina_inc_max", settings["stamina_inc_max_delta_factor"]),
        },
    ):
        return None
    if not trade(
        "player_decay",
        {
            "player_decay": ("player_decay", 1.0),
            "inertia_moment": ("inertia_moment", settings["inertia_moment_delta_factor"]),
        },
        frozenset({"inertia_moment"}),
    ):
        return None
    if not trade(
        "dash_power_rate",
        {
            "dash_power_rate": ("dash_power_rate", 1.0),
            "player_size": ("player_size", settings["player_size_delta_factor"]),
        },
    ):
        return None
    if not trade(
        "new_dash_power_rate",
        {
            "dash_power_rate": ("dash_power_rate", 1.0),
            "stamina_inc_max": ("stamina_inc_max", settings["new_stamina_inc_max_delta_factor"]),
        },
    ):
        return None
    if not trade(
        "kickable_margin",
        {
            "kickable_margin": ("kickable_margin", 1.0),
            "kick_rand": ("kick_rand", settings["kick_rand_delta_factor"]),
        },
        frozenset({"kick_rand"}),
    ):
        return None
    if not trade(
        "extra_stamina",
        {
            "extra_stamina": ("extra_stamina", 1.0),
            "effort_max": ("effort_init", settings["effort_max_delta_factor"]),
            "effort_min": ("effort_min", settings["effort_min_delta_factor"]),
        },
        frozenset({"extra_stamina"}),
    ):
        return None
    delta = twister.uniform(settings["kick_power_rate_delta_min"], settings["kick_power_rate_delta_max"])
    values["kick_power_rate"] = number("kick_power_rate") + delta
    values["foul_detect_probability"] = (
        number("foul_detect_probability") + delta * settings["foul_detect_probability_delta_factor"]
    )
    values["catchable_area_l_stretch"] = twister.uniform(
        settings["catchable_area_l_stretch_min"], settings["catchable_area_l_stretch_max"]
    )
    return values
