"""Play modes and the referee: time, stuck ball, set plays, the edge of the world.

Source: 19.0.0, src/referee.cpp (TimeRef, BallStuckRef, OffsideRef, FreeKickRef) and src/stadium.cpp (changePlayMode).

Goals and the ball beyond the lines are judged outside of the compiled step (``fake_server.touch``), as Keepaway never
gets there. Not simulated: offside, back passes, fouls, illegal defence and penalty shoot-outs; a trainer may set any
play mode, and set plays and stoppages run their course.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fake_server.simulation.pitch import (
    in_penalty_area,
    move_out_of_penalty_area,
    truncate_to_pitch,
)
from fake_server.simulation.placement import (
    clear_players_from_ball,
    keep_in_world,
    place_ball,
    place_in_own_half,
)
from fake_server.simulation.state import (
    BACK_PASS_LEFT,
    BACK_PASS_RIGHT,
    BEFORE_KICK_OFF,
    CATCH_FAULT_LEFT,
    CATCH_FAULT_RIGHT,
    CORNER_KICK_LEFT,
    CORNER_KICK_RIGHT,
    DROP_BALL,
    E_DROP_BALL,
    E_HALF_TIME,
    E_PLAY_ON,
    E_TIME_EXTENDED,
    E_TIME_UP,
    E_WITHOUT_A_TEAM,
    FOUL_CHARGE_LEFT,
    FOUL_CHARGE_RIGHT,
    FOUL_PUSH_LEFT,
    FOUL_PUSH_RIGHT,
    FREE_KICK_FAULT_LEFT,
    FREE_KICK_FAULT_RIGHT,
    FREE_KICK_LEFT,
    FREE_KICK_RIGHT,
    GOAL_KICK_LEFT,
    GOAL_KICK_RIGHT,
    GOAL_LEFT,
    GOAL_RIGHT,
    ILLEGAL_DEFENSE_LEFT,
    ILLEGAL_DEFENSE_RIGHT,
    INDIRECT_FREE_KICK_LEFT,
    INDIRECT_FREE_KICK_RIGHT,
    KICK_IN_LEFT,
    KICK_IN_RIGHT,
    KICK_OFF_LEFT,
    KICK_OFF_RIGHT,
    N_MODES,
    OFFSIDE_LEFT,
    OFFSIDE_RIGHT,
    PLAY_ON,
    TIME_OVER,
    side_of,
)
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.protocol.records import LEFT, NO_SIDE, RIGHT

_WAIT = 30
"""Steps of a stoppage before the free kick."""
_CLEAR_TIME = 5
"""Last steps of a stoppage, in which players are cleared from the ball."""
_GOAL_WAIT = 50


def _table(default: int, entries: dict[int, int]) -> NDArray[np.uint8]:
    table = np.full(N_MODES, default, dtype=np.uint8)
    for mode, value in entries.items():
        table[mode] = value
    return table


_FREE_KICK_FOR = {
    OFFSIDE_LEFT: FREE_KICK_RIGHT, OFFSIDE_RIGHT: FREE_KICK_LEFT,
    FREE_KICK_FAULT_LEFT: FREE_KICK_RIGHT, FREE_KICK_FAULT_RIGHT: FREE_KICK_LEFT,
    CATCH_FAULT_LEFT: FREE_KICK_RIGHT, CATCH_FAULT_RIGHT: FREE_KICK_LEFT,
    ILLEGAL_DEFENSE_LEFT: FREE_KICK_RIGHT, ILLEGAL_DEFENSE_RIGHT: FREE_KICK_LEFT,
    BACK_PASS_LEFT: INDIRECT_FREE_KICK_RIGHT, BACK_PASS_RIGHT: INDIRECT_FREE_KICK_LEFT,
    FOUL_CHARGE_LEFT: FREE_KICK_RIGHT, FOUL_CHARGE_RIGHT: FREE_KICK_LEFT,
    FOUL_PUSH_LEFT: FREE_KICK_RIGHT, FOUL_PUSH_RIGHT: FREE_KICK_LEFT,
}  # fmt: skip
AFTER_STOPPAGE = _table(0, _FREE_KICK_FOR)
"""Play mode that ends a stoppage; 0 for modes that are none."""
STOPPED = _table(0, dict.fromkeys([*_FREE_KICK_FOR, GOAL_LEFT, GOAL_RIGHT], 1))
"""1 for modes in which the time stands still but objects move."""
_KICK_OF = {
    KICK_OFF_LEFT: LEFT, KICK_IN_LEFT: LEFT, FREE_KICK_LEFT: LEFT, INDIRECT_FREE_KICK_LEFT: LEFT,
    CORNER_KICK_LEFT: LEFT, GOAL_KICK_LEFT: LEFT,
    KICK_OFF_RIGHT: RIGHT, KICK_IN_RIGHT: RIGHT, FREE_KICK_RIGHT: RIGHT, INDIRECT_FREE_KICK_RIGHT: RIGHT,
    CORNER_KICK_RIGHT: RIGHT, GOAL_KICK_RIGHT: RIGHT,
}  # fmt: skip
SET_PLAY_OF = _table(NO_SIDE, _KICK_OF)
"""Side that has the kick in a set play, NO_SIDE in other modes."""


@inlined
def kick_forbidden(mode: int) -> bool:
    """Tell whether kicks do not count in a play mode."""
    return mode in (BEFORE_KICK_OFF, TIME_OVER) or STOPPED[mode] != 0


@kernel
def other_side(side: int) -> int:
    """The side against a side; NO_SIDE for NO_SIDE."""
    if side == NO_SIDE:
        return NO_SIDE
    return RIGHT if side == LEFT else LEFT


@kernel
def change_play_mode(match: NDArray[np.void], params: NDArray[np.void], mode: int, rng: NDArray[np.uint64]) -> None:
    """Change the play mode, with what the referee does at such a change: give players room, name the kicking side.

    The caller tells the clients. For the first play_on of Keepaway use ``keepaway.kick_off``.
    """
    match["mode"][0] = mode
    match["mode_steps"][0] = 0
    side = SET_PLAY_OF[mode]
    if side != NO_SIDE:
        clear_players_from_ball(match, params, other_side(side), rng)
        match["kick_off_side"][0] = side
    elif mode == DROP_BALL:
        clear_players_from_ball(match, params, NO_SIDE, rng)
        match["kick_off_side"][0] = NO_SIDE
    elif mode in (FREE_KICK_FAULT_LEFT, FREE_KICK_FAULT_RIGHT):
        match["catcher"][0] = -1
    elif mode in (ILLEGAL_DEFENSE_LEFT, ILLEGAL_DEFENSE_RIGHT):
        match["kick_off_side"][0] = RIGHT if mode == ILLEGAL_DEFENSE_LEFT else LEFT
    elif mode == PLAY_ON:
        match["events"][0] |= E_PLAY_ON


@kernel
def free_kick(
    match: NDArray[np.void], params: NDArray[np.void], side: int, x: float, y: float, rng: NDArray[np.uint64]
) -> None:
    """Give a side a free kick at a point, as a monitor's dispfoul or a catch does."""
    x, y = truncate_to_pitch(x, y)
    place_ball(match, x, y, 0.0, 0.0)
    match["catcher"][0] = -1
    change_play_mode(match, params, FREE_KICK_LEFT if side == LEFT else FREE_KICK_RIGHT, rng)
    keep_in_world(match)


