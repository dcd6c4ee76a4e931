"""What the records of a saved match can hold, field by field; see `rcss_hat.numeric.bounds`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.keepaway.task import Task
from rcss_hat.numeric.bounds import FLAG, SAME, Bounds, BoundsError, check_records, check_streams, check_values
from rcss_hat.player.objects import PLAYER_MEMORY
from rcss_hat.player.records import N_SLOTS, NEVER
from rcss_hat.protocol.records import CLOSE_GOAL, MAX_PLAYERS, MAX_SEEN, SAY_SIZE
from rcss_hat.simulation.state import E_CAUGHT, F_RED_CARD, LEG_BUSY, MAX_MESSAGES, N_MODES, N_PLAYERS

_TIME = (0.0, 2.0**30)
"""Cycles, and whatever there is at most one of in a cycle: 30,000 simulated hours."""
_SINCE = (float(NEVER), 2.0**30)
"""A player's times; NEVER when it has not happened."""
_PLACE = (-1000.0, 1000.0)
"""Metres."""
_SPEED = (-100.0, 100.0)
"""Metres per cycle."""
_RADIANS = (-7.0, 7.0)
_DEGREES = (-360.0, 360.0)
_UNIT = (-1.0, 1.0)
_FEW = (0.0, 1000.0)
"""Cycles that something lasts."""
_BYTE = (0.0, 255.0)
_SLOT = (-2.0, N_SLOTS - 1.0)
_INDEX = (0.0, N_PLAYERS - 1.0)
_NOTHING = (0.0, 0.0)

MATCH_BOUNDS: Bounds = {
    "time": _TIME, "stopped": _TIME, "mode": (0.0, N_MODES - 1.0), "events": (0.0, 2.0 * E_CAUGHT - 1.0),
    "score": _TIME, "ball_pos": _PLACE, "ball_vel": _SPEED, "ball_acc": _SPEED, "catcher": (-1.0, N_PLAYERS - 1.0),
    "n_players": SAME, "players": SAME, "enabled": SAME, "goalie": SAME, "type": SAME, "version": SAME, "size": SAME,
    "effort_max": SAME, "pos": _PLACE, "vel": _SPEED, "acc": _SPEED, "body": _RADIANS, "neck": _RADIANS,
    "body_pending": _RADIANS, "neck_pending": _RADIANS, "stamina": (0.0, 1e6), "effort": FLAG, "recovery": FLAG,
    "capacity": (-1.0, 1e7), "leg": (0.0, LEG_BUSY), "leg_power": (-100.0, 100.0), "leg_dir": _DEGREES,
    "command_done": FLAG, "neck_done": FLAG, "flags": (0.0, 2.0 * F_RED_CARD - 1.0),
    "flags_next": (0.0, 2.0 * F_RED_CARD - 1.0), "kick_cycles": _FEW, "tackle_cycles": _FEW, "catch_ban": _FEW,
    "moves_since_catch": _FEW, "collided": (0.0, 7.0), "counts": _TIME, "quality": FLAG, "width": (0.0, 2.0),
    "synch_see": SAME, "gaussian_see": SAME, "see_ticks": _FEW, "focus_dist": _PLACE, "focus_dir": _RADIANS,
    "arm_pos": _PLACE, "arm_movable": _FEW, "arm_expires": _FEW, "focus_side": (0.0, 2.0),
    "focus_unum": (0.0, MAX_PLAYERS), "hear_own": _FEW, "hear_other": _FEW, "ear_off": (0.0, 15.0),
    "n_said": (0.0, MAX_MESSAGES), "said_by": _INDEX, "said_n": (0.0, SAY_SIZE), "said": _BYTE,
    "said_to": (0.0, 2.0**N_PLAYERS - 1.0), "n_heard": (0.0, MAX_MESSAGES), "heard_by": _INDEX,
    "heard_n": (0.0, SAY_SIZE), "heard": _BYTE, "heard_to": (0.0, 2.0**N_PLAYERS - 1.0), "kick_off_side": (0.0, 2.0),
    "half_count": _FEW, "mode_steps": _TIME, "stuck_pos": _PLACE, "stuck_cycles": _TIME,
    "n_keepers": (0.0, MAX_PLAYERS), "n_takers": (0.0, MAX_PLAYERS), "taken": _TIME, "episode": _TIME,
    "episode_start": _TIME, "last_start": _TIME, "last_end": _TIME, "last_taken": FLAG, "proposals": _PLACE,
    "clock": (0.0, 100_000.0),
}  # fmt: skip

