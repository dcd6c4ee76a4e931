"""Monitor versions 1 and 2: frames, messages and parameters as the server's C structures, big-endian.

Source: 19.0.0, src/types.h and src/dispsender.cpp; the tables below are the members of the structures in their order.
Lengths, angles (rad) and stamina are whole numbers: in 1/16 m and degrees in version 1, in 1/65536 in version 2.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rcss_hat.numeric.angles import RAD
from rcss_hat.protocol.messages.frame import COUNTERS
from rcss_hat.protocol.params import ServerParams, Value
from rcss_hat.protocol.records import COUNT_NAMES, HIGH, MAX_PLAYERS

_N_PLAYERS = 2 * MAX_PLAYERS
SHOW_MODE, MESSAGE_MODE, TYPE_MODE, SERVER_MODE, PLAYER_MODE = 1, 2, 7, 8, 9
"""First member of every datagram: what it holds."""

_I2, _I4 = ">i2", ">i4"
_SCALE_1, _SCALE_2 = 16.0, 65536.0
_TEXT_SIZE = 2048
_SIZES = {1: 2052, 2: 2056}
_BODY = {1: 2, 2: 4}

_TEAM = np.dtype([("name", "S16"), ("score", _I2)])
_POS_1 = np.dtype([(name, _I2) for name in ("enable", "side", "unum", "angle", "x", "y")])
SHOW_1 = np.dtype(
    {
        "names": ["mode", "pmode", "teams", "pos", "time"],
        "formats": [_I2, "u1", (_TEAM, (2,)), (_POS_1, (_N_PLAYERS + 1,)), _I2],
        "offsets": [0, 2, 4, 40, 316],
        "itemsize": _SIZES[1],
    }
)
"""A frame of monitor version 1; entry 0 of ``pos`` is the ball."""
_PLAYER_2 = np.dtype(
    [
        ("state", _I2), ("type", _I2), ("pos", _I4, (2,)), ("vel", _I4, (2,)), ("body", _I4), ("neck", _I4),
        ("view_width", _I4), ("quality", _I2), ("stamina", _I4), ("effort", _I4), ("recovery", _I4),
        ("counts", _I2, (8,)),
    ],
    align=True,
)  # fmt: skip
SHOW_2 = np.dtype(
    {
        "names": ["mode", "pmode", "teams", "ball", "players", "time"],
        "formats": [_I2, "u1", (_TEAM, (2,)), (_I4, (4,)), (_PLAYER_2, (_N_PLAYERS,)), _I2],
        "offsets": [0, 4, 6, 44, 60, 1468],
        "itemsize": _SIZES[2],
    }
)
"""A frame of monitor version 2."""
_COUNTS_2 = [COUNTERS.index(name) for name in COUNT_NAMES]
_SCALED_2 = ("pos", "vel", "body", "neck", "stamina", "effort", "recovery")


def _words(text: str) -> tuple[str, ...]:
    return tuple(text.split())


_SERVER_MEMBERS = _words("""
    goal_width inertia_moment player_size player_decay player_rand player_weight player_speed_max
    player_accel_max stamina_max stamina_inc_max recover_init recover_dec_thr recover_min recover_dec
    effort_init effort_dec_thr effort_min effort_dec effort_inc_thr effort_inc kick_rand team_actuator_noise
    prand_factor_l prand_factor_r kick_rand_factor_l kick_rand_factor_r ball_size ball_decay ball_rand
    ball_weight ball_speed_max ball_accel_max dash_power_rate kick_power_rate kickable_margin control_radius
    control_radius_width maxpower minpower maxmoment minmoment maxneckmoment minneckmoment maxneckang minneckang
    visible_angle visible_distance wind_dir wind_force wind_ang wind_rand kickable_area catchable_area_l
    catchable_area_w catch_probability goalie_max_moves ckick_margin offside_active_area_size wind_none
    wind_random say_coach_cnt_max say_coach_msg_size clang_win_size clang_define_win clang_meta_win
    clang_advice_win clang_info_win clang_mess_delay clang_mess_per_cycle half_time simulator_step send_step
    recv_step sense_body_step lcm_step say_msg_size hear_max hear_inc hear_decay catch_ban_cycle
    slow_down_factor use_offside forbid_kick_off_offside offside_kick_margin audio_cut_dist quantize_step
    quantize_step_l dir_qstep dist_qstep_l dist_qstep_r land_qstep_l land_qstep_r dir_qstep_l dir_qstep_r coach
    coach_w_referee old_coach_hear send_vi_step slowness_on_top_for_left_team slowness_on_top_for_right_team
    keepaway_length keepaway_width ball_stuck_area max_tackle_power max_back_tackle_power tackle_dist
    tackle_back_dist tackle_width start_goal_l start_goal_r fullstate_l fullstate_r drop_ball_time synch_mode
    synch_offset synch_micro_sleep point_to_ban point_to_duration
