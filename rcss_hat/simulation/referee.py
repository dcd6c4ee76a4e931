"""Play modes, and the referee who drops a stuck ball: all that Keepaway needs of soccer's.

Source: 19.0.0, src/referee.cpp (BallStuckRef) and src/stadium.cpp (changePlayMode). A change of the play mode happens a
few times per minute at most, so that it is plain Python around the compiled step. The other referees are in
``fake_server.soccer``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import inlined
from rcss_hat.protocol.records import LEFT, NO_SIDE, RIGHT
from rcss_hat.simulation.pitch import (
    move_out_of_penalty_area,
    truncate_to_pitch,
)
from rcss_hat.simulation.placement import (
    clear_players_from_ball,
    keep_in_world,
    place_ball,
)
from rcss_hat.simulation.state import (
    BACK_PASS_LEFT,
    BACK_PASS_RIGHT,
    BEFORE_KICK_OFF,
    CATCH_FAULT_LEFT,
    CATCH_FAULT_RIGHT,
    CORNER_KICK_LEFT,
    CORNER_KICK_RIGHT,
    DROP_BALL,
    E_DROP_BALL,
    E_PLAY_ON,
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
)
from rcss_hat.simulation.world import World


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


def other_side(side: int) -> int:
    """The side against a side; NO_SIDE for NO_SIDE."""
    if side == NO_SIDE:
        return NO_SIDE
    return RIGHT if side == LEFT else LEFT


def change_play_mode(world: World, mode: int) -> None:
    """Change the play mode, with what the referee does at such a change: give players room, name the kicking side.

    The caller tells the clients. For the first play_on of Keepaway use ``keepaway.kick_off``.
    """
    match = world.match
    match["mode"][0] = mode
    match["mode_steps"][0] = 0
    side = SET_PLAY_OF[mode]
    if side != NO_SIDE:
        clear_players_from_ball(world, other_side(side))
        match["kick_off_side"][0] = side
    elif mode == DROP_BALL:
        clear_players_from_ball(world, NO_SIDE)
        match["kick_off_side"][0] = NO_SIDE
    elif mode in (FREE_KICK_FAULT_LEFT, FREE_KICK_FAULT_RIGHT):
        match["catcher"][0] = -1
    elif mode in (ILLEGAL_DEFENSE_LEFT, ILLEGAL_DEFENSE_RIGHT):
        match["kick_off_side"][0] = RIGHT if mode == ILLEGAL_DEFENSE_LEFT else LEFT
    elif mode == PLAY_ON:
        match["events"][0] |= E_PLAY_ON


def drop_ball(world: World, x: float, y: float) -> None:
    """Drop the ball at a point: everybody 9.15 m away from it, the mode drop_ball and at once play_on."""
    match = world.match
    match["catcher"][0] = -1
    x, y = truncate_to_pitch(x, y)
    place_ball(match, x, y, 0.0, 0.0)
    change_play_mode(world, DROP_BALL)
    keep_in_world(match)
    match["events"][0] |= E_DROP_BALL
    change_play_mode(world, PLAY_ON)


def award_drop_ball(world: World) -> None:
    """Drop the ball where it is, or at the corner of the penalty area it is in."""
    match = world.match
    x, y = truncate_to_pitch(match["ball_pos"][0, 0], match["ball_pos"][0, 1])
    x, y = move_out_of_penalty_area(NO_SIDE, x, y)
    drop_ball(world, x, y)


@inlined
def ball_is_stuck(match: NDArray[np.void], params: NDArray[np.void]) -> bool:
    """Tell whether the ball has now stayed within ball_stuck_area (m) of a place for drop_ball_time steps of play_on.

    Once per step, as it counts them; the caller then drops the ball, see :func:`award_drop_ball`.
    """
    area = params["ball_stuck_area"][0]
    patience = params["drop_ball_time"][0]
    if area <= 0.0 or patience <= 0:
        return False
    x, y = match["ball_pos"][0, 0], match["ball_pos"][0, 1]
    dx, dy = x - match["stuck_pos"][0, 0], y - match["stuck_pos"][0, 1]
    stuck = match["mode"][0] == PLAY_ON and dx * dx + dy * dy <= area * area
    if stuck:
        match["stuck_cycles"][0] += 1
        if match["stuck_cycles"][0] < patience:
            return False
    match["stuck_pos"][0, 0], match["stuck_pos"][0, 1] = x, y
    match["stuck_cycles"][0] = 0
    return stuck
