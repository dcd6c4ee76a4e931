"""Soccer's referee: time, set plays, stoppages, before the kick-off.

Source: 19.0.0, src/referee.cpp (TimeRef, OffsideRef, FreeKickRef). Goals and the ball beyond the lines are judged after
the step (`fake_server.touch`). Not simulated: offside, back passes, fouls, illegal defence and penalty shoot-outs; a
trainer may set any play mode, and set plays and stoppages run their course.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.protocol.records import LEFT, NO_SIDE, RIGHT
from rcss_hat.simulation.pitch import in_penalty_area, truncate_to_pitch
from rcss_hat.simulation.placement import clear_players_from_ball, keep_in_world, place_ball, place_in_own_half
from rcss_hat.simulation.referee import (
    AFTER_STOPPAGE,
    SET_PLAY_OF,
    STOPPED,
    award_drop_ball,
    ball_is_stuck,
    change_play_mode,
    other_side,
)
from rcss_hat.simulation.state import (
    BEFORE_KICK_OFF,
    E_HALF_TIME,
    E_TIME_EXTENDED,
    E_TIME_UP,
    E_WITHOUT_A_TEAM,
    FOUL_CHARGE_LEFT,
    FOUL_PUSH_RIGHT,
    FREE_KICK_LEFT,
    FREE_KICK_RIGHT,
    GOAL_KICK_LEFT,
    GOAL_KICK_RIGHT,
    GOAL_LEFT,
    GOAL_RIGHT,
    INDIRECT_FREE_KICK_LEFT,
    INDIRECT_FREE_KICK_RIGHT,
    KICK_OFF_LEFT,
    KICK_OFF_RIGHT,
    PLAY_ON,
    TIME_OVER,
    side_of,
)
from rcss_hat.simulation.world import World

_WAIT = 30
"""Steps of a stoppage before the free kick."""
_CLEAR_TIME = 5
"""Last steps of a stoppage, in which players are cleared from the ball."""
_GOAL_WAIT = 50


def free_kick(world: World, side: int, x: float, y: float) -> None:
    """Give a side a free kick at a point, as a monitor's dispfoul or a catch does."""
    match = world.match
    x, y = truncate_to_pitch(x, y)
    place_ball(match, x, y, 0.0, 0.0)
    match["catcher"][0] = -1
    change_play_mode(world, FREE_KICK_LEFT if side == LEFT else FREE_KICK_RIGHT)
    keep_in_world(match)


def _has_team(match: NDArray[np.void], side: int) -> bool:
    return any(side_of(i) == side for i in match["players"][0, : match["n_players"][0]].tolist())


def _end_half(world: World, event: int) -> None:
    """Stop for the next half: ball in the centre, before_kick_off, players in their halves."""
    match, params = world.match, world.params
    match["half_count"][0] += 1
    count = match["half_count"][0]
    match["events"][0] |= event
    match["catcher"][0] = -1
    place_ball(match, 0.0, 0.0, 0.0, 0.0)
    match["kick_off_side"][0] = LEFT if count % 2 == 0 else RIGHT
    change_play_mode(world, BEFORE_KICK_OFF)
    normal = int(params["nr_normal_halfs"][0])
    step = 1000.0 / params["simulator_step"][0]
    match["time"][0] = int(params["half_time"][0] * step * min(count, normal) + 0.5)
    if count >= normal:
        match["time"][0] += int(params["extra_half_time"][0] * step * (count - normal) + 0.5)
    if count == normal:
        for k in range(match["n_players"][0]):
            match["capacity"][0, match["players"][0, k]] = params["stamina_capacity"][0]
    place_in_own_half(world)


def _finish(world: World, event: int) -> None:
    match = world.match
    match["events"][0] |= event
    change_play_mode(world, TIME_OVER)


