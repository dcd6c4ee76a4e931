"""What the referee says at once when a player has touched the ball: to catches, and to kicks that start the play.

Source: 19.0.0, src/stadium.cpp (kickTaken, ballCaught, ballPunched) and src/referee.cpp (FreeKickRef, CatchRef).
"""

from __future__ import annotations

from fake_server.soccer.touch import GOAL_KICK_OF, SHOOT_OUT, award_goal_kick, call_catch_fault
from rcss_hat.protocol.play_modes import PLAY_MODES
from rcss_hat.protocol.records import LEFT
from rcss_hat.simulation.pitch import in_penalty_area
from rcss_hat.simulation.referee import change_play_mode
from rcss_hat.simulation.state import E_CAUGHT, OFFSIDE_LEFT, OFFSIDE_RIGHT, PLAY_ON, side_of
from rcss_hat.simulation.world import World

_NOT_STARTED_BY_A_KICK = frozenset({PLAY_ON, OFFSIDE_LEFT, OFFSIDE_RIGHT, *SHOOT_OUT})


def announce_catch(world: World, i: int) -> list[str]:
    """Announce a player's catch and what follows from it; nothing when the ball has slipped through his hands."""
    if not world.match["events"][0] & E_CAUGHT:
        return []
    world.match["events"] = 0
    return [f"goalie_catch_ball_{'l' if side_of(i) == LEFT else 'r'}", PLAY_MODES[world.match["mode"][0]]]


def judge_punch(world: World, i: int) -> list[str]:
    """Judge a ball that has slipped through a player's hands: a fault outside of his penalty area."""
    side = int(side_of(i))
    x, y = world.match["ball_pos"][0].tolist()
    if in_penalty_area(side, x, y, float(world.params["ball_size"][0])):
        return []
    return call_catch_fault(world, side)


def start_play(world: World, i: int) -> list[str]:
    """Let the play go on with the kick that a set play waits for; a goal kick has to leave the penalty area first."""
    match, mode = world.match, int(world.match["mode"][0])
    if mode in _NOT_STARTED_BY_A_KICK:
        return []
    kicker = GOAL_KICK_OF.get(mode)
    if kicker is not None:
        return [] if side_of(i) == kicker else award_goal_kick(world, kicker, float(match["ball_pos"][0, 1]))
    change_play_mode(world, PLAY_ON)
    match["events"] = 0
    return [PLAY_MODES[PLAY_ON]]
