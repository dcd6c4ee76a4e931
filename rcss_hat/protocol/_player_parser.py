"""Players' commands as the server reads them (19.0.0, src/player_command_tok.lpp and player_command_parser.ypp).

The server's scanner takes the longest token at every place and, of equally long ones, the first of: an unquoted say,
parentheses, keywords, integers, reals, names. That rule makes ``(say hi)(done)`` one command, ``10-20`` a name and
``10+20`` two numbers. A command acts as soon as its last parenthesis is read; what follows an error is dropped.

Almost all commands of real players are written in one plain way; a single regular expression reads those. Everything
else goes through the scanner.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from rcss_hat.protocol._player_commands import (
    AttentionTo,
    Bye,
    Catch,
    ChangeFocus,
    ChangeView,
    Clang,
    Command,
    Compression,
    Dash,
    DashLegs,
    Done,
    Ear,
    GaussianSee,
    Kick,
    LongKick,
    Move,
    PointTo,
    Say,
    Score,
    SenseBody,
    SynchSee,
    Tackle,
    Turn,
    TurnNeck,
)
from rcss_hat.protocol._scanf import to_int
from rcss_hat.protocol.params import PROFILES

Value = float | int | str
_MESSAGE = rb"[0-9A-Za-z().+\-*/?<>_ ]+"

# --- the plain way -------------------------------------------------------------------------------------------------
_PLAIN_NUMBER = rb"(?:-?[1-9]\d{0,8}|0|-?\d*\.\d+)"  # the integer -0 is 0, the real -0.0 keeps its sign
_PLAIN = re.compile(
    rb"[ \t\n]*\((?:([a-z_]+) (%b)(?: (%b))?|say \"(%b)\"|([a-z_]+))\)" % (_PLAIN_NUMBER, _PLAIN_NUMBER, _MESSAGE)
)
_BARE: dict[bytes, Callable[[], Command]] = {
    b"bye": Bye, b"done": Done, b"gaussian_see": GaussianSee, b"score": Score, b"sense_body": SenseBody,
    b"synch_see": SynchSee,
}  # fmt: skip
_ONE_NUMBER: dict[bytes, Callable[[float], Command]] = {
    b"catch": Catch, b"dash": Dash, b"tackle": Tackle, b"turn": Turn, b"turn_neck": TurnNeck,
}  # fmt: skip
_TWO_NUMBERS: dict[bytes, Callable[[float, float], Command]] = {
    b"change_focus": ChangeFocus, b"dash": Dash, b"kick": Kick, b"long_kick": LongKick, b"move": Move,
    b"pointto": PointTo,
}  # fmt: skip

# --- the scanner ---------------------------------------------------------------------------------------------------
_SPACE = re.compile(rb"[ \t\n]*")
_UNQUOTED_SAY = re.compile(rb"\(say (%b)\)" % _MESSAGE)
_QUOTED = re.compile(rb'"%b"' % _MESSAGE)
_NUMBER = re.compile(rb"([+-]?(?:(\d*\.\d+)|\d+))([eE][+-]?\d+)?")
_NAME = re.compile(rb"[\-_a-zA-Z0-9]+")
_COMMANDS = (
    b"dash", b"turn", b"turn_neck", b"change_focus", b"kick", b"long_kick", b"catch", b"say", b"sense_body", b"score",
    b"move", b"change_view", b"compression", b"bye", b"done", b"pointto", b"attentionto", b"tackle", b"clang", b"ear",
    b"synch_see", b"gaussian_see",
)  # fmt: skip
# One letter per kind of token, so that the forms of a command are regular expressions over letters: i integer, r real,
# s name or quoted text, u unquoted say, k command, w view width, q view quality, o on, f off, b true or false,
# t our or opp, l left or right, m kind of hearing, v ver, and the parentheses themselves.
_KINDS: dict[bytes, tuple[str, Value]] = {
    b"narrow": ("w", "narrow"), b"normal": ("w", "normal"), b"wide": ("w", "wide"), b"low": ("q", "low"),
    b"high": ("q", "high"), b"on": ("o", True), b"off": ("f", False), b"true": ("b", True), b"false": ("b", False),
    b"our": ("t", "our"), b"opp": ("t", "opp"), b"left": ("l", "l"), b"right": ("l", "r"), b"l": ("l", "l"),
    b"r": ("l", "r"), b"partial": ("m", "partial"), b"complete": ("m", "complete"), b"p": ("m", "partial"),
    b"c": ("m", "complete"), b"ver": ("v", "ver"), b"(": ("(", "("), b")": (")", ")"),
    **{name: ("k", name.decode()) for name in _COMMANDS},
}  # fmt: skip
_END, _ERROR = "$", "!"
_Form = tuple[re.Pattern[str], Callable[[list[Any]], Command]]


def _forms(*pairs: tuple[str, Callable[[list[Any]], Command]]) -> tuple[_Form, ...]:
    # N stands for a number of any kind, T for a team in any way.
    return tuple((re.compile(kinds.replace("N", "[ir]").replace("T", "[tls]")), build) for kinds, build in pairs)


_FORMS: dict[str, tuple[_Form, ...]] = {
    "dash": _forms(("N", lambda v: Dash(float(v[0]))), ("NN", lambda v: Dash(float(v[0]), float(v[1])))),
    "turn": _forms(("N", lambda v: Turn(float(v[0])))),
    "turn_neck": _forms(("N", lambda v: TurnNeck(float(v[0])))),
    "change_focus": _forms(("NN", lambda v: ChangeFocus(float(v[0]), float(v[1])))),
    "kick": _forms(("NN", lambda v: Kick(float(v[0]), float(v[1])))),
    "long_kick": _forms(("NN", lambda v: LongKick(float(v[0]), float(v[1])))),
    "catch": _forms(("N", lambda v: Catch(float(v[0])))),
    "say": _forms(("s", lambda v: Say(_without_quotes(v[0])))),
    "sense_body": _forms(("", lambda v: SenseBody())),
    "score": _forms(("", lambda v: Score())),
    "move": _forms(("NN", lambda v: Move(float(v[0]), float(v[1])))),
    "change_view": _forms(("wq", lambda v: ChangeView(v[0], v[1])), ("w", lambda v: ChangeView(v[0]))),
    "compression": _forms(("i", lambda v: Compression(v[0]))),
    "bye": _forms(("", lambda v: Bye())),
    "done": _forms(("", lambda v: Done())),
    "pointto": _forms(("NN", lambda v: PointTo(float(v[0]), float(v[1]))), ("f", lambda v: PointTo())),
    "attentionto": _forms(("Ti", lambda v: AttentionTo(v[0], v[1])), ("f", lambda v: AttentionTo())),
    "tackle": _forms(("N", lambda v: Tackle(float(v[0]))), ("N[ofb]", lambda v: Tackle(float(v[0]), v[1]))),
    "clang": _forms((r"\(vii\)", lambda v: Clang(v[2], v[3]))),
    "ear": _forms(
        (r"\([of]\)", lambda v: Ear(v[1])),
        (r"\([of]T\)", lambda v: Ear(v[1], v[2])),
        (r"\([of]m\)", lambda v: Ear(v[1], None, v[2])),
        (r"\([of]Tm\)", lambda v: Ear(v[1], v[2], v[3])),
    ),
    "synch_see": _forms(("", lambda v: SynchSee())),
    "gaussian_see": _forms(("", lambda v: GaussianSee())),
}
_LEGS = re.compile(r"(\(l[ir][ir]\))(\(l[ir][ir]\))?")


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
    if profile not in PROFILES:
        raise ValueError(f"unknown profile {profile!r}; known are {', '.join(PROFILES)}")
    old = profile == "11.1"
    end = text.find(b"\0")
    if end >= 0:
        text = text[:end]
    commands: list[Command] = []
    position, size = 0, len(text)
    while position < size:
        plain = _PLAIN.match(text, position)
        command = _build_plain(plain) if plain else None
        if plain is not None and command is not None:
            position = plain.end()
        else:
            command, position = _scan_command(text, position)
            if position == size and command is None:
                break
        if command is None or (old and not _known_to_11(command)):
            return commands, False
        commands.append(command)
        if position < 0:
            return commands, False
    return commands, bool(commands)


def _build_plain(plain: re.Match[bytes]) -> Command | None:
    name, first, second, message, bare = plain.groups()
    if name is not None:
        if second is None:
            one = _ONE_NUMBER.get(name)
            return one(float(first)) if one else None
        two = _TWO_NUMBERS.get(name)
        return two(float(first), float(second)) if two else None
    if message is not None:
        return Say(message.decode("ascii"))
    build = _BARE.get(bare)
    return build() if build else None


def _known_to_11(command: Command) -> bool:
    if isinstance(command, Dash):
        return command.direction is None
    if isinstance(command, ChangeView):
        return command.quality is not None
    if isinstance(command, Tackle):
        return command.foul is None
    return not isinstance(command, (DashLegs, SynchSee, GaussianSee, ChangeFocus, LongKick))


def _scan_command(text: bytes, position: int) -> tuple[Command | None, int]:
    """Read one command token by token.

    Returns
    -------
    command : Command or None
        None when there is none, or when it is wrong.
    position : int
        Behind the command; the end of the text when nothing but white space is left; -1 after a syntax error.
    """
    kind, value, position = _token(text, position)
    if kind == _END:
        return None, position
    if kind == "u":
        return Say(str(value)), position
    if kind != "(":
        return None, -1
    kind, name, after = _token(text, position)
    if kind != "k":
        return None, -1
    kinds, values, after = _arguments(text, after)
    for form, build in _FORMS[str(name)]:
        if form.fullmatch(kinds):
            return build(values), after
    return _dash_legs(kinds, values, after) if name == "dash" else (None, -1)


def _arguments(text: bytes, position: int) -> tuple[str, list[Value], int]:
    """Read tokens up to the parenthesis that closes the command; position -1 when it is not found."""
    kinds: list[str] = []
    values: list[Value] = []
    depth = 0
    while True:
        kind, value, position = _token(text, position)
        depth += (kind == "(") - (kind == ")")
        if kind in (_END, _ERROR) or depth > 1:  # no form nests deeper
            return "".join(kinds) + _ERROR, values, -1
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


def _token(text: bytes, position: int) -> tuple[str, Value, int]:
    """Read the longest token: its kind, its value and the position behind it."""
    space = _SPACE.match(text, position)
    position = space.end() if space else position
    if position == len(text):
        return _END, "", position
    first = text[position : position + 1]
    if first == b"(":
        say = _UNQUOTED_SAY.match(text, position)
        if say:
            return "u", say.group(1).decode("ascii"), say.end()
    if first in (b"(", b")"):
        return (*_KINDS[first], position + 1)
    if first == b'"':
        quoted = _QUOTED.match(text, position)
        return ("s", quoted.group().decode("ascii"), quoted.end()) if quoted else (_ERROR, "", position)
    number, name = _NUMBER.match(text, position), _NAME.match(text, position)
    if number and (not name or number.end() >= name.end()):
        if number.group(2) or number.group(3):
            return "r", float(number.group()), number.end()
        return "i", to_int(number.group()), number.end()
    if name:
        return (*_KINDS.get(name.group(), ("s", name.group().decode("ascii"))), name.end())
    return _ERROR, "", position


def _without_quotes(text: str) -> str:
    return text[1:-1] if text.startswith('"') else text
