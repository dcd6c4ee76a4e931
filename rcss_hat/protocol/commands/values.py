"""Kinds of values that commands hold: how each is checked, spelled, and read by a server.

A record names the kind of a field in its type, ``power: Annotated[float, real(-100, 100)]``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from typing import Annotated, Any

from rcss_hat.protocol.records import MAX_PLAYERS, SAY_SIZE

INT_MAX = 2**31 - 1
_GREATEST = math.nextafter(math.inf, 0.0)
_SAY_CHARACTERS = re.compile(r"[0-9A-Za-z ().+\-*/?<>_]+")
_TEAM_NAME = re.compile(r"[A-Za-z0-9_-]{1,15}")
_SIXTEENTHS = 16  # monitors send positions as integers of 1/16 m


@dataclass(frozen=True, slots=True)
class Refusal:
    """What the server answers to a message it does not accept, for example ``(error illegal_command_form)``."""

    text: str


ILLEGAL_FORM = Refusal("(error illegal_command_form)")
ILLEGAL_OBJECT = Refusal("(error illegal_object_form)")
ILLEGAL_MODE = Refusal("(error illegal_mode)")
UNKNOWN_COMMAND = Refusal("(error unknown_command)")


def as_it_is(token: Any) -> Any:
    """Take a token for the value."""
    return token


def always(token: Any) -> bool:
    """Accept every token."""
    return True


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """A kind of value.

    Attributes
    ----------
    spell : callable
        Spells a legal value; gives the empty text for others.
    legal : str
        What would be right, for people.
    what : str
        What people are told the value is; empty: the field's name.
    complaint : str
        The error, of `what`, `legal` and the `value`.
    tokens : str
        Tokens that a player's command may have in its place, one letter for each (`tokens.py`).
    conversion : str
        What reads it in a trainer's or a monitor's command (`scanf.py`).
    read : callable
        Returns the value of what a server's scanner found.
    accepts : callable
        Tells whether a server takes what it found in a trainer's or a monitor's command.
    refusal : Refusal
        What the server answers when it does not.
    absent : object
        The value that leaves the field out of the message.
    size : int
        Of a text: most characters; 0: any number.
    parts : tuple of Kind
        Of a pair.
    """

    spell: Callable[..., str]
    legal: str
    what: str = ""
    complaint: str = "{what} must be {legal}, not {value!r}"
    tokens: str = ""
    conversion: str = ""
    read: Callable[[Any], Any] = as_it_is
    accepts: Callable[[Any], bool] = always
    refusal: Refusal = ILLEGAL_FORM
    absent: object = None
    size: int = 0
    parts: tuple[Kind, ...] = ()


def real(low: float = -_GREATEST, high: float = _GREATEST, what: str = "") -> Kind:
    """Return the kind of a finite number in a range, spelled so that the server reads the same number."""
    low, high = float(low), float(high)

    def spell(value: float) -> str:
        if not low <= value <= high:
            return ""
        text = repr(float(value))
        # An integer literal beyond 32 bits overflows in the server; with ".0" it is a real number.
        return text[:-2] if text.endswith(".0") and abs(value) <= INT_MAX else text

    legal = "a finite number" if low == -_GREATEST else f"a number from {low:g} to {high:g}"
    return Kind(spell=spell, legal=legal, what=what, tokens="ir", conversion="%lf", read=float)


def whole(low: int, high: int, what: str = "", accepts: Callable[[int], bool] = always) -> Kind:
    """Return the kind of an integer in a range; servers read any that they accept."""

    def spell(value: float) -> str:
        return str(int(value)) if low <= value <= high and value == int(value) else ""

    legal = f"an integer from {low} to {high}"
    return Kind(spell=spell, legal=legal, what=what, tokens="i", conversion="%d", accepts=accepts)


def _spell_sixteenths(metres: float) -> str:
    return str(round(metres * _SIXTEENTHS)) if -1000.0 <= metres <= 1000.0 else ""


def side(nobody: bool = False) -> Kind:
    """Return the kind of a side as monitors name it."""
    known = {1: "1 (left)", -1: "-1 (right)"} | ({0: "0 (nobody)"} if nobody else {})

    def spell(value: int) -> str:
        return str(int(value)) if value in known else ""

    return Kind(spell=spell, legal=" or ".join(known.values()), conversion="%d")


def word(known: Collection[str], what: str = "", tokens: str = "", conversion: str = "") -> Kind:
    """Return the kind of one of some words."""

    def is_known(value: str) -> bool:
        return value in known

    def spell(value: str) -> str:
        return value if value in known else ""

    legal = f"one of {', '.join(known)}"
    return Kind(spell=spell, legal=legal, what=what, tokens=tokens, conversion=conversion, accepts=is_known)


def mark(text: str) -> Kind:
    """Return the kind of a text that stands in the message, or not."""
    return Kind(spell=lambda value: text, legal="True or False", absent=False)


def message(size: int) -> Kind:
    """Return the kind of a text to be heard, which the server would neither refuse nor drop nor cut."""
    fits = _SAY_CHARACTERS.fullmatch

    def spell(value: str, most: int = size) -> str:
        return value if len(value) <= most and fits(value) else ""

    return Kind(
        spell=spell, legal="letters, digits, spaces and ().+-*/?<>_ and is not empty", size=size, tokens="s",
        complaint="a message has {legal}, not {value!r}", read=_without_quotes,
    )  # fmt: skip


def _without_quotes(text: str) -> str:
    return text[1:-1] if text.startswith('"') else text


def pair(first: Kind, second: Kind, before: str = "", after: str = "") -> Kind:
    """Return the kind of two numbers, between two texts."""

    def spell(value: tuple[float, float]) -> str:
        texts = first.spell(value[0]), second.spell(value[1])
        return f"{before}{texts[0]} {texts[1]}{after}" if all(texts) else ""

    return Kind(spell=spell, legal=f"{first.legal} and {second.legal}", parts=(first, second))


def leg(name: str) -> Kind:
    """Return the kind of what one leg does: power and direction."""
    power, direction = real(-100, 100, f"power of leg {name}"), real(-180, 180, f"direction of leg {name}")
    return pair(power, direction, f"({name} ", ")")


Power = Annotated[float, real(-100, 100)]
Degrees = Annotated[float, real(-180, 180)]
Metres = Annotated[float, real()]
Velocity = Annotated[tuple[float, float], pair(real(what="velocity"), real(what="velocity"))]
Sixteenths = Annotated[
    float,
    Kind(
        spell=_spell_sixteenths, legal="a number from -1000 to 1000", conversion="%d",
        read=lambda sixteenths: sixteenths / _SIXTEENTHS,
    ),
]  # fmt: skip
"""Metres."""
Unum = Annotated[int, whole(1, MAX_PLAYERS, "uniform number")]
Team = Annotated[
    str,
    Kind(
        spell=lambda value: value if _TEAM_NAME.fullmatch(value) else "", tokens="tls", conversion="%127s",
        legal="1 to 15 letters, digits, '-' and '_' without spaces",
        complaint="a team name has {legal}, not {value!r}",
    ),
]  # fmt: skip
_SWITCH = Kind(
    spell=lambda value: "on" if value else "off", legal="True or False", tokens="of", conversion="%15[^ ()]",
    accepts=lambda token: token in ("on", "off"), read=lambda token: token in (True, "on"),
)  # fmt: skip
Switch = Annotated[bool, _SWITCH]
Foul = Annotated[bool, replace(_SWITCH, tokens="ofb")]
Heard = Annotated[str, message(SAY_SIZE)]
