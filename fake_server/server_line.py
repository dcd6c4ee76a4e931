"""Lines of parameters as rcssserver reads them, from the command line or from a configuration file.

A line is a list of ``space::name = value``, each with up to two dashes in front and with blanks on either side of
``=``, of ``include = file``, of ``help``, and of comments (``#``, ``//``, ``/* */``). The original joins its arguments
with blanks and reads the result (19.0.0, rcss/conf/parser.cpp); so does this module. It takes more: an argument that is
one assignment may hold blanks, colons and equals signs in its value, and a text may begin like a number. It takes less
where the original reads two assignments that nothing separates.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from rcss_hat.inputs import FileFormatError, read_text

MAX_FILE_SIZE = 1 << 20
"""Bytes of an included file; the longest that a server writes itself has 20,000."""
MAX_DEPTH = 20
"""Files that include each other."""

_BLANKS = re.compile(r"(?:[ \t\0\r\n]|/\*.*?\*/|//[^\r\n]*|\#[^\r\n]*)+", re.DOTALL)
_WORD = r"""[^:"'= \t\n-][^:"'= \t\n]*"""
_DASHES = re.compile(r"-{0,2}")
_HELP = re.compile(rf"(?:{_WORD}::)*help", re.IGNORECASE)
_PATH = re.compile(rf"{_WORD}(?:::{_WORD})+")
_INCLUDE = re.compile(r"include(?=[\s=])", re.IGNORECASE)
_VALUE = re.compile(r""" "(?:\\"|[^"\\]|\\(?!"))*" | '(?:\\'|[^'\\]|\\(?!'))*' | [+-]?[^:"'= \t\n\r]+ """, re.VERBOSE)
_ONE_ASSIGNMENT = re.compile(rf"\s*(-{{0,2}}{_WORD}(?:::{_WORD})+)\s*=\s*(.+)", re.DOTALL)
_NEEDS_QUOTES = re.compile(r"""[ \t:="']""")


class LineError(Exception):
    """A line cannot be read.

    Attributes
    ----------
    found : str
        The word where it went wrong, empty at the end of the line.
    path : str
        The parameter it belongs to, empty when there is none.
    missing : {"name", "value"}
        What stands there is no parameter; or the parameter has no value.
    """

    def __init__(self, found: str, path: str = "", missing: str = "name") -> None:
        self.found, self.path, self.missing = found, path, missing
        super().__init__(f"{missing} expected at {found!r}")


class IncludeError(Exception):
    """An included file cannot be read; the message names the file and the reason."""


class HelpWanted(Exception):
    """The line asks for help."""


@dataclass(frozen=True, slots=True)
class Assignment:
    """One ``space::name = value``.

    Attributes
    ----------
    space : str
        Everything in front of the last ``::``.
    name : str
    value : str
        As written, with its quotes.
    source : str
        ``FILE:LINE: `` of an included file, empty for the command line.
    """

    space: str
    name: str
    value: str
    source: str = ""


def unquoted(value: str) -> str:
    r"""Return a value without its quotes, ``\"`` or ``\'`` in it as the quote itself."""
    if len(value) < 2 or value[0] != value[-1] or value[0] not in "'\"":
        return value
    return value[1:-1].replace("\\" + value[0], value[0])


def read_arguments(arguments: Iterable[str]) -> Iterator[Assignment]:
    """Yield the assignments of a command line, those of included files in their place.

    Raises
    ------
    LineError
        For what is no assignment.
    IncludeError
        For a file that cannot be read.
    HelpWanted
        When the line asks for help.
    """
    yield from _read(" ".join(map(_argument, arguments)), Path(), ())


def _argument(argument: str) -> str:
    """Return an argument as it stands in the line: with quotes where it needs them."""
    if match := _ONE_ASSIGNMENT.fullmatch(argument):
        path, value = match.groups()
        quoted = _VALUE.fullmatch(value) is not None or "::" in value or not _NEEDS_QUOTES.search(value)
        return f"{path}={value}" if quoted else f"{path}={_quoted(value)}"
    if re.search(r"[ \t]", argument) and unquoted(argument) == argument:
        return f"'{argument}'"
    return argument


def _quoted(value: str) -> str:
    """Put quotes around a value that has blanks or quotes of its own."""
    escaped = value.replace("'", "\\'")
    return f"'{escaped}'"


def _read(text: str, folder: Path, files: tuple[Path, ...]) -> Iterator[Assignment]:
    """Yield the assignments of a text; ``files`` are those being read, the innermost last."""
    at = _skip(text, 0)
    while at < len(text):
        at = _DASHES.match(text, at).end()  # type: ignore[union-attr]
        if _HELP.match(text, at) and not _PATH.match(text, at):
            raise HelpWanted
        if include := _INCLUDE.match(text, at):
            name, at = _value(text, include.end(), "include")
            yield from _included(unquoted(name), folder, files)
        else:
            assignment, at = _assignment(text, at, files)
            yield assignment
        at = _skip(text, at)


def _skip(text: str, at: int) -> int:
    blanks = _BLANKS.match(text, at)
    return blanks.end() if blanks else at


def _assignment(text: str, at: int, files: tuple[Path, ...]) -> tuple[Assignment, int]:
    """Read ``space::name = value``; returns it and where it ends."""
    path = _PATH.match(text, at)
    if path is None:
        raise LineError(_word(text, at))
    space, _, name = path[0].rpartition("::")
    if name.lower() == "help":
        raise HelpWanted
    value, end = _value(text, path.end(), path[0])
    source = f"{files[-1]}:{text.count(chr(10), 0, at) + 1}: " if files else ""
    return Assignment(space, name, value, source), end


def _value(text: str, at: int, path: str) -> tuple[str, int]:
    """Read ``= value``; returns the value and where it ends."""
    at = _skip(text, at)
    if not text.startswith("=", at):
        raise LineError(_word(text, at), path, "value")
    at = _skip(text, at + 1)
    value = _VALUE.match(text, at)
    if value is None:
        raise LineError(_word(text, at), path, "value")
    if text[value.end() : value.end() + 1] in tuple(":=\"'"):
        raise LineError(_word(text, at), path, "value")
    return value[0], value.end()


def _word(text: str, at: int) -> str:
    """Return the word that something is part of, for messages; empty at the end of the text."""
    if at >= len(text):
        return ""
    start = max(text.rfind(blank, 0, at) for blank in " \t\n") + 1
    return (text[start:].split() or [""])[0]


def _included(name: str, folder: Path, files: tuple[Path, ...]) -> Iterator[Assignment]:
    """Yield the assignments of a file; one that is being read already is left out."""
    if len(files) >= MAX_DEPTH:
        raise IncludeError(f"cannot include {name}: more than {MAX_DEPTH} files in each other")
    try:
        path = (folder / Path(name).expanduser()).resolve()
        if path in files:
            return
        text = read_text(path, "configuration file", MAX_FILE_SIZE)
    except (FileFormatError, RuntimeError, ValueError) as error:  # the latter two: no such user, a NUL in the name
        raise IncludeError(f"cannot include {error}") from None
    yield from _read(text, path.parent, (*files, path))