@kernel
def drop_ball(match: NDArray[np.void], params: NDArray[np.void], x: float, y: float, rng: NDArray[np.uint64]) -> None:
    """Drop the ball at a point: everybody 9.15 m away from it, the mode drop_ball and at once play_on."""
    match["catcher"][0] = -1
    x, y = truncate_to_pitch(x, y)
    place_ball(match, x, y, 0.0, 0.0)
    change_play_mode(match, params, DROP_BALL, rng)
    keep_in_world(match)
    match["events"][0] |= E_DROP_BALL
    change_play_mode(match, params, PLAY_ON, rng)


@kernel
def _award_drop_ball(match: NDArray[np.void], params: NDArray[np.void], rng: NDArray[np.uint64]) -> None:
    x, y = truncate_to_pitch(match["ball_pos"][0, 0], match["ball_pos"][0, 1])
    x, y = move_out_of_penalty_area(NO_SIDE, x, y)
    drop_ball(match, params, x, y, rng)


@inlined
def _watch_stuck_ball(match: NDArray[np.void], params: NDArray[np.void], rng: NDArray[np.uint64]) -> None:
    """Drop the ball when it has stayed within ball_stuck_area (m) of a place for drop_ball_time steps."""
    area = params["ball_stuck_area"][0]
    patience = params["drop_ball_time"][0]
    if area <= 0.0 or patience <= 0:
        return
    x, y = match["ball_pos"][0, 0], match["ball_pos"][0, 1]
    dx, dy = x - match["stuck_pos"][0, 0], y - match["stuck_pos"][0, 1]
    if match["mode"][0] == PLAY_ON and dx * dx + dy * dy <= area * area:
        match["stuck_cycles"][0] += 1
        if match["stuck_cycles"][0] < patience:
            return
        match["stuck_pos"][0, 0], match["stuck_pos"][0, 1] = x, y
        match["stuck_cycles"][0] = 0
        _award_drop_ball(match, params, rng)
        return
    match["stuck_pos"][0, 0], match["stuck_pos"][0, 1] = x, y
    match["stuck_cycles"][0] = 0


