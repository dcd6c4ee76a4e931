"""Carrying out players' commands on the state of a match: which kernel each command goes to, and what the referee says.

Nothing here answers a client, so that a command can also be tried on a copy of the match (`apply`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fake_server.game import Game
from fake_server.soccer.ball_contact import announce_catch, judge_punch, start_play
from fake_server.soccer.catch import catch_ball
from fake_server.soccer.tackle import tackle
from rcss_hat.protocol import commands as said
from rcss_hat.protocol.records import HIGH, LEFT, LOW, MAX_PLAYERS, NARROW, NORMAL, RIGHT, WIDE
from rcss_hat.simulation import commands
from rcss_hat.simulation.state import EAR_OTHER_COMPLETE, EAR_OTHER_PARTIAL, EAR_OWN_COMPLETE, EAR_OWN_PARTIAL
from rcss_hat.simulation.world import World

Match = NDArray[np.void]
_Apply = Callable[[Game, World, int, Any], bool]

_WIDTHS = {"narrow": NARROW, "normal": NORMAL, "wide": WIDE}
_QUALITIES = {"high": HIGH, "low": LOW}
_OWN_EAR = {"complete": EAR_OWN_COMPLETE, "partial": EAR_OWN_PARTIAL, None: EAR_OWN_COMPLETE | EAR_OWN_PARTIAL}
_OTHER_EAR = {
    "complete": EAR_OTHER_COMPLETE,
    "partial": EAR_OTHER_PARTIAL,
    None: EAR_OTHER_COMPLETE | EAR_OTHER_PARTIAL,
}


def act(game: Game, i: int, command: said.Command) -> tuple[bool, list[str]]:
    """Carry out a player's command in the game's match.

    Returns
    -------
    bool
        Whether it was accepted.
    list of str
        What the referee announces.
    """
    match = game.match
    if not isinstance(command, said.Kick | said.Tackle | said.Catch):
        return apply(game, game.world, i, command), []
    before = match["ball_acc"][0].copy()
    match["events"] = 0
    accepted = apply(game, game.world, i, command)
    if isinstance(command, said.Catch):
        return accepted, _judge_catch(game, i) if accepted else []
    strength = float(np.hypot(*(match["ball_acc"][0] - before)))
    if strength == 0.0 and not (accepted and isinstance(command, said.Kick)):
        return accepted, []
    if game.touch is not None:
        game.touch.touched(i, strength)
    return accepted, start_play(game.world, i) if game.has_referees else []


def _judge_catch(game: Game, i: int) -> list[str]:
    if announced := announce_catch(game.world, i):
        return announced
    if game.touch is not None:
        game.touch.touched(i, 0.0)
    return judge_punch(game.world, i) if game.has_referees else []


def apply(game: Game, world: World, i: int, command: said.Command) -> bool:
    """Carry out a command that changes the state of the match.

    Parameters
    ----------
    game : Game
        For parameters and team names.
    world : World
        The game's, or a copy.
    i : int
        Index of the player.
    command : Command

    Returns
    -------
    bool
        Whether it was accepted. Commands that change nothing are not.
    """
    apply_it = _APPLY.get(type(command))
    return apply_it is not None and apply_it(game, world, i, command)


def team_of(game: Game, i: int, name: str) -> int | None:
    """Return which team a player means by our, opp, l, r or a name: 0 left, 1 right, None no team."""
    own = i // MAX_PLAYERS
    if name in ("our", "opp"):
        return own if name == "our" else 1 - own
    if name in ("l", "r"):
        return 0 if name == "l" else 1
    return game.find_team(name)


def _dash(game: Game, world: World, i: int, command: said.Dash) -> bool:
    return commands.dash(world, i, command.power, command.direction or 0.0)


def _dash_legs(game: Game, world: World, i: int, command: said.DashLegs) -> bool:
    accepted = False
    for leg, dash in ((commands.LEFT_LEG, command.left), (commands.RIGHT_LEG, command.right)):
        if dash is not None:
            accepted = commands.dash_legs(world.match, world.params, i, leg, *dash) or accepted
    return accepted


def _turn(game: Game, world: World, i: int, command: said.Turn) -> bool:
    return commands.turn(world, i, command.moment)


def _kick(game: Game, world: World, i: int, command: said.Kick) -> bool:
    return commands.kick(world, i, command.power, command.direction)


def _tackle(game: Game, world: World, i: int, command: said.Tackle) -> bool:
    return tackle(world, i, command.number, bool(command.foul))


def _catch(game: Game, world: World, i: int, command: said.Catch) -> bool:
    return catch_ball(world, i, command.direction)


def _move(game: Game, world: World, i: int, command: said.Move) -> bool:
    return commands.move(world, i, command.x, command.y)


def _turn_neck(game: Game, world: World, i: int, command: said.TurnNeck) -> bool:
    return commands.turn_neck(world.match, world.params, i, command.moment)


def _say(game: Game, world: World, i: int, command: said.Say) -> bool:
    message = np.frombuffer(command.message.encode("ascii"), dtype=np.uint8)
    return commands.say(world.match, world.params, i, message, len(message))


def _change_view(game: Game, world: World, i: int, command: said.ChangeView) -> bool:
    return commands.change_view(world.match, i, _WIDTHS[command.width], _QUALITIES[command.quality or "high"])


def _point_to(game: Game, world: World, i: int, command: said.PointTo) -> bool:
    if command.distance is None:
        return commands.point_to_off(world.match, world.params, i)
    return commands.point_to(world.match, world.params, i, command.distance, command.direction)


def _attention_to(game: Game, world: World, i: int, command: said.AttentionTo) -> bool:
    if command.team is None:
        return commands.attention_off(world.match, i)
    team = team_of(game, i, command.team)
    if team is None or not 1 <= command.unum <= game.team_size(team):
        return False
    return commands.attention_to(world.match, i, LEFT if team == 0 else RIGHT, command.unum)


def _ear(game: Game, world: World, i: int, command: said.Ear) -> bool:
    team = None if command.team is None else team_of(game, i, command.team)
    if command.team is not None and team is None:
        return False
    own = i // MAX_PLAYERS
    bits = 0 if team == 1 - own else _OWN_EAR[command.mode]
    bits |= 0 if team == own else _OTHER_EAR[command.mode]
    before = int(world.match["ear_off"][0, i])
    world.match["ear_off"][0, i] = before & ~bits if command.on else before | bits
    return True


def _synch_see(game: Game, world: World, i: int, command: said.SynchSee) -> bool:
    return commands.synch_see(world.match, i)


def _gaussian_see(game: Game, world: World, i: int, command: said.GaussianSee) -> bool:
    return commands.gaussian_see(world.match, i)


def _change_focus(game: Game, world: World, i: int, command: said.ChangeFocus) -> bool:
    return commands.change_focus(world.match, world.params, i, command.distance, command.direction)


_APPLY: dict[type, _Apply] = {
    said.AttentionTo: _attention_to, said.Catch: _catch, said.ChangeFocus: _change_focus,
    said.ChangeView: _change_view, said.Dash: _dash, said.DashLegs: _dash_legs, said.Ear: _ear,
    said.GaussianSee: _gaussian_see, said.Kick: _kick, said.Move: _move, said.PointTo: _point_to, said.Say: _say,
    said.SynchSee: _synch_see, said.Tackle: _tackle, said.Turn: _turn, said.TurnNeck: _turn_neck,
}  # fmt: skip
