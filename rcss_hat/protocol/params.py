"""Server parameters: the table of all of them, their values in two profiles, and the record the kernels read."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Value = bool | int | float | str


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter of the server.

    Attributes
    ----------
    name : str
    kind : type
        ``bool``, ``int``, ``float`` or ``str``.
    default : Value
        In version 19.0.0.
    default_11 : Value or None
        In version 11.1.2; None where it did not exist.
    since : int or None
        First protocol version whose server_param message contains it; None: only monitors get it.
    """

    name: str
    kind: type
    default: Value
    default_11: Value | None
    since: int | None


SERVER_PARAMETERS: tuple[Parameter, ...] = (
    Parameter("audio_cut_dist", float, 50.0, 50.0, 7),
    Parameter("auto_mode", bool, False, False, 9),
    Parameter("back_dash_rate", float, 0.7, None, 13),
    Parameter("back_passes", bool, True, True, 8),
    Parameter("ball_accel_max", float, 2.7, 2.7, 7),
    Parameter("ball_decay", float, 0.94, 0.94, 7),
    Parameter("ball_rand", float, 0.05, 0.05, 7),
    Parameter("ball_size", float, 0.085, 0.085, 7),
    Parameter("ball_speed_max", float, 3.0, 2.7, 7),
    Parameter("ball_stuck_area", float, 3.0, 3.0, 11),
    Parameter("ball_weight", float, 0.2, 0.2, 7),
    Parameter("catch_ban_cycle", int, 5, 5, 7),
    Parameter("catch_probability", float, 1.0, 1.0, 7),
    Parameter("catchable_area_l", float, 1.2, 2.0, 7),
    Parameter("catchable_area_w", float, 1.0, 1.0, 7),
    Parameter("ckick_margin", float, 1.0, 1.0, 7),
    Parameter("clang_advice_win", int, 1, 1, 7),
    Parameter("clang_define_win", int, 1, 1, 7),
    Parameter("clang_del_win", int, 1, 1, 8),
    Parameter("clang_info_win", int, 1, 1, 7),
    Parameter("clang_mess_delay", int, 50, 50, 7),
    Parameter("clang_mess_per_cycle", int, 1, 1, 7),
    Parameter("clang_meta_win", int, 1, 1, 7),
    Parameter("clang_rule_win", int, 1, 1, 8),
    Parameter("clang_win_size", int, 300, 300, 7),
    Parameter("coach", bool, False, False, 7),
    Parameter("coach_msg_file", str, "", "", None),
    Parameter("coach_port", int, 6001, 6001, 8),
    Parameter("coach_w_referee", bool, False, False, 7),
    Parameter("connect_wait", int, 300, 300, 9),
    Parameter("control_radius", float, 2.0, 2.0, 7),
    Parameter("dash_angle_step", float, 1.0, None, 13),
    Parameter("dash_power_rate", float, 0.006, 0.006, 7),
    Parameter("dist_noise_rate", float, 0.0125, None, 19),
    Parameter("drop_ball_time", int, 100, 200, 7),
    Parameter("effort_dec", float, 0.005, 0.005, 7),
    Parameter("effort_dec_thr", float, 0.3, 0.3, 7),
    Parameter("effort_inc", float, 0.01, 0.01, 7),
    Parameter("effort_inc_thr", float, 0.6, 0.6, 7),
    Parameter("effort_init", float, 1.0, 1.0, 7),
    Parameter("effort_min", float, 0.6, 0.6, 7),
    Parameter("extra_half_time", int, 100, None, 13),
    Parameter("extra_stamina", float, 50.0, None, 12),
    Parameter("fixed_teamname_l", str, "", None, 16),
    Parameter("fixed_teamname_r", str, "", None, 16),
    Parameter("focus_dist_noise_rate", float, 0.0125, None, 19),
    Parameter("forbid_kick_off_offside", bool, True, True, 7),
    Parameter("foul_cycles", int, 5, None, 14),
    Parameter("foul_detect_probability", float, 0.5, None, 14),
    Parameter("foul_exponent", float, 10.0, None, 14),
    Parameter("free_kick_faults", bool, True, True, 8),
    Parameter("freeform_send_period", int, 20, 20, 8),
    Parameter("freeform_wait_period", int, 600, 600, 8),
    Parameter("fullstate_l", bool, False, False, 7),
    Parameter("fullstate_r", bool, False, False, 7),
    Parameter("game_log_compression", int, 0, 0, 8),
    Parameter("game_log_dated", bool, True, True, 8),
    Parameter("game_log_dir", str, "./", "./", 8),
    Parameter("game_log_fixed", bool, False, False, 8),
    Parameter("game_log_fixed_name", str, "rcssserver", "rcssserver", 8),
    Parameter("game_log_version", int, 6, 3, 8),
    Parameter("game_logging", bool, True, True, 8),
    Parameter("game_over_wait", int, 100, 100, 9),
    Parameter("goal_width", float, 14.02, 14.02, 7),
    Parameter("goalie_max_moves", int, 2, 2, 7),
    Parameter("golden_goal", bool, False, None, 14),
    Parameter("half_time", int, 300, 300, 7),
    Parameter("hear_decay", int, 1, 1, 7),
    Parameter("hear_inc", int, 1, 1, 7),
    Parameter("hear_max", int, 1, 1, 7),
    Parameter("illegal_defense_dist_x", float, 16.5, None, 16),
    Parameter("illegal_defense_duration", int, 20, None, 16),
    Parameter("illegal_defense_number", int, 0, None, 16),
    Parameter("illegal_defense_width", float, 40.32, None, 16),
    Parameter("inertia_moment", float, 5.0, 5.0, 7),
    Parameter("keepaway", bool, False, False, 9),
    Parameter("keepaway_length", float, 20.0, 20.0, 9),
    Parameter("keepaway_log_dated", bool, True, True, 9),
    Parameter("keepaway_log_dir", str, "./", "./", 9),
    Parameter("keepaway_log_fixed", bool, False, False, 9),
    Parameter("keepaway_log_fixed_name", str, "rcssserver", "rcssserver", 9),
    Parameter("keepaway_logging", bool, True, True, 9),
    Parameter("keepaway_start", int, -1, -1, 9),
    Parameter("keepaway_width", float, 20.0, 20.0, 9),
    Parameter("kick_off_wait", int, 100, 100, 9),
    Parameter("kick_power_rate", float, 0.027, 0.027, 7),
    Parameter("kick_rand", float, 0.1, 0.0, 7),
    Parameter("kick_rand_factor_l", float, 1.0, 1.0, 7),
    Parameter("kick_rand_factor_r", float, 1.0, 1.0, 7),
    Parameter("kickable_margin", float, 0.7, 0.7, 7),
    Parameter("land_dist_noise_rate", float, 0.00125, None, 19),
    Parameter("land_focus_dist_noise_rate", float, 0.00125, None, 19),
    Parameter("landmark_file", str, "~/.rcssserver-landmark.xml", "~/.rcssserver-landmark.xml", 8),
    Parameter("log_date_format", str, "%Y%m%d%H%M%S-", "%Y%m%d%H%M-", 8),
    Parameter("log_times", bool, False, False, 8),
    Parameter("max_back_tackle_power", float, 0.0, None, 12),
    Parameter("max_catch_angle", float, 90.0, None, 17),
    Parameter("max_dash_angle", float, 180.0, None, 13),
    Parameter("max_dash_power", float, 100.0, None, 13),
    Parameter("max_goal_kicks", int, 3, 3, 8),
    Parameter("max_monitors", int, -1, None, None),
    Parameter("max_tackle_power", float, 100.0, None, 12),
    Parameter("maxmoment", float, 180.0, 180.0, 7),
    Parameter("maxneckang", float, 90.0, 90.0, 7),
    Parameter("maxneckmoment", float, 180.0, 180.0, 7),
    Parameter("maxpower", float, 100.0, 100.0, 7),
    Parameter("min_catch_angle", float, -90.0, None, 17),
    Parameter("min_dash_angle", float, -180.0, None, 13),
    Parameter("min_dash_power", float, 0.0, None, 13),
    Parameter("minmoment", float, -180.0, -180.0, 7),
    Parameter("minneckang", float, -90.0, -90.0, 7),
    Parameter("minneckmoment", float, -180.0, -180.0, 7),
    Parameter("minpower", float, -100.0, -100.0, 7),
    Parameter("nr_extra_halfs", int, 2, 2, 9),
    Parameter("nr_normal_halfs", int, 2, 2, 9),
    Parameter("offside_active_area_size", float, 2.5, 2.5, 7),
    Parameter("offside_kick_margin", float, 9.15, 9.15, 7),
    Parameter("olcoach_port", int, 6002, 6002, 8),
    Parameter("old_coach_hear", bool, False, False, 7),
    Parameter("pen_allow_mult_kicks", bool, True, True, 9),
    Parameter("pen_before_setup_wait", int, 10, 30, 9),
    Parameter("pen_coach_moves_players", bool, True, True, 9),
    Parameter("pen_dist_x", float, 42.5, 42.5, 9),
    Parameter("pen_max_extra_kicks", int, 5, 10, 9),
    Parameter("pen_max_goalie_dist_x", float, 14.0, 14.0, 9),
    Parameter("pen_nr_kicks", int, 5, 5, 9),
    Parameter("pen_random_winner", bool, False, False, 9),
    Parameter("pen_ready_wait", int, 10, 50, 9),
    Parameter("pen_setup_wait", int, 70, 100, 9),
    Parameter("pen_taken_wait", int, 150, 200, 9),
    Parameter("penalty_shoot_outs", bool, True, True, 9),
    Parameter("player_accel_max", float, 1.0, 1.0, 7),
    Parameter("player_decay", float, 0.4, 0.4, 7),
    Parameter("player_rand", float, 0.1, 0.1, 7),
    Parameter("player_size", float, 0.3, 0.3, 7),
    Parameter("player_speed_max", float, 1.05, 1.2, 7),
    Parameter("player_speed_max_min", float, 0.75, None, 12),
    Parameter("player_weight", float, 60.0, 60.0, 7),
    Parameter("point_to_ban", int, 5, 5, 8),
    Parameter("point_to_duration", int, 20, 20, 8),
    Parameter("port", int, 6000, 6000, 8),
    Parameter("prand_factor_l", float, 1.0, 1.0, 7),
    Parameter("prand_factor_r", float, 1.0, 1.0, 7),
    Parameter("profile", bool, False, False, 8),
    Parameter("proper_goal_kicks", bool, False, False, 8),
    Parameter("quantize_step", float, 0.1, 0.1, 7),
    Parameter("quantize_step_l", float, 0.01, 0.01, 7),
    Parameter("record_messages", bool, False, False, 8),
    Parameter("recover_dec", float, 0.002, 0.002, 7),
    Parameter("recover_dec_thr", float, 0.3, 0.3, 7),
    Parameter("recover_init", float, 1.0, 1.0, 9),
    Parameter("recover_min", float, 0.5, 0.5, 7),
    Parameter("recv_step", int, 10, 10, 7),
    Parameter("red_card_probability", float, 0.0, None, 15),
    Parameter("say_coach_cnt_max", int, 128, 128, 7),
    Parameter("say_coach_msg_size", int, 128, 128, 7),
    Parameter("say_msg_size", int, 10, 10, 7),
    Parameter("send_comms", bool, False, False, 8),
    Parameter("send_step", int, 150, 150, 7),
    Parameter("send_vi_step", int, 100, 100, 7),
    Parameter("sense_body_step", int, 100, 100, 7),
    Parameter("side_dash_rate", float, 0.4, None, 13),
    Parameter("simulator_step", int, 100, 100, 7),
    Parameter("slow_down_factor", int, 1, 1, 7),
    Parameter("slowness_on_top_for_left_team", float, 1.0, 1.0, 8),
    Parameter("slowness_on_top_for_right_team", float, 1.0, 1.0, 8),
    Parameter("stamina_capacity", float, 130600.0, None, 13),
    Parameter("stamina_inc_max", float, 45.0, 45.0, 7),
    Parameter("stamina_max", float, 8000.0, 4000.0, 7),
    Parameter("start_goal_l", int, 0, 0, 7),
    Parameter("start_goal_r", int, 0, 0, 7),
    Parameter("stopped_ball_vel", float, 0.01, 0.01, 8),
    Parameter("synch_micro_sleep", int, 1, 1, 8),
    Parameter("synch_mode", bool, False, False, 8),
    Parameter("synch_offset", int, 60, 60, 8),
    Parameter("synch_see_offset", int, 0, None, 12),
    Parameter("tackle_back_dist", float, 0.0, 0.5, 8),
    Parameter("tackle_cycles", int, 10, 10, 8),
    Parameter("tackle_dist", float, 2.0, 2.0, 8),
    Parameter("tackle_exponent", float, 6.0, 6.0, 8),
    Parameter("tackle_power_rate", float, 0.027, 0.027, 8),
    Parameter("tackle_rand_factor", float, 2.0, None, 14),
    Parameter("tackle_width", float, 1.25, 1.0, 8),
    Parameter("team_actuator_noise", bool, False, False, 7),
    Parameter("team_l_start", str, "", "", 9),
    Parameter("team_r_start", str, "", "", 9),
    Parameter("text_log_compression", int, 0, 0, 8),
    Parameter("text_log_dated", bool, True, True, 8),
    Parameter("text_log_dir", str, "./", "./", 8),
    Parameter("text_log_fixed", bool, False, False, 8),
    Parameter("text_log_fixed_name", str, "rcssserver", "rcssserver", 8),
    Parameter("text_logging", bool, True, True, 8),
    Parameter("use_offside", bool, True, True, 7),
    Parameter("verbose", bool, False, False, 8),
    Parameter("visible_angle", float, 90.0, 90.0, 7),
    Parameter("visible_distance", float, 3.0, 3.0, 7),
    Parameter("wind_ang", float, 0.0, 0.0, 7),
    Parameter("wind_dir", float, 0.0, 0.0, 7),
    Parameter("wind_force", float, 0.0, 0.0, 7),
    Parameter("wind_none", bool, False, False, 7),
    Parameter("wind_rand", float, 0.0, 0.0, 7),
    Parameter("wind_random", bool, False, False, 7),
)
"""All server parameters, in byte order of their names."""