""")
_SINCE_12 = _words("max_tackle_power max_back_tackle_power tackle_dist tackle_back_dist tackle_width")
"""Members that are spare places in 11.1."""
_UNUSED = -1.0  # of parameters that no server has any more
_PLAYER_MEMBERS = _words("""
    player_types subs_max pt_max player_speed_max_delta_min player_speed_max_delta_max
    stamina_inc_max_delta_factor player_decay_delta_min player_decay_delta_max inertia_moment_delta_factor
    dash_power_rate_delta_min dash_power_rate_delta_max player_size_delta_factor kickable_margin_delta_min
    kickable_margin_delta_max kick_rand_delta_factor extra_stamina_delta_min extra_stamina_delta_max
    effort_max_delta_factor effort_min_delta_factor random_seed new_dash_power_rate_delta_min
    new_dash_power_rate_delta_max new_stamina_inc_max_delta_factor kick_power_rate_delta_min
    kick_power_rate_delta_max foul_detect_probability_delta_factor catchable_area_l_stretch_min
    catchable_area_l_stretch_max spare allow_mult_default_type
""")
_TYPE_MEMBERS = _words("""
    player_speed_max stamina_inc_max player_decay inertia_moment dash_power_rate player_size kickable_margin
    kick_rand extra_stamina effort_max effort_min kick_power_rate foul_detect_probability
    catchable_area_l_stretch
""")
_OLD_PLAYER_MEMBERS, _OLD_TYPE_MEMBERS = 20, 11
"""How many of them there are in 11.1; spare places follow."""


def _wrapped(whole: ArrayLike, kind: str) -> NDArray[np.int64]:
    """Cut whole numbers to the bits that fit, as the server's casts do."""
    numbers = np.asarray(whole, dtype=np.float64)
    return np.where(np.abs(numbers) < 2.0**62, numbers, 0.0).astype(np.int64).astype(kind)


def _put_teams(frame: NDArray[np.void], match: NDArray[np.void], teams: tuple[str, str]) -> None:
    for k in range(2):
        frame["teams"]["name"][0, k] = teams[k].encode("latin-1")
        frame["teams"]["score"][0, k] = match["score"][0, k]


def show_1(match: NDArray[np.void], flags: NDArray[np.int64], teams: tuple[str, str]) -> bytes:
    """Return a frame of monitor version 1.

    Parameters
    ----------
    match : ndarray of a record of the match, shape (1,)
        See `frame`.
    flags : ndarray of int64, shape (22,)
        Every player's state.
    teams : tuple of str
        Names, empty where there is none.
    """
    frame = np.zeros(1, dtype=SHOW_1)
    frame["mode"] = SHOW_MODE
    frame["pmode"] = match["mode"]
    frame["time"] = match["time"].astype("i2")
    _put_teams(frame, match, teams)
    pos = frame["pos"]
    for axis, name in enumerate("xy"):
        places = np.concatenate([match["ball_pos"][0, axis : axis + 1], match["pos"][0, :, axis]])
        pos[name][0] = _wrapped(np.rint(places * _SCALE_1), "i2")
    pos["angle"][0, 1:] = _wrapped(np.rint(match["body"][0] * RAD), "i2")
    for i in range(_N_PLAYERS):
        pos["enable"][0, i + 1] = flags[i].astype("i2")
        pos["side"][0, i + 1] = 1 if i < MAX_PLAYERS else -1
        pos["unum"][0, i + 1] = i % MAX_PLAYERS + 1
    return frame.tobytes()