@kernel
def _has_team(match: NDArray[np.void], side: int) -> bool:
    n = 0
    for k in range(match["n_players"][0]):
        n += side_of(match["players"][0, k]) == side
    return n > 0


@kernel
def _end_half(match: NDArray[np.void], params: NDArray[np.void], event: int, rng: NDArray[np.uint64]) -> None:
    """Stop for the next half: ball in the centre, before_kick_off, players in their halves."""
    match["half_count"][0] += 1
    count = match["half_count"][0]
    match["events"][0] |= event
    match["catcher"][0] = -1
    place_ball(match, 0.0, 0.0, 0.0, 0.0)
    match["kick_off_side"][0] = LEFT if count % 2 == 0 else RIGHT
    change_play_mode(match, params, BEFORE_KICK_OFF, rng)
    normal = int(params["nr_normal_halfs"][0])
    step = 1000.0 / params["simulator_step"][0]
    match["time"][0] = int(params["half_time"][0] * step * min(count, normal) + 0.5)
    if count >= normal:
        match["time"][0] += int(params["extra_half_time"][0] * step * (count - normal) + 0.5)
    if count == normal:
        for k in range(match["n_players"][0]):
            match["capacity"][0, match["players"][0, k]] = params["stamina_capacity"][0]
    place_in_own_half(match, params, rng)


@kernel
def _finish(match: NDArray[np.void], params: NDArray[np.void], event: int, rng: NDArray[np.uint64]) -> None:
    match["events"][0] |= event
    change_play_mode(match, params, TIME_OVER, rng)


@kernel
def _watch_time(match: NDArray[np.void], params: NDArray[np.void], rng: NDArray[np.uint64]) -> None:
    """Call half times and the end; nothing when half_time is not above 0, as in Keepaway.

    A drawn game ends after the extra halves; penalty shoot-outs are not simulated.
    """
    if params["half_time"][0] <= 0.0:
        return
    step = 1000.0 / params["simulator_step"][0]
    half = int(params["half_time"][0] * step + 0.5)
    extra = int(params["extra_half_time"][0] * step + 0.5)
    normal_halfs = int(params["nr_normal_halfs"][0])
    normal = half * normal_halfs
    time, count = match["time"][0], match["half_count"][0]
    drawn = match["score"][0, 0] == match["score"][0, 1]
    if time >= normal + extra * int(params["nr_extra_halfs"][0]):
        _finish(match, params, E_TIME_UP, rng)
    elif time >= normal:
        played = count + 1 - normal_halfs
        if not _has_team(match, LEFT) or not _has_team(match, RIGHT):
            _finish(match, params, E_TIME_UP | E_WITHOUT_A_TEAM, rng)
        elif not drawn and (params["golden_goal"][0] > 0.0 or (played == 0 and time >= normal)):
            _finish(match, params, E_TIME_UP, rng)
        elif time >= normal + extra * played:
            _end_half(match, params, E_TIME_EXTENDED, rng)
    elif time >= half * (count + 1):
        _end_half(match, params, E_HALF_TIME, rng)


