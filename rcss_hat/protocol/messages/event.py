"""What all events have: records, and tables of who reads what.

An event whose fields follow its name in their order, each of a known kind, is read and written by the table alone:

>>> @event("score")
... class Score(Event):
...     time: Whole
...     ours: Whole
...     theirs: Whole

Others have a reader of their own, marked by `reads`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Annotated, Any, NamedTuple, TypeVar, dataclass_transform, get_args, get_type_hints

from rcss_hat.protocol.messages.groups import Group
from rcss_hat.protocol.records import MAX_PLAYERS

SIDES = ("l", "r")


class Event:
    """Something a server said."""

    __slots__ = ()

    def to_text(self) -> str:
        """Return the message as text, without NUL."""
        raise NotImplementedError


Record = TypeVar("Record", bound=Event)
Reader = Callable[[Group], Event]
BY_GROUP: dict[bytes, Reader] = {}
"""Readers by the first word of a message."""
BY_BYTES: dict[bytes, Callable[[bytes, str], Event]] = {}
"""Readers of what comes often, and of speech, which may hold parentheses, too; they get the own team's name."""


class Kind(NamedTuple):
    """A kind of value: what takes it from a group, and what spells it (as the empty text, when it is left out)."""

    take: Callable[[Group], Any]
    spell: Callable[[Any], str] = str


@dataclass_transform(kw_only_default=True, frozen_default=True)
def record(cls: type[Record]) -> type[Record]:
    """Make a class a frozen record whose fields are given by name."""
    return dataclasses.dataclass(frozen=True, slots=True, kw_only=True)(cls)


@dataclass_transform(kw_only_default=True, frozen_default=True)
def event(name: str) -> Callable[[type[Record]], type[Record]]:
    """Make a class the record of a message, with the fields' kinds in the order in which they follow the name."""

    def add(cls: type[Record]) -> type[Record]:
        made = record(cls)
        hints = get_type_hints(cls, include_extras=True)
        kinds = {field.name: get_args(hints[field.name])[1] for field in dataclasses.fields(made)}  # type: ignore[arg-type]

        # made of a text, as dataclasses make their methods: messages come in every cycle
        arguments = ", ".join(f"{field}=take_{field}(group)" for field in kinds)
        takes = {f"take_{field}": kind.take for field, kind in kinds.items()}
        reads(name)(eval(f"lambda group: made({arguments})", {"made": made, **takes}))

        def to_text(self: Record) -> str:
            words = [kind.spell(getattr(self, field)) for field, kind in kinds.items()]
            return f"({' '.join([name, *filter(None, words)])})"

        made.to_text = to_text  # type: ignore[assignment, method-assign]
        return made

    return add


def reads(name: str) -> Callable[[Reader], Reader]:
    """Mark the reader of a message that has a form of its own."""
    first, _, second = name.partition(" ")

    def add(read: Reader) -> Reader:
        BY_GROUP[first.encode()] = _by_second(second, read, BY_GROUP[first.encode()]) if second else read
        return read

    return add


def _by_second(second: str, read: Reader, otherwise: Reader) -> Reader:
    """Return what reads messages with a second word by one reader, and others by another."""

    def choose(group: Group) -> Event:
        if group.peek() != second:
            return otherwise(group)
        group.word()
        return read(group)

    return choose


def _rest(group: Group) -> str:
    """Take all that is left as it was written."""
    if not group.more:
        return ""
    start = group.positions[group.next]
    end = group.data.rindex(b")")
    group.next = len(group.items)
    return group.data[start:end].decode("latin-1").rstrip()


def optional(value: object) -> str:
    """Spell a value that may be None, and is left out then."""
    return "" if value is None else str(value)


Word = Annotated[str, Kind(Group.word)]
Whole = Annotated[int, Kind(Group.integer)]
Unum = Annotated[int, Kind(lambda group: group.integer(1, MAX_PLAYERS))]
Side = Annotated[str, Kind(lambda group: group.word(*SIDES))]
Rest = Annotated[str, Kind(_rest)]
