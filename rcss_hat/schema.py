"""What people write (TOML, JSON), read into typed records by msgspec; messages name the place and what would be right.

A type says what is allowed: ``Annotated[int, Meta(ge=1, le=256, description="1 to 256")]``. Where a `Meta` has a
description, messages use it; otherwise they put msgspec's words into plain ones.
"""

from __future__ import annotations

import difflib
import re
import tomllib
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import msgspec
from msgspec import Meta, Struct

from rcss_hat.inputs import MAX_NESTING, NAME, FileFormatError, excerpt, read_text

T = TypeVar("T")
MAX_TOML = 2 * 2**20
"""Bytes of a TOML file; a study of a thousand conditions has a tenth of it."""
MAX_INTEGER = 2**63 - 1
"""TOML's integers have 64 bits."""

Name = Annotated[str, Meta(pattern=rf"\A{NAME.pattern}\Z", description="a name of letters, digits, '.', '_' and '-'")]
"""A name that becomes part of a path, see `rcss_hat.inputs.check_name`."""
Seed = Annotated[int, Meta(ge=0, le=MAX_INTEGER, description=f"a whole number from 0 to {MAX_INTEGER}")]

_PLACE = re.compile(r" - at `\$([^`]*)`$")
_STEP = re.compile(r"\.(\w+)|\[(\d+)\]")
_NOUNS = {
    "int": "an integer",
    "float": "a number",
    "str": "a text",
    "bool": "true or false",
    "array": "a list",
    "object": "a table",
}
_BOUNDS = {">=": "at least", ">": "more than", "<=": "at most", "<": "less than"}


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return ``; did you mean 'x'?`` for what a misspelt word may have been, or nothing."""
    close = difflib.get_close_matches(word[:100], list(known), n=1)
    return f"; did you mean {close[0]!r}?" if close else ""


def parse_toml(text: str) -> dict[str, Any]:
    """Read TOML.

    Raises
    ------
    FileFormatError
        When it is not valid, nested too deeply, or has integers of more than 64 bits.
    """
    try:
        data = tomllib.loads(text)
    except RecursionError as problem:
        raise FileFormatError(f"nested more than {MAX_NESTING} levels deep") from problem
    except ValueError as problem:
        long = "Exceeds the limit" in str(problem)  # of Python, for the digits of an integer
        raise FileFormatError("an integer of more than 64 bits" if long else str(problem)) from problem
    layer: list[Any] = [data]
    for _ in range(MAX_NESTING):
        for value in layer:
            if isinstance(value, int) and not -MAX_INTEGER - 1 <= value <= MAX_INTEGER:
                raise FileFormatError(f"an integer of more than 64 bits: {excerpt(value)}")
        tables = [list(value.values()) if isinstance(value, dict) else value for value in layer]
        layer = [inner for value in tables if isinstance(value, list) for inner in value]
    if layer:
        raise FileFormatError(f"nested more than {MAX_NESTING} levels deep")
    return data


def toml_text(name_or_path: str, package: str, names: Sequence[str]) -> tuple[str, Path]:
    """Return the text of a study that a package has in ``conditions``, or of a file.

    Parameters
    ----------
    name_or_path : str
    package : str
    names : sequence of str
        Studies that the package has.

    Returns
    -------
    str, Path
        The text, and the folder its file names are relative to.

    Raises
    ------
    FileFormatError
        When there is none, or it is no text.
    """
    if name_or_path in names:
        resource = files(package) / "conditions" / f"{name_or_path}.toml"
        return resource.read_text(encoding="utf-8"), Path.cwd()
    path = Path(name_or_path)
    if not path.is_file():
        near, known = did_you_mean(name_or_path, names), ", ".join(names)
        raise FileFormatError(
            f"no study {name_or_path!r}: there are {known}, or give a TOML file of the same form{near}"
        )
    return read_text(path, "study", MAX_TOML), path.resolve().parent


def read(kind: type[T], data: Any, where: str) -> T:
    """Make a record of data.

    Parameters
    ----------
    kind : type
        A `msgspec.Struct` with ``forbid_unknown_fields``.
    data : Any
        What TOML or JSON gave.
    where : str
        Where it stands in its file, for messages: ``"condition 3"``.

    Raises
    ------
    FileFormatError
    """
    try:
        return msgspec.convert(data, kind)
    except msgspec.ValidationError as problem:
        raise FileFormatError(_explained(kind, data, where, str(problem))) from problem


def check(record: Any) -> None:
    """Check the fields of a dataclass by their types, for its ``__post_init__``; values stay as they were given.

    Raises
    ------
    ValueError
        Naming the field as files do, without the ``_`` that keeps it from being a word of Python.
    """
    kind: Any = type(record)
    for name, hint in _hints(kind).items():
        value = getattr(record, name)
        try:
            msgspec.convert(value, hint)
        except msgspec.ValidationError as problem:
            wanted = _wanted(hint, str(problem))
            raise ValueError(f"{name.removesuffix('_')} must be {wanted}, not {excerpt(value)}") from problem


@cache
def _hints(kind: Any) -> dict[str, Any]:
    return get_type_hints(kind, include_extras=True)


def _explained(kind: Any, value: Any, where: str, message: str) -> str:
    place = _PLACE.search(message)
    steps = _STEP.findall(place[1]) if place else []
    text = message[: place.start()] if place else message
    hint, name = kind, ""
    for name, index in steps:
        hint = _member(hint, name)
        value = value[int(index) if index else name]
        where = f"{where} {int(index) + 1}" if index else f"{where}: {name}"
    entry = re.search(r"field `(.*)`", text, re.DOTALL)
    if text.startswith("Object missing"):
        return f"{where} needs {entry[1]!r}" if entry else f"{where}: {text}"
    if entry:
        known = [f.encode_name for f in msgspec.structs.fields(_record(hint))]
        return f"{where} has no entry {excerpt(entry[1])}; known are {', '.join(known)}{did_you_mean(entry[1], known)}"
    if not text.startswith(("Expected", "Invalid enum", "Number out")):
        return f"{where}: {text}"  # of a __post_init__
    if ", got `" in text:
        return f"{where} has a value of the wrong kind: {excerpt(value)}; it must be {_wanted(hint, text)}"
    return f"{where} must be {_wanted(hint, text)}, not {excerpt(value)}"


def _wanted(hint: Any, text: str) -> str:
    if text.startswith("Expected `int`, got"):
        return _NOUNS["int"]
    if described := _described(hint):
        return described
    expected = re.match(r"Expected `([^`]*)`(?:( of length)? ([<>]=?) (\S+))?", text)
    if not expected:
        return "a number of a usual size"
    kinds, length, sign, bound = expected.groups()
    if length:
        return f"{_BOUNDS[sign]} {bound} long"
    if sign:
        return f"{_BOUNDS[sign]} {float(bound):,.15g}"
    return " or ".join(_NOUNS.get(word, word) for word in kinds.split(" | ") if word != "null")


def _described(hint: Any) -> str:
    for part in _parts(hint):
        if isinstance(part, Meta) and part.description:
            return part.description
        if get_origin(part) is Literal:
            return f"one of {', '.join(map(str, get_args(part)))}"
    return ""


def _parts(hint: Any) -> Iterator[Any]:
    """Types and constraints that a type is put together of, without what its items are."""
    if get_origin(hint) is Annotated:
        base, *constraints = get_args(hint)
        yield from constraints
        yield from _parts(base)
    elif get_origin(hint) in (Union, UnionType):
        for part in get_args(hint):
            yield from _parts(part)
    else:
        yield hint


def _record(hint: Any) -> Any:
    return next(part for part in _parts(hint) if isinstance(part, type) and issubclass(part, Struct))


def _member(hint: Any, name: str) -> Any:
    """Return the type of a field of a record, or of the items of a list when ``name`` is empty."""
    if name:
        return _hints(_record(hint))[name]
    return next(get_args(part)[0] for part in _parts(hint) if get_origin(part) in (tuple, list))
