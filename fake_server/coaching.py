"""What a trainer may do to a match, and monitors of a server with a trainer: shared by both."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rcss_hat.protocol import commands as said
from rcss_hat.protocol.play_modes import PLAY_MODE_IDS

if TYPE_CHECKING:
    from fake_server.server import Server


def coach(server: Server, command: said.Command) -> str | None:
    """Carry out a command of a trainer and return the reply; None for commands that are no such thing."""
    game = server.game
    if isinstance(command, said.Start):
        server.kick_off()
        return "(ok start)"
    if isinstance(command, said.ChangeMode):
        server.change_mode(PLAY_MODE_IDS[command.mode])
        return "(ok change_mode)"
    if isinstance(command, said.MoveBall):
        game.move_ball(command.x, command.y, command.velocity or (0.0, 0.0))
        return "(ok move)"
    if isinstance(command, said.MovePlayer):
        _move_player(server, command)
        return "(ok move)"
    if isinstance(command, said.Recover):
        game.recover()
        return "(ok recover)"
    if isinstance(command, said.CheckBall):
        return f"(ok check_ball {game.time} {game.ball_place()})"
    if isinstance(command, said.ChangePlayerType):
        return _change_type(server, command)
    return None


def _move_player(server: Server, command: said.MovePlayer) -> None:
    """Place a player; one of a team that does not exist is, as by the original, not missed."""
    game = server.game
    team = game.find_team(command.team)
    i = None if team is None else game.player_index(1 if team == 0 else -1, command.unum)
    if i is None:
        return
    angle = command.angle
    if angle is not None:
        angle = min(max(angle, game.params.number("minmoment")), game.params.number("maxmoment"))
    game.move_player(i, command.x, command.y, angle, command.velocity)


def _change_type(server: Server, command: said.ChangePlayerType) -> str:
    game = server.game
    team = game.find_team(command.team)
    if team is None:
        return "(warning no_team_found)"
    if not 0 <= command.player_type < len(game.types):
        return "(error out_of_range_player_type)"
    if not 1 <= command.unum <= game.team_size(team):
        return "(warning no_such_player)"
    i = game.player_index(1 if team == 0 else -1, command.unum)
    assert i is not None
    server.substitute(i, command.player_type)
    return f"(ok change_player_type {command.team} {command.unum} {command.player_type})"
