"""What a player may send, and how servers read it (19.0.0, src/player_command_tok.lpp and player_command_parser.ypp).

Almost all commands of real players are written in one plain way; a single regular expression reads those. Everything
else goes through the server's scanner (`tokens`). A command acts as soon as its last parenthesis is read; what follows
an error is dropped.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable
from typing import Annotated, Any, NamedTuple

from rcss_hat.protocol.commands.table import PLAYER, Command, Form, command
from rcss_hat.protocol.commands.tokens import END, ERROR, MESSAGE, Value, token, tokens
from rcss_hat.protocol.commands.values import (
    INT_MAX,
    Degrees,
    Foul,
    Heard,
    Metres,
    Power,
    Switch,
    Team,
    Unum,
    leg,
    real,
    whole,
    word,
)
from rcss_hat.protocol.params import PROFILES

__all__ = [
    "AttentionTo", "Bye", "Catch", "ChangeFocus", "ChangeView", "Clang", "Compression", "Dash", "DashLegs", "Done",
    "Ear", "GaussianSee", "Kick", "LongKick", "Move", "PointTo", "Say", "Score", "SenseBody", "SynchSee", "Tackle",
    "Turn", "TurnNeck", "parse_commands",
]  # fmt: skip


@command(PLAYER, "(dash {power})", later=["(dash {power} {direction})"])
class Dash(Command):
    """Run: power, and direction relative to the body in degrees (server 13 and later)."""

    power: Power
    direction: Degrees | None = None


@command(
    PLAYER,
    later=["(dash {left})", "(dash {right})", "(dash {left} {right})"],
    otherwise="give at least one of the legs left and right",
)
class DashLegs(Command):
    """Run with each leg on its own, (power, direction) or None (server 19)."""

    left: Annotated[tuple[float, float], leg("l")] | None = None
    right: Annotated[tuple[float, float], leg("r")] | None = None


@command(PLAYER, "(turn {moment})")
class Turn(Command):
    """Turn the body: moment in degrees, less when moving."""

    moment: Degrees


@command(PLAYER, "(turn_neck {moment})")
class TurnNeck(Command):
    """Turn the neck by degrees relative to the body."""

    moment: Degrees


@command(PLAYER, "(kick {power} {direction})")
class Kick(Command):
    """Kick: power, and direction in degrees relative to the body."""

    power: Power
    direction: Degrees


@command(PLAYER, later=["(long_kick {power} {direction})"])
class LongKick(Command):
    """A kick that servers read and ignore."""

    power: Power
    direction: Degrees


@command(PLAYER, "(tackle {number})", later=["(tackle {number} {foul})"])
class Tackle(Command):
    """Tackle: the number is a power for clients below version 12, a direction in degrees from 12 on."""

    number: Annotated[float, real(-180, 180, "power or direction")]
    foul: Foul | None = None


@command(PLAYER, "(catch {direction})")
class Catch(Command):
    """Catch the ball (goalie): direction in degrees relative to the body."""

    direction: Degrees


@command(PLAYER, "(move {x} {y})")
class Move(Command):
    """Place oneself before kick-off, metres; the own half has negative x for both sides."""

    x: Metres
    y: Metres


@command(PLAYER, '(say "{message}")')
class Say(Command):
    """Say a message; always sent in quotes, because an unquoted one swallows the commands behind it."""

    message: Heard


@command(PLAYER, "(change_view {width} {quality})", later=["(change_view {width})"])
class ChangeView(Command):
    """Choose the view; the quality may be left out (server 12 and later)."""

    width: Annotated[str, word(("narrow", "normal", "wide"), tokens="w")]
    quality: Annotated[str, word(("low", "high"), tokens="q")] | None = None


@command(PLAYER, "(attentionto {team} {unum})", "(attentionto off)")
class AttentionTo(Command):
    """Listen to one player: team our, opp, l, r or a name; without arguments, to nobody."""

    team: Team | None = None
    unum: Unum = 0


@command(PLAYER, "(pointto {distance} {direction})", "(pointto off)")
class PointTo(Command):
    """Point somewhere: metres and degrees relative to the face; without arguments, stop pointing."""

    distance: Metres | None = None
    direction: Degrees = 0.0


@command(PLAYER, "(ear ({on}))", "(ear ({on} {team}))", "(ear ({on} {mode}))", "(ear ({on} {team} {mode}))")
class Ear(Command):
    """Switch hearing on or off: of one team (our, opp, l, r, a name) or both, of one kind or both."""

    on: Switch
    team: Team | None = None
    mode: Annotated[str, word(("partial", "complete"), tokens="m")] | None = None


@command(PLAYER, "(clang (ver {minimum} {maximum}))")
class Clang(Command):
    """Say which versions of the coach language one understands."""

    minimum: Annotated[int, whole(0, INT_MAX, "lowest version")]
    maximum: Annotated[int, whole(0, INT_MAX, "highest version")]


@command(PLAYER, "(compression {level})")
class Compression(Command):
    """Compress messages: level 0 .. 9; -1 switches off. Trainers and monitors may send it, too."""

    level: Annotated[int, whole(-1, 9, accepts=lambda level: level <= 9)]


@command(PLAYER, later=["(change_focus {distance} {direction})"])
class ChangeFocus(Command):
    """Move the point of focus: metres and degrees (server 18 and later)."""

    distance: Metres
    direction: Degrees


@command(PLAYER, "(sense_body)")
class SenseBody(Command):
    """Ask for a sense_body message."""


@command(PLAYER, "(score)")
class Score(Command):
    """Ask for the score."""


@command(PLAYER, "(done)")
class Done(Command):
    """Answer ``(think)`` in synch mode; trainers may send it, too."""


@command(PLAYER, "(bye)")
class Bye(Command):
    """Leave."""


@command(PLAYER, later=["(synch_see)"])
class SynchSee(Command):
    """See in step with sense_body (server 12 and later)."""


@command(PLAYER, later=["(gaussian_see)"])
class GaussianSee(Command):
    """See with Gaussian noise (server 19)."""


# --- how servers read them -----------------------------------------------------------------------------------------
_PLAIN_NUMBER = rb"(?:-?[1-9]\d{0,8}|0|-?\d*\.\d+)"  # the integer -0 is 0, the real -0.0 keeps its sign
_PLAIN = re.compile(
    rb"[ \t\n]*\((?:([a-z_]+) (%b)(?: (%b))?|say \"(%b)\"|([a-z_]+))\)" % (_PLAIN_NUMBER, _PLAIN_NUMBER, MESSAGE)
)
_LEGS = re.compile(r"(\(l[ir][ir]\))(\(l[ir][ir]\))?")
_PARTS = re.compile(r"\{(\w+)\}")


class _Grammar(NamedTuple):
    """The commands that a server knows.

    Attributes
    ----------
    plain : tuple of dict
        Those that have nothing but so many numbers, by name.
    forms : dict
        All of them: by name, and by the letters of the tokens behind it, what builds the command from the tokens.
    legs : bool
        Whether it knows the legs of dash.
    """

    plain: tuple[dict[bytes, Callable[..., Command]], ...]
    forms: dict[str, dict[str, Callable[[list[Any]], Command]]]
    legs: bool


def _grammar(profile: str) -> _Grammar:
    forms = [form for known in PLAYER.forms.values() for form in known if profile != "11.1" or not form.later]
    grammar = _Grammar(({}, {}, {}), {form.name: {} for form in forms}, any(form.record is DashLegs for form in forms))
    for form in forms:
        if form.record is not DashLegs:
            letters, build = _reader(form)
            grammar.forms[form.name] |= dict.fromkeys(map("".join, itertools.product(*letters)), build)
            if all(choice == "ir" for choice in letters):
                grammar.plain[len(letters)][form.name.encode()] = form.record
    return grammar


def _reader(form: Form) -> tuple[list[str], Callable[[list[Any]], Command]]:
    """Return the letters that every token behind the name may have, and what builds the command from the tokens."""
    parts = _PARTS.split(form.text[len(form.name) + 1 : -1])  # text and names of fields in turns
    letters: list[str] = []
    places = []
    for i, part in enumerate(parts):
        if i % 2:
            places.append(len(letters))
            letters.append(form.kinds[part].tokens)
        else:
            letters += [kind for kind, _ in tokens(part.replace('"', "").encode())]  # a quoted text is one token
    return letters, form.builder(places)


_GRAMMARS = {profile: _grammar(profile) for profile in PROFILES}


def parse_commands(text: bytes, profile: str = "19.0") -> tuple[list[Command], bool]:
    """Read a player's datagram as a server does.

    Arguments are not checked against any range: the server clamps them, or ignores the command.

    Parameters
    ----------
    text : bytes
        The datagram, with or without its NUL.
    profile : {"19.0", "11.1"}
        Which server reads. 11.1 does not know directions of dash, legs, ``(change_view WIDTH)``, fouls, synch_see,
        gaussian_see, change_focus and long_kick. The client's protocol version makes no difference.

    Returns
    -------
    commands : list of Command
        In the order in which they take effect.
    complete : bool
        False when a syntax error ended the reading; the commands before it count.
    """
    grammar = _GRAMMARS.get(profile)
    if grammar is None:
        raise ValueError(f"unknown profile {profile!r}; known are {', '.join(PROFILES)}")
    end = text.find(b"\0")
    if end >= 0:
        text = text[:end]
    commands: list[Command] = []
    position, size = 0, len(text)
    while position < size:
        plain = _PLAIN.match(text, position)
        command = _build_plain(plain, grammar) if plain else None
        if plain is not None and command is not None:
            position = plain.end()
        else:
            command, position = _scan_command(text, position, grammar)
            if position == size and command is None:
                break
        if command is None:
            return commands, False
        commands.append(command)
        if position < 0:
            return commands, False
    return commands, bool(commands)


def _build_plain(plain: re.Match[bytes], grammar: _Grammar) -> Command | None:
    name, first, second, message, bare = plain.groups()
    if name is not None:
        if second is None:
            one = grammar.plain[1].get(name)
            return one(float(first)) if one else None
        two = grammar.plain[2].get(name)
        return two(float(first), float(second)) if two else None
    if message is not None:
        return Say(message.decode("ascii"))
    build = grammar.plain[0].get(bare)
    return build() if build else None


def _scan_command(text: bytes, position: int, grammar: _Grammar) -> tuple[Command | None, int]:
    """Read one command token by token.

    Returns
    -------
    command : Command or None
        None when there is none, or when it is wrong.
    position : int
        Behind the command; the end of the text when nothing but white space is left; -1 after a syntax error.
    """
    kind, value, position = token(text, position)
    if kind == END:
        return None, position
    if kind == "u":
        return Say(str(value)), position
    if kind != "(":
        return None, -1
    kind, name, after = token(text, position)
    if kind != "k":
        return None, -1
    letters, values, after = _arguments(text, after)
    build = grammar.forms.get(str(name), {}).get(letters)
    if build:
        return build(values), after
    return _dash_legs(letters, values, after) if name == "dash" and grammar.legs else (None, -1)


def _arguments(text: bytes, position: int) -> tuple[str, list[Value], int]:
    """Read tokens up to the parenthesis that closes the command; position -1 when it is not found."""
    kinds: list[str] = []
    values: list[Value] = []
    depth = 0
    while True:
        kind, value, position = token(text, position)
        depth += (kind == "(") - (kind == ")")
        if kind in (END, ERROR) or depth > 1:  # no form nests deeper
            return "".join(kinds) + ERROR, values, -1
        if depth < 0:
            return "".join(kinds), values, position
        kinds.append(kind)
        values.append(value)


def _dash_legs(kinds: str, values: list[Any], after: int) -> tuple[Command | None, int]:
    """Read ``(SIDE POWER DIRECTION)`` once or twice; in the server each leg acts at its own closing parenthesis."""
    match = _LEGS.match(kinds)
    if not match:
        return None, -1
    legs = {values[1]: (float(values[2]), float(values[3]))}
    end = match.end(1)
    if match.group(2) and values[6] not in legs:
        legs[values[6]] = (float(values[7]), float(values[8]))
        end = match.end(2)
    return DashLegs(legs.get("l"), legs.get("r")), (after if end == len(kinds) else -1)
