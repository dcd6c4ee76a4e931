"""The table of commands: one row for each, from which its writer, the servers' readers and its help follow.

A row is a record with its wire forms. ``{field}`` in a form stands for a field of the record, whose kind (`values`)
stands in the field's type::

    @command(PLAYER, "(dash {power})", later=["(dash {power} {direction})"])
    class Dash(Command):
        power: Power
        direction: Degrees | None = None

The form that has exactly the fields that are not `Kind.absent` is the one that is sent.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, ClassVar, NoReturn, TypeVar, dataclass_transform, get_args, get_type_hints

from rcss_hat.protocol.commands.scanf import Scanf
from rcss_hat.protocol.commands.values import ILLEGAL_FORM, Kind, Refusal, always, as_it_is
from rcss_hat.protocol.errors import LocalProtocolError

_FIELD = re.compile(r"\{(\w+)\}")
_WORD = re.compile(r"\{\w+\}|[()]|[^\s(){}]+")


class Command:
    """Something a client may send."""

    __slots__ = ()
    alone: ClassVar[bool] = False
    """Whether the command needs a datagram of its own."""

    def text(self, size: int | None = None) -> str:
        """Return the command as text, without NUL.

        Parameters
        ----------
        size : int, optional
            Longest message that the server takes (``say_msg_size``, ``say_coach_msg_size``), if not its default.

        Raises
        ------
        LocalProtocolError
            When an argument is illegal.
        """
        raise NotImplementedError

    def to_bytes(self) -> bytes:
        """Return the command as bytes, without NUL; see `text`."""
        return self.text().encode("ascii")


@dataclasses.dataclass(frozen=True)
class Form:
    """One way to spell a command.

    Attributes
    ----------
    text : str
    record : type
        Whose fields the text names.
    kinds : dict
        Kind of each field named, in the text's order.
    later : bool
        Whether server 11.1 does not know it.
    """

    text: str
    record: type[Command]
    kinds: dict[str, Kind]
    later: bool

    @property
    def name(self) -> str:
        """The first word."""
        return _WORD.findall(self.text)[1]

    @property
    def scanf(self) -> Scanf:
        """The format with which servers read it from trainers and monitors."""
        words = _WORD.findall(self.text)
        return Scanf(f" {' '.join(self.kinds[word[1:-1]].conversion if word[0] == '{' else word for word in words)} ")

    def builder(self, places: Sequence[int]) -> Callable[[Sequence[Any]], Command]:
        """Return what makes a record of the tokens that a server's scanner found, the fields' at some places."""
        reads = {f"read_{name}": kind.read for name, kind in self.kinds.items() if kind.read is not as_it_is}
        arguments = [
            f"{name}=read_{name}(tokens[{i}])" if f"read_{name}" in reads else f"{name}=tokens[{i}]"
            for name, i in zip(self.kinds, places, strict=True)
        ]
        source = f"build = lambda tokens: record({', '.join(arguments)})"
        return _compiled(source, "build", {"record": self.record, **reads})

    def reader(self) -> Callable[[str], Any]:
        """Return what reads a trainer's or a monitor's text that begins with the name: the record, or a Refusal."""
        if not self.kinds:
            return lambda text: self.record()
        scan, count, build = self.scanf.scan, len(self.kinds), self.builder(range(len(self.kinds)))
        doubtful = [(i, kind) for i, kind in enumerate(self.kinds.values()) if kind.accepts is not always]

        def read(text: str) -> Command | Refusal:
            tokens = scan(text).values
            if len(tokens) < count:
                return ILLEGAL_FORM
            for i, kind in doubtful:
                if not kind.accepts(tokens[i]):
                    return kind.refusal
            return build(tokens)

        return read


class Table:
    """Commands of one kind of client.

    Parameters
    ----------
    alone : bool
        Whether each needs a datagram of its own.

    Attributes
    ----------
    forms : dict
        Forms by the first word.
    """

    def __init__(self, alone: bool) -> None:
        self.alone = alone
        self.forms: dict[str, list[Form]] = {}

    def add(self, *forms: Form) -> None:
        """Add forms."""
        for form in forms:
            self.forms.setdefault(form.name, []).append(form)

    def of(self, *records: type[Command]) -> list[Form]:
        """Return the forms of some records."""
        return [form for forms in self.forms.values() for form in forms if form.record in records]


def c_text(data: bytes) -> str:
    """Return what C sees of a message: up to the first NUL, one character per byte."""
    return data.split(b"\0", 1)[0].decode("latin-1")


PLAYER, TRAINER, MONITOR, JOINING = Table(alone=False), Table(alone=True), Table(alone=True), Table(alone=True)
Record = TypeVar("Record", bound=Command)


@dataclass_transform(frozen_default=True)
def command(
    table: Table, *forms: str, later: Sequence[str] = (), otherwise: str = ""
) -> Callable[[type[Record]], type[Record]]:
    """Make a class a frozen record and a row of a table.

    Parameters
    ----------
    table : Table
    *forms : str
    later : sequence of str
        Forms that server 11.1 does not know.
    otherwise : str
        What is wrong with a record that no form fits.
    """

    def add(cls: type[Record]) -> type[Record]:
        record = dataclasses.dataclass(frozen=True, slots=True)(cls)
        hints = get_type_hints(cls, include_extras=True)
        kinds, optional = {}, {}
        for field in dataclasses.fields(record):  # type: ignore[arg-type]
            annotated = get_args(hints[field.name])
            kind = get_args(annotated[0])[1] if type(None) in annotated else annotated[1]
            kinds[field.name] = kind
            if type(None) in annotated or kind.absent is not None:
                optional[field.name] = kind.absent
        rows = [
            Form(text, record, {name: kinds[name] for name in _FIELD.findall(text)}, later=text in later)
            for text in [*forms, *later]
        ]
        table.add(*rows)
        record.alone = table.alone
        record.text = _writer(rows, optional, _refuser(rows[0].name, kinds, otherwise))  # type: ignore[method-assign]
        record.__doc__ = f"{cls.__doc__}\n\n{_help(rows)}"
        return record

    return add


def _compiled(source: str, name: str, names: dict[str, Any]) -> Any:
    """Return the function of a source text.

    Commands are written and read in every cycle. A function made for one record, as dataclasses make their methods,
    needs no loop over the fields.
    """
    exec(source, names)
    return names[name]


def _writer(rows: Sequence[Form], optional: dict[str, object], refuse: Callable[..., NoReturn]) -> Callable[..., str]:
    """Return the method `Command.text` of a record: a chain of f-strings, one for each form."""
    sizes = [kind.size for form in rows for kind in form.kinds.values() if kind.size]
    lines = [f"def text(self, size={max(sizes, default=None)}):"]
    spellers = {f"spell_{name}": kind.spell for form in rows for name, kind in form.kinds.items()}
    for form in rows:
        tests = [_presence(name, absent, name in form.kinds) for name, absent in optional.items()]
        spelled = _FIELD.sub(partial(_spelling, form.kinds), form.text)
        lines.append(f"    if {' and '.join(tests) or True}: return f'''{spelled}'''")
    return _compiled("\n".join([*lines, "    refuse(self)"]), "text", {"refuse": refuse, **spellers})


def _presence(name: str, absent: object, is_present: bool) -> str:
    if absent is None:
        return f"self.{name} is {'not ' * is_present}None"
    return f"self.{name} {'!=' if is_present else '=='} {absent!r}"


def _spelling(kinds: dict[str, Kind], field: re.Match[str]) -> str:
    name = field[1]
    size = ", size" * bool(kinds[name].size)
    return f"{{spell_{name}(self.{name}{size}) or refuse(self, {name!r}{size})}}"


def _refuser(command: str, kinds: dict[str, Kind], otherwise: str) -> Callable[..., NoReturn]:
    """Return what says why a record cannot be sent: because of a field, or because no form fits."""

    def refuse(record: Command, name: str = "", size: int | None = None) -> NoReturn:
        if not name:
            raise LocalProtocolError(f"{command}: {otherwise}")
        kind, value = kinds[name], getattr(record, name)
        for part, component in zip(kind.parts, value if kind.parts else (), strict=True):
            if not part.spell(component):
                kind, value = part, component
                break
        complaint = kind.complaint.format(what=kind.what or name, legal=kind.legal, value=value)
        if kind.size and kind.spell(value, len(value)):
            most = kind.size if size is None else size
            complaint = f"a message has at most {most} characters, {value!r} has {len(value)}"
        raise LocalProtocolError(f"{command}: {complaint}")

    return refuse


def _help(rows: Sequence[Form]) -> str:
    """Say how a record is sent, and what its fields may hold."""
    forms = " or ".join(f"``{_FIELD.sub(lambda field: field[1].upper(), form.text)}``" for form in rows)
    fields = {name: kind for form in rows for name, kind in form.kinds.items()}
    legal = "".join(f"\n{name.upper()}: {kind.what and kind.what + ', '}{kind.legal}." for name, kind in fields.items())
    return f"Sent as {forms}.{legal}"
