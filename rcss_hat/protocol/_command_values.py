"""Checks and spelling of command arguments."""

from __future__ import annotations

import math
import re
from collections.abc import Collection

from rcss_hat.protocol.errors import LocalProtocolError
from rcss_hat.protocol.records import MAX_PLAYERS

_SAY_CHARACTERS = re.compile(r"[0-9A-Za-z ().+\-*/?<>_]+")
_TEAM_NAME = re.compile(r"[A-Za-z0-9_-]{1,15}")


def real(command: str, what: str, value: float, low: float = -math.inf, high: float = math.inf) -> str:
    """Spell a number so that the server reads the same number; refuse what is outside the range.

    Raises
    ------
    LocalProtocolError
        When the value is not finite or not in [low, high].
    """
    if not math.isfinite(value) or not low <= value <= high:
        limits = "a finite number" if math.isinf(low) else f"a number from {low:g} to {high:g}"
        raise LocalProtocolError(f"{command}: {what} must be {limits}, not {value!r}")
    text = repr(float(value))
    # An integer literal beyond 32 bits overflows in the server; with ".0" it is a real number.
    return text[:-2] if text.endswith(".0") and abs(value) < 2**31 else text


def whole(command: str, what: str, value: float, low: int, high: int) -> str:
    """Spell an integer.

    Raises
    ------
    LocalProtocolError
        When the value is no integer in [low, high].
    """
    if not low <= value <= high or value != int(value):
        raise LocalProtocolError(f"{command}: {what} must be an integer from {low} to {high}, not {value!r}")
    return str(int(value))


def unum(command: str, value: int) -> str:
    """Spell a uniform number."""
    return whole(command, "uniform number", value, 1, MAX_PLAYERS)


def one_of(command: str, what: str, value: str, known: Collection[str]) -> str:
    """Refuse a word that is not known."""
    if value not in known:
        raise LocalProtocolError(f"{command}: {what} must be one of {', '.join(known)}, not {value!r}")
    return value


def on_off(value: bool) -> str:
    """Spell a switch."""
    return "on" if value else "off"


def team_name(command: str, value: str) -> str:
    """Refuse a team name that some server would refuse."""
    if not _TEAM_NAME.fullmatch(value):
        raise LocalProtocolError(
            f"{command}: a team name has 1 to 15 letters, digits, '-' and '_' without spaces, not {value!r}"
        )
    return value


def message(command: str, value: str, size: int) -> str:
    """Refuse a text that the server would refuse, drop or cut."""
    if not _SAY_CHARACTERS.fullmatch(value):
        raise LocalProtocolError(
            f"{command}: a message has letters, digits, spaces and ().+-*/?<>_ and is not empty, not {value!r}"
        )
    if len(value) > size:
        raise LocalProtocolError(f"{command}: a message has at most {size} characters, {value!r} has {len(value)}")
    return value
