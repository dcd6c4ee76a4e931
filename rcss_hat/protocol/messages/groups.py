"""Server messages as nested groups: ``(name value (name value) ...)``.

The server writes everything but speech in this form. A `Group` is read once into items and then consumed from left to
right; whatever does not fit raises an error that names the place.
"""

from __future__ import annotations

import re
from typing import NoReturn

from rcss_hat.protocol.errors import RemoteProtocolError

_TOKEN = re.compile(rb'[ \t\r\n]*(?:([()])|"([^"\0]*)"|([^ \t\r\n()"\0]+))')
_END = re.compile(rb"[ \t\r\n]*(?:\0|$)")
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?")
_INTEGER = re.compile(r"-?[0-9]{1,18}")


class Quoted(str):
    """Text that stood in double quotes."""

    __slots__ = ()


Item = "str | Quoted | Group"


class Group:
    """What stands between two parentheses, read from left to right.

    Attributes
    ----------
    data : bytes
        The whole message.
    start : int
        Index of the group's opening parenthesis.
    items, positions : list
        Words, quoted texts and groups, and where each stands.
    next : int
        Index of the item to be read next.
    """

    __slots__ = ("data", "items", "next", "positions", "start")

    def __init__(self, data: bytes, start: int) -> None:
        self.data = data
        self.start = start
        self.items: list[str | Quoted | Group] = []
        self.positions: list[int] = []
        self.next = 0

    def fail(self, reason: str) -> NoReturn:
        """Raise an error at the item to be read next, or at the group's beginning when there is none."""
        position = self.positions[self.next] if self.next < len(self.items) else self.start
        raise RemoteProtocolError(reason, self.data, position)

    @property
    def more(self) -> bool:
        """Whether there is anything left."""
        return self.next < len(self.items)

    def finish(self) -> None:
        """Refuse what is left."""
        if self.more:
            self.fail("unexpected value")

    def peek(self) -> str | Quoted | Group | None:
        """Return the next item without taking it; None at the end."""
        return self.items[self.next] if self.more else None

    def text(self) -> str:
        """Take a word or a quoted text."""
        item = self.peek()
        if item is None or isinstance(item, Group):
            self.fail("expected a word")
        self.next += 1
        return str(item)

    def word(self, *known: str) -> str:
        """Take a word without quotes; one of those given, if any are."""
        item = self.peek()
        if item is None or isinstance(item, (Quoted, Group)) or (known and item not in known):
            self.fail(f"expected {' or '.join(known)}" if known else "expected a word")
        self.next += 1
        return item

    def number(self) -> float:
        """Take a finite number."""
        item = self.peek()
        if isinstance(item, str) and not isinstance(item, Quoted) and _NUMBER.fullmatch(item):
            value = float(item)
            if abs(value) <= 1.7976931348623157e308:
                self.next += 1
                return value
        self.fail("expected a number")

    def numbers(self) -> list[float]:
        """Take all numbers up to something else."""
        values = []
        while self.more and is_number(self.items[self.next]):
            values.append(self.number())
        return values

    def integer(self, low: int = -(2**31), high: int = 2**31 - 1) -> int:
        """Take an integer in a range."""
        item = self.peek()
        if isinstance(item, str) and not isinstance(item, Quoted) and _INTEGER.fullmatch(item):
            value = int(item)
            if low <= value <= high:
                self.next += 1
                return value
        self.fail(f"expected an integer from {low} to {high}")

    def group(self, *names: str) -> Group:
        """Take a group; with names, one that begins with one of them, and the name is taken too."""
        item = self.peek()
        if not isinstance(item, Group) or (names and not item.is_called(*names)):
            self.fail(f"expected ({'... or ('.join(names)}...)" if names else "expected a group")
        if names:
            item.next = 1
        self.next += 1
        return item

    def is_called(self, *names: str) -> bool:
        """Tell whether the group's first item is one of some words."""
        return bool(self.items) and isinstance(self.items[0], str) and self.items[0] in names

    def has_group(self, *names: str) -> bool:
        """Tell whether the next item is a group of one of some names (of any name, when none is given)."""
        item = self.peek()
        return isinstance(item, Group) and (not names or item.is_called(*names))


def is_number(item: object) -> bool:
    """Tell whether an item is a word that spells a number."""
    return isinstance(item, str) and not isinstance(item, Quoted) and _NUMBER.fullmatch(item) is not None


def read_group(data: bytes) -> Group:
    """Read a whole message.

    Raises
    ------
    RemoteProtocolError
        When it is not exactly one group, up to its end or the first NUL.
    """
    if data[:1] != b"(":
        raise RemoteProtocolError("expected '('", data, 0)
    current = Group(data, 0)
    parents: list[Group] = []
    position = 1
    while True:
        token = _TOKEN.match(data, position)
        if token is None:
            raise RemoteProtocolError("expected ')'", data, position)
        parenthesis, quoted, word = token.groups()
        position = token.end()
        if parenthesis == b"(":
            parents.append(current)
            current = Group(data, position - 1)
        elif parenthesis == b")":
            if not parents:
                break
            parent = parents.pop()
            parent.items.append(current)
            parent.positions.append(current.start)
            current = parent
        else:
            current.items.append(word.decode("latin-1") if quoted is None else Quoted(quoted, "latin-1"))
            current.positions.append(token.start(2) - 1 if quoted is not None else token.start(3))
    if not _END.match(data, position):
        raise RemoteProtocolError("unexpected text behind the message", data, position)
    return current
