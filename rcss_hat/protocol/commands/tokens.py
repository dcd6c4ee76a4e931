"""The scanner of players' commands (19.0.0, src/player_command_tok.lpp).

It takes the longest token at every place and, of equally long ones, the first of: an unquoted say, parentheses,
keywords, integers, reals, names. That rule makes ``(say hi)(done)`` one command, ``10-20`` a name and ``10+20`` two
numbers.

Every kind of token has a letter: i integer, r real, s name or quoted text, u unquoted say, k name of a command, w view
width, q view quality, o on, f off, b true or false, t our or opp, l left or right, m kind of hearing, v ver, and the
parentheses themselves.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from rcss_hat.protocol.commands.scanf import to_int
from rcss_hat.protocol.commands.table import PLAYER

Value = float | int | str
MESSAGE = rb"[0-9A-Za-z().+\-*/?<>_ ]+"
END, ERROR = "$", "!"

_SPACE = re.compile(rb"[ \t\n]*")
_UNQUOTED_SAY = re.compile(rb"\(say (%b)\)" % MESSAGE)
_QUOTED = re.compile(rb'"%b"' % MESSAGE)
_NUMBER = re.compile(rb"([+-]?(?:(\d*\.\d+)|\d+))([eE][+-]?\d+)?")
_NAME = re.compile(rb"[\-_a-zA-Z0-9]+")
_KEYWORDS: dict[str, tuple[str, Value]] = {
    "narrow": ("w", "narrow"), "normal": ("w", "normal"), "wide": ("w", "wide"), "low": ("q", "low"),
    "high": ("q", "high"), "on": ("o", True), "off": ("f", False), "true": ("b", True), "false": ("b", False),
    "our": ("t", "our"), "opp": ("t", "opp"), "left": ("l", "l"), "right": ("l", "r"), "l": ("l", "l"),
    "r": ("l", "r"), "partial": ("m", "partial"), "complete": ("m", "complete"), "p": ("m", "partial"),
    "c": ("m", "complete"), "ver": ("v", "ver"),
}  # fmt: skip


def tokens(text: bytes) -> Iterator[tuple[str, Value]]:
    """Yield letter and value of every token of a text."""
    kind, value, position = token(text, 0)
    while kind != END:
        yield kind, value
        kind, value, position = token(text, position)


def token(text: bytes, position: int) -> tuple[str, Value, int]:
    """Read the longest token: its letter, its value and the position behind it."""
    space = _SPACE.match(text, position)
    position = space.end() if space else position
    if position == len(text):
        return END, "", position
    first = text[position : position + 1]
    if first == b"(":
        say = _UNQUOTED_SAY.match(text, position)
        if say:
            return "u", say.group(1).decode("ascii"), say.end()
    if first in (b"(", b")"):
        letter = first.decode()
        return letter, letter, position + 1
    if first == b'"':
        quoted = _QUOTED.match(text, position)
        return ("s", quoted.group().decode("ascii"), quoted.end()) if quoted else (ERROR, "", position)
    number, name = _NUMBER.match(text, position), _NAME.match(text, position)
    if number and (not name or number.end() >= name.end()):
        if number.group(2) or number.group(3):
            return "r", float(number.group()), number.end()
        return "i", to_int(number.group()), number.end()
    if name:
        return (*_word(name.group().decode("ascii")), name.end())
    return ERROR, "", position


def _word(text: str) -> tuple[str, Value]:
    return _KEYWORDS.get(text) or ("k" if text in PLAYER.forms else "s", text)
