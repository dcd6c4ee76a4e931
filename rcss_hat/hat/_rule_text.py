"""The printed forms of rules: the HAT paper's, which is written and read, and Weka's JRip's, which is read.

JRip prints no numbers for the actions one by one, only how much weight a rule covers and how much of it is wrong.
"""

from __future__ import annotations

import math
import re
from typing import NamedTuple, NoReturn

from rcss_hat.hat.conditions import AT_LEAST, AT_MOST, Condition, each_bound_once
from rcss_hat.inputs import FileFormatError, excerpt

_MAX_DIGITS = 6
"""Of a variable's or an action's number."""
MAX_WEIGHT = 1e15
"""Of the training rows that a rule decides, far beyond any."""

_TOKEN = re.compile(
    r"""(?P<skip>\s+|\#[^\n]*)
      | (?P<variable>(?:state|s)_?\{?(?P<index>\d+)\}?(?!\w))
      | (?P<word>[A-Za-z_]\w*)
      | (?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)
      | (?P<at_most><=|≤)
      | (?P<at_least>>=|≥)
      | (?P<below><)
      | (?P<arrow>->|→|=>)
      | (?P<above>>)
      | (?P<sign>[()=/])""",
    re.VERBOSE | re.IGNORECASE,
)
_PASS = re.compile(r"pass(\d+)")
_JRIP_HEAD = re.compile(r"^[ \t]*JRIP rules:[ \t]*\n(?:[ \t]*=+[ \t]*\n)?", re.MULTILINE | re.IGNORECASE)
_JRIP_END = re.compile(r"^[ \t]*Number of Rules[ \t]*:[ \t]*(\d+)[ \t]*$", re.MULTILINE | re.IGNORECASE)


class ParsedRule(NamedTuple):
    """A rule as it was printed.

    Attributes
    ----------
    conditions : tuple of Condition
    action : int
    covered, wrong : float or None
        Weight of the training rows it covers, and of those with another action; None where that was not printed.
    """

    conditions: tuple[Condition, ...]
    action: int
    covered: float | None = None
    wrong: float | None = None


class _Token(NamedTuple):
    kind: str
    text: str
    value: str
    line: int


def rule_text(conditions: tuple[Condition, ...], digits: int | None = None) -> str:
    """Write conditions, each bound once: ``state_11 >= 74.84 and state_3 <= 5.99``."""
    return " and ".join(f"state_{c.feature} {_bound(c, digits)}" for c in each_bound_once(conditions))


def _bound(condition: Condition, digits: int | None) -> str:
    """Write operator and threshold; the largest number below 5 is not written ``<= 4.999999999999999`` but ``< 5``."""
    operator, threshold = condition.operator, condition.threshold
    if digits is not None:
        return f"{operator} {threshold:.{digits}f}"
    beyond = math.nextafter(threshold, math.inf if operator == AT_MOST else -math.inf)
    if not math.isfinite(beyond):
        return f"{operator} {_number(threshold)}"
    with_it, without_it = f"{operator} {_number(threshold)}", f"{operator[0]} {_number(beyond)}"
    return without_it if len(without_it) + 1 < len(with_it) else with_it


def _number(value: float) -> str:
    return repr(value).removesuffix(".0")


def parse_rules(text: str) -> list[ParsedRule]:
    """Read rules; the last one is the default, without conditions.

    Parameters
    ----------
    text : str
        As the HAT paper prints them; or as Weka prints JRip's, with or without everything around them.

    Raises
    ------
    FileFormatError
    """
    head = _JRIP_HEAD.search(text)
    begin = head.end() if head else 0
    end = _JRIP_END.search(text, begin)
    body = text[begin : end.start() if end else len(text)]
    parser = _Parser(_tokens(body, 1 + text.count("\n", 0, begin)))
    if not (head or end or parser.peek("sign", "(") or parser.peek("arrow")):
        return parser.rules()
    rules = parser.jrip_rules()
    if end and int(end[1][:_MAX_DIGITS]) != len(rules):
        raise FileFormatError(f"it says that there are {end[1][:_MAX_DIGITS]} rules, but has {len(rules)}")
    return rules


