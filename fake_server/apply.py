"""Carrying out players' commands on the state of a match: which kernel each command goes to.

Nothing here answers a client, so that a command can also be tried on a copy of the match.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fake_server.game import Game
from fake_server.simulation import commands
from fake_server.simulation.state import EAR_OTHER_COMPLETE, EAR_OTHER_PARTIAL, EAR_OWN_COMPLETE, EAR_OWN_PARTIAL
from rcss_hat.protocol import commands as said
from rcss_hat.protocol.records import HIGH, LEFT, LOW, MAX_PLAYERS, NARROW, NORMAL, RIGHT, WIDE

Match = NDArray[np.void]
Stream = NDArray[np.uint64]
_Apply = Callable[[Game, Match, Stream, int, Any], bool]

_WIDTHS = {"narrow": NARROW, "normal": NORMAL, "wide": WIDE}
_QUALITIES = {"high": HIGH, "low": LOW}
_OWN_EAR = {"complete": EAR_OWN_COMPLETE, "partial": EAR_OWN_PARTIAL, None: EAR_OWN_COMPLETE | EAR_OWN_PARTIAL}
_OTHER_EAR = {
    "complete": EAR_OTHER_COMPLETE,
    "partial": EAR_OTHER_PARTIAL,
    None: EAR_OTHER_COMPLETE | EAR_OTHER_PARTIAL,
}


def apply(game: Game, match: Match, rng: Stream, i: int, command: said.Command) -> bool:
    """Carry out a command that changes the state of the match.

    Parameters
    ----------
    game : Game
        For parameters and team names.
    match : ndarray of MATCH, shape (1,)
        The game's, or a copy.
    rng : ndarray of uint64, shape (4,)
        The stream PHYSICS that belongs to the match.
    i : int
        Index of the player.
    command : Command

    Returns
    -------
    bool
        Whether it was accepted. Commands that change nothing are not.
    """
    apply_it = _APPLY.get(type(command))
    return apply_it is not None and apply_it(game, match, rng, i, command)


def team_of(game: Game, i: int, name: str) -> int | None:
    """Return which team a player means by our, opp, l, r or a name: 0 left, 1 right, None no team."""
    own = i // MAX_PLAYERS
    if name in ("our", "opp"):
        return own if name == "our" else 1 - own
    if name in ("l", "r"):
        return 0 if name == "l" else 1
    return game.find_team(name)


def _dash(game: Game, match: Match, rng: Stream, i: int, command: said.Dash) -> bool:
    return commands.dash(match, game.kernel, game.types, i, command.power, command.direction or 0.0)


def _dash_legs(game: Game, match: Match, rng: Stream, i: int, command: said.DashLegs) -> bool:
    accepted = False
    for leg, dash in ((commands.LEFT_LEG, command.left), (commands.RIGHT_LEG, command.right)):
        if dash is not None:
            accepted = commands.dash_legs(match, game.kernel, i, leg, *dash) or accepted
    return accepted


def _turn(game: Game, match: Match, rng: Stream, i: int, command: said.Turn) -> bool:
    return commands.turn(match, game.kernel, game.types, i, command.moment, rng)


def _kick(game: Game, match: Match, rng: Stream, i: int, command: said.Kick) -> bool:
    return commands.kick(match, game.kernel, game.types, i, command.power, command.direction, rng)


def _tackle(game: Game, match: Match, rng: Stream, i: int, command: said.Tackle) -> bool:
    return commands.tackle(match, game.kernel, game.types, i, command.number, bool(command.foul), rng)


def _catch(game: Game, match: Match, rng: Stream, i: int, command: said.Catch) -> bool:
    return commands.catch_ball(match, game.kernel, game.types, i, command.direction, rng)


def _move(game: Game, match: Match, rng: Stream, i: int, command: said.Move) -> bool:
    return commands.move(match, game.kernel, game.types, i, command.x, command.y, rng)


def _turn_neck(game: Game, match: Match, rng: Stream, i: int, command: said.TurnNeck) -> bool:
    return commands.turn_neck(match, game.kernel, i, command.moment)


def _say(game: Game, match: Match, rng: Stream, i: int, command: said.Say) -> bool:
    message = np.frombuffer(command.message.encode("ascii"), dtype=np.uint8)
    return commands.say(match, game.kernel, i, message, len(message))


def _change_view(game: Game, match: Match, rng: Stream, i: int, command: said.ChangeView) -> bool:
    return commands.change_view(match, i, _WIDTHS[command.width], _QUALITIES[command.quality or "high"])


def _point_to(game: Game, match: Match, rng: Stream, i: int, command: said.PointTo) -> bool:
    if command.distance is None:
        return commands.point_to_off(match, game.kernel, i)
    return commands.point_to(match, game.kernel, i, command.distance, command.direction)


def _attention_to(game: Game, match: Match, rng: Stream, i: int, command: said.AttentionTo) -> bool:
    if command.team is None:
        return commands.attention_off(match, i)
    team = team_of(game, i, command.team)
    if team is None or not 1 <= command.unum <= game.team_size(team):
        return False
    return commands.attention_to(match, i, LEFT if team == 0 else RIGHT, command.unum)


def _ear(game: Game, match: Match, rng: Stream, i: int, command: said.Ear) -> bool:
    team = None if command.team is None else team_of(game, i, command.team)
    if command.team is not None and team is None:
        return False
    own = i // MAX_PLAYERS
    bits = 0 if team == 1 - own else _OWN_EAR[command.mode]
    bits |= 0 if team == own else _OTHER_EAR[command.mode]
    before = int(match["ear_off"][0, i])
    match["ear_off"][0, i] = before & ~bits if command.on else before | bits
    return True


def _synch_see(game: Game, match: Match, rng: Stream, i: int, command: said.SynchSee) -> bool:
    return commands.synch_see(match, i)


def _gaussian_see(game: Game, match: Match, rng: Stream, i: int, command: said.GaussianSee) -> bool:
    return commands.gaussian_see(match, i)


def _change_focus(game: Game, match: Match, rng: Stream, i: int, command: said.ChangeFocus) -> bool:
    return commands.change_focus(match, game.kernel, i, command.distance, command.direction)


_APPLY: dict[type, _Apply] = {
    said.AttentionTo: _attention_to, said.Catch: _catch, said.ChangeFocus: _change_focus,
    said.ChangeView: _change_view, said.Dash: _dash, said.DashLegs: _dash_legs, said.Ear: _ear,
    said.GaussianSee: _gaussian_see, said.Kick: _kick, said.Move: _move, said.PointTo: _point_to, said.Say: _say,
    said.SynchSee: _synch_see, said.Tackle: _tackle, said.Turn: _turn, said.TurnNeck: _turn_neck,
}  # fmt: skip
