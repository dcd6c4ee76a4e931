"""What a trainer may do to a match, and monitors of a server with a trainer: shared by both."""

from __future__ import annotations

from fake_server.game import Game
from fake_server.reactions import Placement, Reactions, Reply, Substitution
from rcss_hat.protocol import commands as said

_DONE_AS_THEY_STAND: dict[type, str] = {
    said.Start: "(ok start)",
    said.ChangeMode: "(ok change_mode)",
    said.MoveBall: "(ok move)",
    said.Recover: "(ok recover)",
}


def coach(game: Game, command: said.Command) -> Reactions:
    """Return what a command of a trainer asks for, and the reply; nothing for commands that are no such thing."""
    if (reply := _DONE_AS_THEY_STAND.get(type(command))) is not None:
        return command, Reply(reply)
    if isinstance(command, said.MovePlayer):
        return *_move_player(game, command), Reply("(ok move)")
    if isinstance(command, said.CheckBall):
        return (Reply(f"(ok check_ball {game.time} {game.ball_place()})"),)
    if isinstance(command, said.ChangePlayerType):
        return _change_type(game, command)
    return ()


def _move_player(game: Game, command: said.MovePlayer) -> Reactions:
    """Place a player; one of a team that does not exist is, as by the original, not missed."""
    team = game.find_team(command.team)
    i = None if team is None else game.player_index(1 if team == 0 else -1, command.unum)
    if i is None:
        return ()
    angle = command.angle
    if angle is not None:
        angle = min(max(angle, game.params.number("minmoment")), game.params.number("maxmoment"))
    return (Placement(i, command.x, command.y, angle, command.velocity),)


def _change_type(game: Game, command: said.ChangePlayerType) -> Reactions:
    team, unum, player_type = game.find_team(command.team), command.unum, command.player_type
    if team is None:
        return (Reply("(warning no_team_found)"),)
    if not 0 <= player_type < len(game.types):
        return (Reply("(error out_of_range_player_type)"),)
    if not 1 <= unum <= game.team_size(team):
        return (Reply("(warning no_such_player)"),)
    i = game.player_index(1 if team == 0 else -1, unum)
    assert i is not None
    return Substitution(i, player_type), Reply(f"(ok change_player_type {command.team} {unum} {player_type})")
