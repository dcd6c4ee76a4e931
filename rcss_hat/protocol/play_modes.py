"""Play modes: their numbers in the monitor protocol and their names (19.0.0, src/types.h)."""

from __future__ import annotations

_SIDED = {
    4: "kick_off", 6: "kick_in", 8: "free_kick", 10: "corner_kick", 12: "goal_kick", 14: "goal", 17: "offside",
    19: "penalty_kick", 24: "foul_charge", 26: "foul_push", 28: "foul_multiple_attack", 30: "foul_ballout",
    32: "back_pass", 34: "free_kick_fault", 36: "catch_fault", 38: "indirect_free_kick", 40: "penalty_setup",
    42: "penalty_ready", 44: "penalty_taken", 46: "penalty_miss", 48: "penalty_score", 50: "illegal_defense",
}  # fmt: skip
_SINGLE = {
    1: "before_kick_off", 2: "time_over", 3: "play_on", 16: "drop_ball", 21: "first_half_over", 22: "pause",
    23: "human_judge",
}  # fmt: skip

PLAY_MODES: dict[int, str] = dict(
    sorted(
        {
            **_SINGLE,
            **{mode: f"{name}_l" for mode, name in _SIDED.items()},
            **{mode + 1: f"{name}_r" for mode, name in _SIDED.items()},
        }.items()
    )
)
"""Number to name, 1 to 51; ``illegal_defense_*`` only in 19."""
PLAY_MODE_IDS: dict[str, int] = {name: mode for mode, name in PLAY_MODES.items()}
"""Name to number."""