def show_2(
    match: NDArray[np.void], flags: NDArray[np.int64], view_angles: NDArray[np.float64], teams: tuple[str, str]
) -> bytes:
    """Return a frame of monitor version 2; arguments as for `show_1`, and view angles (degrees), shape (22,)."""
    frame = np.zeros(1, dtype=SHOW_2)
    frame["mode"] = SHOW_MODE
    frame["pmode"] = match["mode"]
    frame["time"] = match["time"].astype("i2")
    _put_teams(frame, match, teams)
    ball = np.concatenate([match["ball_pos"][0], match["ball_vel"][0]])
    frame["ball"][0] = _wrapped(np.rint(ball * _SCALE_2), "i4")
    players = frame["players"][0]
    players["type"] = match["type"][0]
    players["quality"] = match["quality"][0] == HIGH
    for field in _SCALED_2:
        players[field] = _wrapped(np.rint(match[field][0] * _SCALE_2), "i4")
    players["counts"] = match["counts"][0][:, _COUNTS_2].astype("i2")
    for i in range(_N_PLAYERS):
        players["state"][i] = flags[i].astype("i2")
        players["view_width"][i] = round(math.radians(view_angles[i]) * _SCALE_2)
    return frame.tobytes()


def message(version: int, board: int, text: str) -> bytes:
    """Return a message for monitors of version 1 or 2."""
    frame = bytearray(_SIZES[version])
    start = _BODY[version]
    frame[0:2] = MESSAGE_MODE.to_bytes(2, "big")
    frame[start : start + 2] = board.to_bytes(2, "big")
    data = text.encode("latin-1")[: _TEXT_SIZE - 1]
    frame[start + 2 : start + 2 + len(data)] = data
    return bytes(frame)


def _structure(mode: int, members: list[tuple[str, int]]) -> bytes:
    """Lay out members, each a kind and a whole number, behind the mode of a version 2 datagram."""
    dtype = np.dtype([(f"m{k}", kind) for k, (kind, _) in enumerate(members)], align=True)
    body = np.zeros(1, dtype=dtype)
    for k, (kind, whole) in enumerate(members):
        body[f"m{k}"] = _wrapped(float(whole), kind[1:])
    data = mode.to_bytes(2, "big").ljust(_BODY[2], b"\0") + body.tobytes()
    return data.ljust(_SIZES[2], b"\0")


def server_params(params: ServerParams) -> bytes:
    """Return the parameters of the server for monitors of version 2 (numbers are cut, not rounded)."""
    steps = [int(params.number(name)) for name in ("simulator_step", "sense_body_step", "send_vi_step", "send_step")]
    derived: dict[str, float | int] = {
        "control_radius_width": params.number("control_radius") - params.number("player_size"),
        "kickable_area": sum(params.number(name) for name in ("kickable_margin", "ball_size", "player_size")),
        "lcm_step": math.lcm(*steps, int(params.number("synch_offset")) if params["synch_mode"] else 1),
    }
    if params.profile == "11.1":
        derived |= dict.fromkeys(_SINCE_12, 0.0)
    members = []
    for name in _SERVER_MEMBERS:
        value = derived.get(name, params.get(name, _UNUSED))
        members.append((_I4, int(float(value) * _SCALE_2)) if isinstance(value, float) else (_I2, int(value)))
    return _structure(SERVER_MODE, members)


def player_params(params: Mapping[str, Value], old: bool = False) -> bytes:
    """Return the player parameters for monitors of version 2; there are fewer in 11.1 (``old``)."""
    members: list[tuple[str, int]] = []
    for name in _PLAYER_MEMBERS[:_OLD_PLAYER_MEMBERS] if old else _PLAYER_MEMBERS:
        value = params.get(name, 0.0)
        if name == "random_seed":
            members.append((_I4, int(value)))
        elif isinstance(value, float):
            members.append((_I4, int(value * _SCALE_2 + 0.5)))
        else:
            members.append((_I2, int(value)))
    return _structure(PLAYER_MODE, members)


def player_type(types: NDArray[np.void], number: int, old: bool = False) -> bytes:
    """Return a player type for monitors of version 2; the structure is shorter in 11.1 (``old``)."""
    names = _TYPE_MEMBERS[:_OLD_TYPE_MEMBERS] if old else _TYPE_MEMBERS
    scaled = [(_I4, round(float(types[name][number]) * _SCALE_2)) for name in names]
    return _structure(TYPE_MODE, [(_I2, number), *scaled])