BY_NAME: dict[str, Parameter] = {parameter.name: parameter for parameter in SERVER_PARAMETERS}
PROFILES = ("19.0", "11.1")
KIND_NAMES: dict[type, str] = {
    bool: "0, 1, true, false, on or off", int: "an integer", float: "a number", str: "text"
}  # fmt: skip
"""What a person may write for a parameter of each kind."""

KERNEL_PARAMETERS: tuple[str, ...] = (
    "audio_cut_dist", "back_dash_rate", "ball_accel_max", "ball_decay", "ball_rand", "ball_size", "ball_speed_max",
    "ball_stuck_area", "catch_ban_cycle", "catch_probability", "catchable_area_l", "catchable_area_w",
    "dash_angle_step", "dash_power_rate", "drop_ball_time", "effort_dec", "effort_dec_thr", "effort_inc",
    "effort_inc_thr", "effort_init", "effort_min", "extra_half_time", "extra_stamina", "forbid_kick_off_offside",
    "foul_exponent", "goal_width", "goalie_max_moves", "golden_goal", "half_time", "hear_decay", "hear_inc", "hear_max",
    "inertia_moment", "keepaway", "keepaway_length", "keepaway_width", "kick_power_rate", "kick_rand",
    "kickable_margin", "max_back_tackle_power", "max_catch_angle", "max_dash_angle", "max_dash_power",
    "max_tackle_power", "maxmoment", "maxneckang", "maxneckmoment", "maxpower", "min_catch_angle", "min_dash_angle",
    "min_dash_power", "minmoment", "minneckang", "minneckmoment", "minpower", "nr_extra_halfs", "nr_normal_halfs",
    "player_accel_max", "player_decay", "player_rand", "player_size", "player_speed_max", "point_to_ban",
    "point_to_duration", "quantize_step", "quantize_step_l", "recover_dec", "recover_dec_thr", "recover_init",
    "recover_min", "say_msg_size", "send_step", "side_dash_rate", "simulator_step", "slowness_on_top_for_left_team",
    "slowness_on_top_for_right_team", "stamina_capacity", "stamina_inc_max", "stamina_max", "synch_mode",
    "synch_offset", "synch_see_offset", "tackle_back_dist", "tackle_cycles", "tackle_dist", "tackle_exponent",
    "tackle_power_rate", "tackle_rand_factor", "tackle_width", "use_offside", "visible_angle", "visible_distance",
)  # fmt: skip
"""Parameters that physics, perception, referee or players use."""

