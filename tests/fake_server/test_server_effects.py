"""What every parameter does here: all of them are classified, and what is said to have an effect has one."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest
from effect_scenes import SCENES, Scene, digest_of

import fake_server
from fake_server.effects import NO_EFFECT, NOT_DONE_HERE
from fake_server.options import parse_options, without_effect
from fake_server.player_param import PLAYER_PARAMETERS
from rcss_hat.protocol.params import KERNEL_PARAMETERS, SERVER_PARAMETERS, Value

SOURCES = Path(fake_server.__file__).parent

IN_PLAY: dict[str, dict[str, Value]] = {
    "bodies": {
        "back_dash_rate": 0.5, "dash_angle_step": 45.0, "dash_power_rate": 0.0078, "effort_dec": 0.0065,
        "effort_dec_thr": 0.1, "effort_inc": 0.013, "effort_inc_thr": 0.95, "effort_init": 0.9, "effort_min": 0.5,
        "extra_stamina": 65.0, "hear_max": 2, "inertia_moment": 6.5, "keepaway": True, "kick_power_rate": 0.0351,
        "kick_rand": 0.13, "kickable_margin": 0.91, "max_dash_angle": 90.0, "max_dash_power": 130.0,
        "maxmoment": 50.0, "maxneckang": 50.0, "maxneckmoment": 20.0, "maxpower": 50.0, "min_dash_angle": -90.0,
        "min_dash_power": -50.0, "minmoment": -50.0, "minneckang": -50.0, "minneckmoment": -20.0,
        "player_accel_max": 0.1, "player_decay": 0.52, "player_rand": 0.13, "player_size": 0.39,
        "player_speed_max": 1.365, "player_speed_max_min": 1.0, "point_to_ban": 6, "point_to_duration": 21,
        "quantize_step": 0.13, "quantize_step_l": 0.013, "recover_dec": 0.0026, "recover_dec_thr": 0.05,
        "recover_min": 0.99, "send_step": 140, "side_dash_rate": 0.52, "simulator_step": 50,
        "slowness_on_top_for_left_team": 1.3, "slowness_on_top_for_right_team": 1.3, "stamina_capacity": 169800.0,
        "stamina_inc_max": 58.5, "stamina_max": 10400.0, "start_goal_l": 1, "start_goal_r": 1, "synch_offset": 90,
        "visible_angle": 117.0, "visible_distance": 3.9,
    },
    "balls": {
        "ball_accel_max": 0.5, "ball_decay": 0.8, "ball_rand": 0.065, "ball_size": 0.1105, "ball_speed_max": 1.0,
        "ball_stuck_area": 1.0, "foul_exponent": 1.0, "goal_width": 18.23, "max_back_tackle_power": 0.5,
        "max_tackle_power": 50.0, "minpower": -10.0, "tackle_back_dist": 0.5, "tackle_cycles": 11,
        "tackle_dist": 2.6, "tackle_exponent": 7.8, "tackle_power_rate": 0.0351, "tackle_rand_factor": 2.6,
        "tackle_width": 0.2,
    },
    "catches": {
        "catch_ban_cycle": 3, "catch_probability": 0.5, "catchable_area_l": 0.5, "catchable_area_w": 0.2,
        "goalie_max_moves": 1, "max_catch_angle": 10.0, "min_catch_angle": -10.0,
    },
    "words": {
        "audio_cut_dist": 20.0, "dist_noise_rate": 0.1, "focus_dist_noise_rate": 0.1, "hear_decay": 2, "hear_inc": 0,
        "land_dist_noise_rate": 0.1, "land_focus_dist_noise_rate": 0.1, "say_msg_size": 5, "synch_see_offset": 70,
    },
    "stoppages": {"drop_ball_time": 101, "forbid_kick_off_offside": False, "use_offside": False},
    "corners": {"ckick_margin": 3.0},
    "halves": {
        "extra_half_time": 101, "golden_goal": True, "half_time": 301, "nr_extra_halfs": 3, "nr_normal_halfs": 3,
    },
    "keepers": {"keepaway_length": 26.0, "keepaway_width": 26.0, "synch_mode": True},
}  # fmt: skip
"""Parameters of the game with values, by the scene that they change."""

_LOG = ("compression", "dated", "dir", "fixed", "fixed_name")
AROUND: dict[str, tuple[str, ...]] = {
    "audience": ("send_comms",),
    "soccer/auto_mode": ("auto_mode", "connect_wait", "game_over_wait", "kick_off_wait"),
    "clock": ("slow_down_factor",),
    "game": ("coach", "coach_w_referee", "fixed_teamname_l", "fixed_teamname_r"),
    "logs": (
        "game_log_version", "game_logging", "keepaway_logging", "log_date_format", "record_messages", "text_logging",
    ),
    "player_client": ("fullstate_l", "fullstate_r"),
    "reception": ("coach_port", "max_monitors", "olcoach_port", "port"),
    "server": ("keepaway_start",),
    "trainer": ("say_coach_msg_size",),
}  # fmt: skip
"""Parameters of what is around the game, by the module of the server that reads them."""
LOG_FILES = {f"{kind}_log_{name}" for kind in ("game", "text", "keepaway") for name in _LOG} - {
    "keepaway_log_compression"
}
"""Parameters of log files, whose names `fake_server.logs` puts together."""

TYPES: dict[str, Value] = {
    "catchable_area_l_stretch_max": 1.5, "catchable_area_l_stretch_min": 1.1, "dash_power_rate_delta_max": 0.001,
    "dash_power_rate_delta_min": -0.001, "effort_max_delta_factor": -0.005, "effort_min_delta_factor": -0.005,
    "extra_stamina_delta_max": 65.0, "extra_stamina_delta_min": 10.0, "inertia_moment_delta_factor": 30.0,
    "kick_power_rate_delta_max": 0.01, "kick_power_rate_delta_min": -0.01, "kick_rand_delta_factor": 1.3,
    "kickable_margin_delta_max": 0.13, "kickable_margin_delta_min": -0.13, "new_dash_power_rate_delta_max": 0.001,
    "new_dash_power_rate_delta_min": -0.0015, "new_stamina_inc_max_delta_factor": -7800.0,
    "player_decay_delta_max": 0.13, "player_decay_delta_min": -0.13, "player_size_delta_factor": -130.0,
    "player_speed_max_delta_max": 0.2, "player_speed_max_delta_min": -0.1, "player_types": 17, "random_seed": 8,
    "stamina_inc_max_delta_factor": -400.0, "foul_detect_probability_delta_factor": 3.0,
}  # fmt: skip
"""Parameters from which the player types are made, with values."""
TYPES_NEEDED = {
    "dash_power_rate_delta_max": 0.002,
    "kick_power_rate_delta_max": 0.02,
    "player_speed_max_delta_max": 0.3,
}
"""What is not 0 where a factor in TYPES multiplies it."""
AT_KICK_OFF = {"allow_mult_default_type", "pt_max"}
"""Which players get which types when a match without Keepaway begins."""


@cache
def unchanged(scene: str) -> str:
    return digest_of(scene)


@pytest.mark.parametrize("scene", SCENES)
def test_a_scene_is_the_same_every_time(scene: str) -> None:
    assert digest_of(scene) == unchanged(scene)


@pytest.mark.parametrize(("scene", "name"), [(scene, name) for scene, names in IN_PLAY.items() for name in names])
def test_a_parameter_of_the_game_changes_what_happens(scene: str, name: str) -> None:
    assert digest_of(scene, {name: IN_PLAY[scene][name]}) != unchanged(scene)


@pytest.mark.parametrize("name", TYPES)
def test_a_parameter_of_the_types_changes_them(name: str) -> None:
    assert digest_of("halves", {}, TYPES_NEEDED | {name: TYPES[name]}) != _with_types_needed()


@cache
def _with_types_needed() -> str:
    return digest_of("halves", {}, dict(TYPES_NEEDED))


@pytest.mark.parametrize("changes", [{"pt_max": 2}, {"allow_mult_default_type": True}])
def test_who_gets_which_type_at_kick_off(changes: dict[str, Value]) -> None:
    given = Scene({}, {"random_seed": 7}).game.line_up.at_kick_off()
    assert len(given) == 4  # of three players one keeps the default type
    assert Scene({}, {"random_seed": 7} | changes).game.line_up.at_kick_off() != given


@pytest.mark.parametrize("scene", SCENES)
def test_what_is_without_effect_changes_nothing(scene: str) -> None:
    told = {"foul_detect_probability"}  # by player types, of themselves
    changes = {
        parameter.name: _other(parameter.default)
        for parameter in SERVER_PARAMETERS
        if parameter.name in NO_EFFECT["server"] - told
    }
    assert digest_of(scene, changes) == unchanged(scene)


def _other(value: Value) -> Value:
    if isinstance(value, bool):
        return not value
    return f"{value}x" if isinstance(value, str) else type(value)(2 * value + 1)


def test_all_202_server_parameters_are_classified_once() -> None:
    classes = [
        *(set(names) for names in IN_PLAY.values()),
        *(set(names) for names in AROUND.values()),
        LOG_FILES,
        set(NO_EFFECT["server"]),
    ]
    names = [name for group in classes for name in group]
    assert sorted(names) == sorted(parameter.name for parameter in SERVER_PARAMETERS)
    assert len(SERVER_PARAMETERS) == 202
    in_play = {name for names in IN_PLAY.values() for name in names}
    assert set(KERNEL_PARAMETERS) - {"recover_init"} <= in_play


def test_all_player_parameters_are_classified_once() -> None:
    names = [*TYPES, *AT_KICK_OFF, *NO_EFFECT["player"]]
    assert sorted(names) == sorted(parameter.name for parameter in PLAYER_PARAMETERS)


@pytest.mark.parametrize(("module", "names"), AROUND.items())
def test_what_is_around_the_game_is_read_where_it_says(module: str, names: tuple[str, ...]) -> None:
    source = (SOURCES / f"{module}.py").read_text()
    assert [name for name in names if f'"{name}"' not in source] == []


@pytest.mark.parametrize("space", ["server", "player"])
def test_whatever_is_without_effect_is_named_when_it_is_set(space: str) -> None:
    table = SERVER_PARAMETERS if space == "server" else PLAYER_PARAMETERS
    line = [
        f"{space}::{parameter.name}={str(_other(parameter.default)).lower()}"
        for parameter in table
        if parameter.name in NO_EFFECT[space] and parameter.name not in NOT_DONE_HERE
    ]
    assert without_effect(parse_options(line)) == sorted(entry.partition("=")[0] for entry in line)
    assert without_effect(parse_options([])) == []