def _tokens(text: str, line: int = 1) -> list[_Token]:
    tokens = []
    position = 0
    while position < len(text):
        match = _TOKEN.match(text, position)
        if match is None:
            raise FileFormatError(f"line {line}: {text[position]!r} has no meaning in rules")
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
            rules.append(ParsedRule(self.conditions(), self.action()))
            if self.peek("word", "else") and self.tokens[self.at + 1].value == "if":
                self.at += 1
                self.tokens[self.at] = self.tokens[self.at]._replace(value="elseif")
        rules.append(ParsedRule((), self.action()))
        self.need("nothing more after the default action", "end")
        return rules

    def jrip_rules(self) -> list[ParsedRule]:
        rules: list[ParsedRule] = []
        while not rules or rules[-1].conditions:
            conditions: list[Condition] = []
            while self.take("sign", "("):
                conditions.append(self.condition())
                self.need("')'", "sign", ")")
                if not self.take("word", "and"):
                    break
            self.need("'(state_... ) and ... => Action=...' or ' => Action=...', as JRip prints rules", "arrow")
            self.need("'Action='", "word")
            self.need("'='", "sign", "=")
            rules.append(ParsedRule(tuple(conditions), self.named_action(), *self.jrip_weights()))
        self.need("nothing more after the default action", "end")
        return rules

    def jrip_weights(self) -> tuple[float | None, float | None]:
        """Read ``(30.0/2.0)``: weight covered, and of that wrong."""
        if not self.take("sign", "("):
            return None, None
        covered = self.need("a weight", "number")
        wrong = self.need("a weight", "number").value if self.take("sign", "/") else "0"
        self.need("')'", "sign", ")")
        numbers = float(covered.value), float(wrong)
        if not 0.0 <= numbers[1] <= numbers[0] < MAX_WEIGHT:
            raise FileFormatError(
                f"line {covered.line}: ({covered.value}/{wrong}) must be the weight a rule covers, and how much of it "
                "is wrong"
            )
        return numbers

    def conditions(self) -> tuple[Condition, ...]:
        self.need("'('", "sign", "(")
        conditions = [self.condition()]
        while self.take("word", "and"):
            conditions.append(self.condition())
        self.need("'and' or ')'", "sign", ")")
        return tuple(conditions)

    def condition(self) -> Condition:
        feature = self.need("a state variable, for example state_3", "variable")
        strict = self.peek("below") or self.peek("above")
        if self.take("at_most") or self.take("below"):
            operator = AT_MOST
        else:
            if not self.take("above"):
                self.need("'<=' or '>='", "at_least")
            operator = AT_LEAST
        token = self.need("a number", "number")
        threshold = float(token.value)
        if strict:
            threshold = math.nextafter(threshold, -math.inf if operator == AT_MOST else math.inf)
        try:
            return Condition(self.index(feature), operator, threshold)
        except ValueError as error:
            raise FileFormatError(f"line {token.line}: {error}") from error

    def action(self) -> int:
        self.need("'->'", "arrow")
        self.need("'Action = '", "word", "action")
        self.need("'='", "sign", "=")
        return self.named_action()

    def named_action(self) -> int:
        named = self.tokens[self.at]
        passing = _PASS.fullmatch(named.value)
        if named.kind == "word" and (named.value == "hold" or passing):
            self.at += 1
            return self.index(named._replace(value=passing[1])) if passing else 0
        token = self.need("a whole number, Hold, PASS1, ...", "number")
        if not token.value.isdecimal():
            self.at -= 1
            self.fail("a whole number, Hold, PASS1, ...")
        return self.index(token)

    def index(self, token: _Token) -> int:
        """Return the number of a variable or an action."""
        if len(token.value) > _MAX_DIGITS:
            raise FileFormatError(f"line {token.line}: {excerpt(token.text)} does not exist")
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
        found = token.text if token.kind == "end" else excerpt(token.text)
        raise FileFormatError(f"line {token.line}: expected {expected}, found {found}")
