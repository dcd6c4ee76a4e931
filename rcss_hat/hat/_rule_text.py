"""The printed form of rules in the HAT paper: writing conditions, reading rules."""

from __future__ import annotations

import re
from typing import NamedTuple, NoReturn

from rcss_hat.hat.conditions import AT_LEAST, AT_MOST, Condition
from rcss_hat.hat.files import FileFormatError

ParsedRule = tuple[tuple[Condition, ...], int]
"""Conditions and action."""

_TOKEN = re.compile(
    r"""(?P<skip>\s+|\#[^\n]*)
      | (?P<variable>state_?\{?(?P<index>\d+)\}?)
      | (?P<word>[A-Za-z_]\w*)
      | (?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)
      | (?P<at_most><=|≤)
      | (?P<at_least>>=|≥)
      | (?P<arrow>->|→|=>)
      | (?P<sign>[()=])""",
    re.VERBOSE | re.IGNORECASE,
)
_PASS = re.compile(r"pass(\d+)")


class _Token(NamedTuple):
    kind: str
    text: str
    value: str
    line: int


def rule_text(conditions: tuple[Condition, ...], digits: int | None = None) -> str:
    """Write conditions: ``state_11 >= 74.84 and state_3 <= 5.99``."""
    return " and ".join(f"state_{c.feature} {c.operator} {_number(c.threshold, digits)}" for c in conditions)


def _number(value: float, digits: int | None) -> str:
    return repr(value) if digits is None else f"{value:.{digits}f}"


def parse_rules(text: str) -> list[ParsedRule]:
    """Read rules; the last one is the default, without conditions.

    Raises
    ------
    FileFormatError
    """
    return _Parser(_tokens(text)).rules()


def _tokens(text: str) -> list[_Token]:
    tokens = []
    position, line = 0, 1
    while position < len(text):
        match = _TOKEN.match(text, position)
        if match is None:
            hint = "; a bound is written <= or >=" if text[position] in "<>" else ""
            raise FileFormatError(f"line {line}: {text[position]!r} has no meaning in rules{hint}")
        kind = match.lastgroup if match["variable"] is None else "variable"
        if kind != "skip":
            tokens.append(_Token(str(kind), match[0], match["index"] or match[0].lower(), line))
        line += match[0].count("\n")
        position = match.end()
    tokens.append(_Token("end", "the end of the text", "", line))
    return tokens


class _Parser:
    """Recursive descent over the tokens: rules, conditions, actions."""

    def __init__(self, tokens: list[_Token]) -> None:
        self.tokens = tokens
        self.at = 0

    def rules(self) -> list[ParsedRule]:
        rules: list[ParsedRule] = []
        while not self.take("word", "else"):
            if not rules:
                self.need("'if (' or 'else ->'", "word", "if")
            elif not self.take("word", "elseif") and not self.take("word", "elif"):
                self.fail("'elseif (' or 'else ->'")
            rules.append((self.conditions(), self.action()))
            if self.peek("word", "else") and self.tokens[self.at + 1].value == "if":
                self.at += 1
                self.tokens[self.at] = self.tokens[self.at]._replace(value="elseif")
        rules.append(((), self.action()))
        self.need("nothing more after the default action", "end")
        return rules

    def conditions(self) -> tuple[Condition, ...]:
        self.need("'('", "sign", "(")
        conditions = [self.condition()]
        while self.take("word", "and"):
            conditions.append(self.condition())
        self.need("'and' or ')'", "sign", ")")
        return tuple(conditions)

    def condition(self) -> Condition:
        feature = self.need("a state variable, for example state_3", "variable")
        if self.take("at_most"):
            operator = AT_MOST
        else:
            self.need("'<=' or '>='", "at_least")
            operator = AT_LEAST
        token = self.need("a number", "number")
        try:
            return Condition(int(feature.value), operator, float(token.value))
        except ValueError as error:
            raise FileFormatError(f"line {token.line}: {error}") from error

    def action(self) -> int:
        self.need("'->'", "arrow")
        self.need("'Action = '", "word", "action")
        self.need("'='", "sign", "=")
        named = self.tokens[self.at]
        passing = _PASS.fullmatch(named.value)
        if named.kind == "word" and (named.value == "hold" or passing):
            self.at += 1
            return int(passing[1]) if passing else 0
        token = self.need("a whole number, Hold, PASS1, ...", "number")
        if not token.value.isdigit():
            self.at -= 1
            self.fail("a whole number, Hold, PASS1, ...")
        return int(token.value)

    def peek(self, kind: str, value: str | None = None) -> bool:
        token = self.tokens[self.at]
        return token.kind == kind and value in (None, token.value)

    def take(self, kind: str, value: str | None = None) -> bool:
        found = self.peek(kind, value)
        self.at += found
        return found

    def need(self, expected: str, kind: str, value: str | None = None) -> _Token:
        if not self.take(kind, value):
            self.fail(expected)
        return self.tokens[self.at - 1]

    def fail(self, expected: str) -> NoReturn:
        token = self.tokens[self.at]
        found = token.text if token.kind == "end" else repr(token.text)
        raise FileFormatError(f"line {token.line}: expected {expected}, found {found}")
