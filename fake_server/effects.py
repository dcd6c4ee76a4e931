"""Which parameters change nothing here, though clients are told of them.

All others are carried out; `tests/fake_server/test_server_effects.py` says where, and shows it.
"""

from __future__ import annotations

from collections.abc import Mapping

NO_EFFECT: Mapping[str, frozenset[str]] = {
    "server": frozenset({
        "back_passes", "ball_weight", "clang_advice_win", "clang_define_win", "clang_del_win",
        "clang_info_win", "clang_mess_delay", "clang_mess_per_cycle", "clang_meta_win", "clang_rule_win",
        "clang_win_size", "coach_msg_file", "control_radius", "foul_cycles", "foul_detect_probability",
        "free_kick_faults", "freeform_send_period", "freeform_wait_period", "illegal_defense_dist_x",
        "illegal_defense_duration", "illegal_defense_number", "illegal_defense_width", "kick_rand_factor_l",
        "kick_rand_factor_r", "landmark_file", "log_times", "max_goal_kicks", "offside_active_area_size",
        "offside_kick_margin", "old_coach_hear", "pen_allow_mult_kicks", "pen_before_setup_wait",
        "pen_coach_moves_players", "pen_dist_x", "pen_max_extra_kicks", "pen_max_goalie_dist_x", "pen_nr_kicks",
        "pen_random_winner", "pen_ready_wait", "pen_setup_wait", "pen_taken_wait", "penalty_shoot_outs",
        "player_weight", "prand_factor_l", "prand_factor_r", "profile", "proper_goal_kicks", "recover_init",
        "recv_step", "red_card_probability", "say_coach_cnt_max", "send_vi_step", "sense_body_step", "stopped_ball_vel",
        "synch_micro_sleep", "team_actuator_noise", "team_l_start", "team_r_start", "verbose", "wind_ang",
        "wind_dir", "wind_force", "wind_none", "wind_rand", "wind_random",
    }),
    "player": frozenset({"subs_max"}),
}  # fmt: skip
"""Names in each name space."""

NOT_DONE_HERE: Mapping[str, bool | float] = {
    "back_passes": False,
    "foul_detect_probability": 0.0,
    "free_kick_faults": False,
    "penalty_shoot_outs": False,
    "wind_none": True,
}
"""Values that ask for what happens here in any case; with these, they are not named."""

SAVERS: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "CSVSaver": {"save": ("0", "off", "false"), "filename": ("rcssserver.csv",)},
    "MySQLSaver": {},
    "STDOUTSaver": {},
}
"""Name spaces of the original's savers of results, all without effect: parameters, and values that ask for nothing.

Those without parameters are of older servers, and of no effect in 19.0.0, either; what they are given is not checked.
"""