PARAMS = np.dtype([(name, "f8") for name in KERNEL_PARAMETERS] + [("version_11", "u1")])
"""Server parameters as kernels read them: ``params["ball_decay"][0]``; all numbers, all float64.

``version_11`` is 1 for the behaviour of server 11.1, 0 for 19.0.
"""


def checked(parameter: Parameter, value: Value) -> Value:
    """Return a value in the type of its parameter.

    Raises
    ------
    TypeError
        When it is of the wrong kind.
    """
    kind = parameter.kind
    if kind is str:
        fits = isinstance(value, str)
    elif kind is bool:
        fits = isinstance(value, (bool, int)) and value in (0, 1)
    else:
        fits = isinstance(value, (int, float)) and (kind is float or float(value).is_integer())
    if not fits:
        raise TypeError(f"{parameter.name} takes {KIND_NAMES[kind]}, not {value!r}")
    converted: Value = kind(value)
    return converted


class ServerParams(Mapping[str, Value]):
    """The parameters of one server.

    Parameters
    ----------
    profile : {"19.0", "11.1"}
        Whose defaults to start from. Parameters that 11.1 did not have keep the value with which server 19 behaves
        as 11.1 did.
    **changes : Value
        Parameters that differ from the default.

    Raises
    ------
    KeyError
        For a name that no server knows.
    TypeError
        For a value of the wrong kind.
    """

    def __init__(self, profile: str = "19.0", /, **changes: Value) -> None:
        if profile not in PROFILES:
            raise ValueError(f"unknown profile {profile!r}; known are {', '.join(PROFILES)}")
        self.profile = profile
        self._values: dict[str, Value] = {p.name: _default(p, profile) for p in SERVER_PARAMETERS}
        for name, value in changes.items():
            self.set(name, value)

    def set(self, name: str, value: Value) -> None:
        """Change one parameter."""
        if name not in BY_NAME:
            raise KeyError(f"unknown server parameter {name!r}")
        self._values[name] = checked(BY_NAME[name], value)

    def __getitem__(self, name: str) -> Value:
        return self._values[name]

    def __iter__(self) -> Any:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def number(self, name: str) -> float:
        """Return a numeric parameter."""
        value = self._values[name]
        if isinstance(value, str):
            raise TypeError(f"server parameter {name} is text: {value!r}")
        return float(value)

    def record(self) -> NDArray[np.void]:
        """Return the kernels' record of these parameters (dtype PARAMS, shape (1,))."""
        params = np.zeros(1, dtype=PARAMS)
        for name in KERNEL_PARAMETERS:
            params[name][0] = self.number(name)
        params["version_11"][0] = self.profile == "11.1"
        return params

    def for_version(self, version: int) -> Iterable[tuple[str, Value]]:
        """Yield name and value of what a client of a protocol version is told, in byte order of the names."""
        for parameter in SERVER_PARAMETERS:
            if parameter.since is not None and parameter.since <= version:
                yield parameter.name, self._values[parameter.name]


# What makes server 19's formulas behave as 11.1 did, where 11.1 had no such parameter.
_AS_IN_11 = {
    "extra_stamina": 0.0, "min_dash_power": -100.0, "stamina_capacity": -1.0, "max_back_tackle_power": 100.0,
    "max_catch_angle": 180.0, "min_catch_angle": -180.0, "player_speed_max_min": 0.8,
}  # fmt: skip


def _default(parameter: Parameter, profile: str) -> Value:
    if profile == "19.0":
        return parameter.default
    if parameter.default_11 is not None:
        return parameter.default_11
    return _AS_IN_11.get(parameter.name, parameter.default)
