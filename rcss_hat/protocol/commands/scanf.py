"""C's ``sscanf`` for the formats that rcssserver reads trainer, monitor and init messages with.

Matching those formats, rather than a tidy grammar, is what accepts and refuses the same texts as the server does:
missing closing parentheses, blanks in odd places, hexadecimal numbers.
"""

from __future__ import annotations

import math
import re
from typing import NamedTuple

_DIRECTIVE = re.compile(r"\s+|%(\d*)(d|lf|s|n|\[\^?\]?[^\]]*\])|[^%\s]+")
_SPACE = re.compile(r"[ \t\n\v\f\r]*")
_DECIMAL = re.compile(r"[+-]?[0-9]+")
# glibc takes one character ahead for sure: "1e" and "1e+" are read as 1, but "0x" and "infi" are no numbers.
_REAL = re.compile(
    r"(?P<sign>[+-]?)(?:(?P<hexadecimal>0x(?:[0-9a-f]+\.?[0-9a-f]*|\.[0-9a-f]+)(?:p[+-]?[0-9]+)?)(?:p[+-]?)?"
    r"|(?P<decimal>(?!0x)(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:e[+-]?[0-9]+)?)(?:e[+-]?)?|(?P<word>inf(?:inity|(?!i))|nan))",
    re.IGNORECASE | re.ASCII,
)
Converted = str | float | int


class Scanned(NamedTuple):
    """What a format found in a text.

    Attributes
    ----------
    values : list
        One entry per conversion, up to the first that failed.
    read : int
        Where ``%n`` stood in the text; 0 when it was not reached.
    exhausted : bool
        Whether the text ended before the first conversion (``sscanf`` returns EOF).
    """

    values: list[Converted]
    read: int
    exhausted: bool


class Scanf:
    """A compiled format.

    Parameters
    ----------
    form : str
        White space, literal text and the conversions ``%d``, ``%lf``, ``%s``, ``%[...]``, ``%n``, with widths.
    """

    def __init__(self, form: str) -> None:
        self._steps: list[tuple[str, re.Pattern[str]]] = []
        for match in _DIRECTIVE.finditer(form):
            width, kind = match.groups()
            if kind is None:
                text = match.group()
                literal = _SPACE if text.isspace() else re.compile(re.escape(text))
                self._steps.append(("space" if text.isspace() else "literal", literal))
            elif kind == "d":
                self._steps.append(("d", _DECIMAL))
            elif kind == "lf":
                self._steps.append(("lf", _REAL))
            elif kind == "n":
                self._steps.append(("n", _SPACE))
            else:
                characters = r"[^ \t\n\v\f\r]" if kind == "s" else kind
                most = width or ""
                self._steps.append((kind[0], re.compile(f"{characters}{{1,{most}}}")))

    def scan(self, text: str) -> Scanned:
        """Match a text from its beginning."""
        values: list[Converted] = []
        position = read = 0
        for kind, pattern in self._steps:
            if kind == "n":
                read = position
                continue
            if kind in ("d", "lf", "s"):
                position = _behind(_SPACE, text, position)
            match = pattern.match(text, position)
            if match is None:
                return Scanned(values, read, not values and _ended(kind, pattern, text, position))
            position = match.end()
            if kind == "d":
                values.append(to_int(match.group()))
            elif kind == "lf":
                values.append(_to_real(match))
            elif kind in ("s", "["):
                values.append(match.group())
        return Scanned(values, read, False)


def _behind(pattern: re.Pattern[str], text: str, position: int) -> int:
    match = pattern.match(text, position)
    return match.end() if match else position


def _ended(kind: str, pattern: re.Pattern[str], text: str, position: int) -> bool:
    """Tell whether a directive failed because the text ended, perhaps in the middle of a literal."""
    rest = text[position:]
    return not rest or (kind == "literal" and re.sub(r"\\(.)", r"\1", pattern.pattern).startswith(rest))


def to_int(digits: bytes | str) -> int:
    """Read an integer as C's ``atoi`` does where servers run: clamped to 64 bits, then cut to 32 bits."""
    text = digits.decode("ascii") if isinstance(digits, bytes) else digits
    if len(text) > 40:  # Python refuses to read very long integers; so many digits are clamped unless most are zeros.
        sign = "-" if text.startswith("-") else ""
        text = sign + (text.lstrip("+-").lstrip("0")[:40] or "0")
    value = min(max(int(text), -(2**63)), 2**63 - 1)
    return (value + 2**31) % 2**32 - 2**31


def _to_real(number: re.Match[str]) -> float:
    if number["hexadecimal"] is None:
        return float(number["sign"] + (number["decimal"] or number["word"]))
    try:
        return float.fromhex(number["sign"] + number["hexadecimal"])
    except OverflowError:
        return -math.inf if number["sign"] == "-" else math.inf