def _watch_time(world: World) -> None:
    """Call half times and the end; nothing when half_time is not above 0, as in Keepaway.

    A drawn game ends after the extra halves; penalty shoot-outs are not simulated.
    """
    match, params = world.match, world.params
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
        _finish(world, E_TIME_UP)
    elif time >= normal:
        played = count + 1 - normal_halfs
        if not _has_team(match, LEFT) or not _has_team(match, RIGHT):
            _finish(world, E_TIME_UP | E_WITHOUT_A_TEAM)
        elif not drawn and (params["golden_goal"][0] > 0.0 or (played == 0 and time >= normal)):
            _finish(world, E_TIME_UP)
        elif time >= normal + extra * played:
            _end_half(world, E_TIME_EXTENDED)
    elif time >= half * (count + 1):
        _end_half(world, E_HALF_TIME)


def _run_stoppage(world: World) -> None:
    """Count a stoppage down and give the free kick, or the kick-off after a goal."""
    match, params = world.match, world.params
    mode = match["mode"][0]
    steps = match["mode_steps"][0] + 1
    match["mode_steps"][0] = steps
    if mode in (GOAL_LEFT, GOAL_RIGHT):
        if steps > _GOAL_WAIT:
            place_ball(match, 0.0, 0.0, 0.0, 0.0)
            change_play_mode(world, KICK_OFF_RIGHT if mode == GOAL_LEFT else KICK_OFF_LEFT)
            place_in_own_half(world)
        return
    restart = int(AFTER_STOPPAGE[mode])
    guilty = other_side(SET_PLAY_OF[restart])
    if steps > _WAIT - _CLEAR_TIME:
        clear_players_from_ball(world, guilty)
    if steps <= _WAIT:
        return
    if FOUL_CHARGE_LEFT <= mode <= FOUL_PUSH_RIGHT:
        x, y = match["ball_pos"][0, 0], match["ball_pos"][0, 1]
        if in_penalty_area(guilty, x, y, params["ball_size"][0]):
            restart = INDIRECT_FREE_KICK_RIGHT if guilty == LEFT else INDIRECT_FREE_KICK_LEFT
    change_play_mode(world, restart)


def _run_set_play(world: World) -> None:
    """Play on once the ball moves (after a goal kick: leaves the penalty area); drop it when nobody kicks."""
    match, params = world.match, world.params
    mode = match["mode"][0]
    x, y = match["ball_pos"][0, 0], match["ball_pos"][0, 1]
    if mode in (GOAL_KICK_LEFT, GOAL_KICK_RIGHT):
        in_play = not in_penalty_area(NO_SIDE, x, y, params["ball_size"][0])
    else:
        in_play = match["ball_vel"][0, 0] != 0.0 or match["ball_vel"][0, 1] != 0.0
    if in_play:
        change_play_mode(world, PLAY_ON)
    keep_in_world(match)
    clear_players_from_ball(world, other_side(match["kick_off_side"][0]))
    if in_play or SET_PLAY_OF[mode] == NO_SIDE:
        return
    match["mode_steps"][0] += 1
    if match["mode_steps"][0] == params["drop_ball_time"][0]:
        award_drop_ball(world)


def analyse(world: World) -> None:
    """Let all referees but that of Keepaway look at the match, in the server's order, at the end of a step's motion.

    Parameters
    ----------
    world : World
    """
    match, params = world.match, world.params
    if match["mode"][0] != BEFORE_KICK_OFF and not STOPPED[match["mode"][0]]:
        _watch_time(world)
    if ball_is_stuck(match, params):
        award_drop_ball(world)
    mode = match["mode"][0]
    if STOPPED[mode]:
        keep_in_world(match)
        _run_stoppage(world)
    elif mode in (PLAY_ON, TIME_OVER):
        keep_in_world(match)
    elif mode == BEFORE_KICK_OFF:
        if params["use_offside"][0] > 0.0 and params["forbid_kick_off_offside"][0] > 0.0:
            place_in_own_half(world)
        keep_in_world(match)
        clear_players_from_ball(world, other_side(match["kick_off_side"][0]))
    else:
        _run_set_play(world)