AGENT_BOUNDS: Bounds = {
    "side": SAME, "unum": SAME, "me": SAME, "n_own": SAME, "n_other": SAME, "top_own": (0.0, MAX_PLAYERS),
    "top_other": (MAX_PLAYERS, N_SLOTS), "n_keepers": SAME, "n_takers": SAME, "axis": SAME, "wanted": SAME,
    "rng": (0.0, 2.0**64), "kick_dist": SAME, "roll": SAME, "first_share": SAME, "ball_roll": SAME, "sprint": SAME,
    "grid": SAME, "now": _SINCE, "see_time": _SINCE, "hear_time": _SINCE, "pos": _PLACE, "vel": _SPEED,
    "neck": _DEGREES, "body": _DEGREES, "neck_cos": _UNIT, "neck_sin": _UNIT, "body_cos": _UNIT, "body_sin": _UNIT,
    "head": _DEGREES, "speed": _SPEED, "speed_direction": _DEGREES, "effort": FLAG, "shift": _PLACE, "counts": _TIME,
    "collided": FLAG, "collision_time": _SINCE, "sent_time": _SINCE, "sent_kind": (0.0, 6.0), "sent_a": _DEGREES,
    "sent_b": _DEGREES, "sent_neck": _DEGREES, "withheld": FLAG, "ball_pos": _PLACE, "ball_vel": _SPEED,
    "ball_seen": _SINCE, "ball_change": _SINCE, "ball_see_pos": _PLACE, "ball_see_time": _SINCE, "kicked": FLAG,
    "player_pos": _PLACE, "player_vel": _SPEED, "player_body": _PLACE, "player_seen": _SINCE, "player_time": _SINCE,
    "player_change": _SINCE, "player_angles": _SINCE, "player_known": FLAG, "guessed": FLAG, "player_see_pos": _PLACE,
    "player_see_time": _SINCE, "player_see_vel": _SPEED, "player_see_body": _DEGREES, "fast_see": _SINCE,
    "fast_hear": _SINCE, "fast_own": _SLOT, "fast_other": _SLOT, "aim": _PLACE, "aim_time": _SINCE,
    "search_time": _SINCE, "search_sign": _UNIT, "say_time": _SINCE, "order": (0.0, 1000.0), "distance": (-1.0, 1e6),
    "crowd": (0.0, 1e6), "hold_cycles": SAME,
    "last_action": (-1.0, MAX_PLAYERS - 1.0), "last_action_time": _SINCE, "episodes": _TIME, "new_episode": FLAG,
    "taken_guess": FLAG,
}  # fmt: skip

SEE_BOUNDS: Bounds = {
    "time": _TIME, "n": (0.0, MAX_SEEN), "code": (0.0, CLOSE_GOAL), "fields": (0.0, 63.0), "team": (0.0, 2.0),
    "unum": (0.0, MAX_PLAYERS), "goalie": FLAG, "distance": (0.0, 1000.0), "direction": _DEGREES,
    "distance_change": _PLACE, "direction_change": (-1e6, 1e6), "body": _DEGREES, "head": _DEGREES,
    "pointing": _DEGREES,
}  # fmt: skip

CONTROL_BOUNDS: Bounds = {
    "phase": SAME, "player": (0.0, N_PLAYERS), "status": (0.0, 10.0), "reward": _TIME,
    "choice": (0.0, MAX_PLAYERS - 1.0), "has_choice": _NOTHING, "stop_cycle": (0.0, 2.0**31),
    "stop_episode": (0.0, 2.0**31), "episodes": _TIME, "logged": _NOTHING, "decided": _NOTHING,
    "log_decisions": SAME, "framed": _NOTHING, "log_frames": SAME,
}  # fmt: skip

_RECORDS = {"match": MATCH_BOUNDS, "agents": AGENT_BOUNDS, "sees": SEE_BOUNDS, "control": CONTROL_BOUNDS}


def check_match(task: Task, found: dict[str, NDArray], fresh: dict[str, NDArray]) -> None:
    """Check a saved match between two cycles: every array for itself, and what must agree among them.

    Parameters
    ----------
    task : Task
    found, fresh : dict of str to ndarray
        As from `rcss_hat.arena.match.ArenaMatch.arrays`: what was read, and a new match's.

    Raises
    ------
    ValueError
        When the arrays belong to another task or version, or hold what no match of this task can.
    """
    for name, mine in fresh.items():
        theirs = found.get(name)
        if theirs is None or theirs.dtype != mine.dtype or theirs.shape != mine.shape:
            raise ValueError(f"the saved {name!r} is not that of a {task.size} match of this version")
    for name, bounds in _RECORDS.items():
        check_records(f"the saved {name!r}", found[name], fresh[name], bounds)
    for name in ("started", "has_see"):
        check_values(f"the saved {name!r}", found[name], 0.0, 1.0)
    check_streams("the saved 'streams'", found["streams"])
    check_streams("the saved 'agents'", found["agents"]["rng"])
    _check_times(found)


def _check_times(found: dict[str, NDArray]) -> None:
    """Check that nothing lies in the future, and no belief is carried over more cycles than it is believed."""
    match, agents = found["match"], found["agents"]
    time = int(match["time"][0])
    for name in ("episode_start", "last_start", "last_end"):
        check_values(f"the saved 'match': {name!r}", match[name], 0.0, float(time))
    if int(match["episode"][0]) != int(found["control"]["episodes"][0]) + 1 and time > 0:
        raise BoundsError("the saved 'match' and 'control' count different episodes")
    for name, limits in AGENT_BOUNDS.items():
        if limits is _SINCE:
            check_values(f"the saved 'agents': {name!r}", agents[name], float(NEVER), float(time))
    if time > 0:
        check_values("the saved 'agents': 'now'", agents["now"], float(time), float(time))
    seen, held = agents["player_seen"].astype(np.int64), agents["player_time"].astype(np.int64)
    held[np.arange(len(agents)), agents["me"]] = time  # a player's own slot is not carried over
    behind = (time - held)[(time - seen <= PLAYER_MEMORY) & (held > 0)]
    check_values("the saved 'agents': age of 'player_time'", behind, 0.0, float(PLAYER_MEMORY))