@kernel
def _run_stoppage(match: NDArray[np.void], params: NDArray[np.void], rng: NDArray[np.uint64]) -> None:
    """Count a stoppage down and give the free kick, or the kick-off after a goal."""
    mode = match["mode"][0]
    steps = match["mode_steps"][0] + 1
    match["mode_steps"][0] = steps
    if mode in (GOAL_LEFT, GOAL_RIGHT):
        if steps > _GOAL_WAIT:
            place_ball(match, 0.0, 0.0, 0.0, 0.0)
            change_play_mode(match, params, KICK_OFF_RIGHT if mode == GOAL_LEFT else KICK_OFF_LEFT, rng)
            place_in_own_half(match, params, rng)
        return
    restart = int(AFTER_STOPPAGE[mode])
    guilty = other_side(SET_PLAY_OF[restart])
    if steps > _WAIT - _CLEAR_TIME:
        clear_players_from_ball(match, params, guilty, rng)
    if steps <= _WAIT:
        return
    if FOUL_CHARGE_LEFT <= mode <= FOUL_PUSH_RIGHT:
        x, y = match["ball_pos"][0, 0], match["ball_pos"][0, 1]
        if in_penalty_area(guilty, x, y, params["ball_size"][0]):
            restart = INDIRECT_FREE_KICK_RIGHT if guilty == LEFT else INDIRECT_FREE_KICK_LEFT
    change_play_mode(match, params, restart, rng)


@kernel
def _run_set_play(match: NDArray[np.void], params: NDArray[np.void], rng: NDArray[np.uint64]) -> None:
    """Play on once the ball moves (after a goal kick: leaves the penalty area); drop it when nobody kicks."""
    mode = match["mode"][0]
    x, y = match["ball_pos"][0, 0], match["ball_pos"][0, 1]
    if mode in (GOAL_KICK_LEFT, GOAL_KICK_RIGHT):
        in_play = not in_penalty_area(NO_SIDE, x, y, params["ball_size"][0])
    else:
        in_play = match["ball_vel"][0, 0] != 0.0 or match["ball_vel"][0, 1] != 0.0
    if in_play:
        change_play_mode(match, params, PLAY_ON, rng)
    keep_in_world(match)
    clear_players_from_ball(match, params, other_side(match["kick_off_side"][0]), rng)
    if in_play or SET_PLAY_OF[mode] == NO_SIDE:
        return
    match["mode_steps"][0] += 1
    if match["mode_steps"][0] == params["drop_ball_time"][0]:
        _award_drop_ball(match, params, rng)


@kernel
def analyse(match: NDArray[np.void], params: NDArray[np.void], rng: NDArray[np.uint64]) -> None:
    """Let all referees but that of Keepaway look at the match, in the server's order, at the end of a step's motion.

    Parameters
    ----------
    match : ndarray of MATCH, shape (1,)
    params : ndarray of PARAMS, shape (1,)
    rng : ndarray of uint64, shape (4,)
    """
    if match["mode"][0] != BEFORE_KICK_OFF and not STOPPED[match["mode"][0]]:
        _watch_time(match, params, rng)
    _watch_stuck_ball(match, params, rng)
    mode = match["mode"][0]
    if STOPPED[mode]:
        keep_in_world(match)
        _run_stoppage(match, params, rng)
    elif mode in (PLAY_ON, TIME_OVER):
        keep_in_world(match)
    elif mode == BEFORE_KICK_OFF:
        if params["use_offside"][0] > 0.0 and params["forbid_kick_off_offside"][0] > 0.0:
            place_in_own_half(match, params, rng)
        keep_in_world(match)
        clear_players_from_ball(match, params, other_side(match["kick_off_side"][0]), rng)
    else:
        _run_set_play(match, params, rng)
