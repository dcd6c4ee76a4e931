"""What is read from outside is opened, unpacked, decoded and limited here, in one place.

Every fault of a file is a `FileFormatError` with one line that names it. Limits are far beyond what the package itself
writes; they are there for files that were damaged, or made to fill the memory.
"""

from __future__ import annotations

import codecs
import json
import re
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

MIB = 2**20
MAX_TEXT = 64 * MIB
"""Bytes of a text file."""
MAX_UNPACKED = 1024 * MIB
"""Bytes of a log or transcript, unpacked."""
MAX_LINE = 4 * MIB
"""Bytes of a line of a log or transcript; a frame of 22 players has 3,000."""
MAX_NESTING = 32
"""Levels of lists and objects in JSON."""
MAX_DIGITS = 40
"""Digits of a whole number in JSON: room for 128 bits."""
MAX_SHOWN = 60
"""Characters of foreign text in a message."""
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}")
"""Names that become names of files and folders: no separators, nothing hidden, nothing above."""
_GZIP = b"\x1f\x8b"
_CHUNK = 256 * 1024
_UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


class FileFormatError(ValueError):
    """A file does not hold what it should; the message names the file, the place and what would be right."""


def excerpt(value: object, length: int = MAX_SHOWN) -> str:
    """Show a value that came from outside in a message: escaped, and cut to ``length`` characters."""
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) >= 10**MAX_DIGITS:
        return f"a whole number of more than {MAX_DIGITS} digits"
    text = repr(value)
    return text if len(text) <= length else text[: length - 4] + " ..."


def check_name(name: object, what: str) -> str:
    """Return a name that can be a part of a path.

    Parameters
    ----------
    name : object
    what : str
        Whose name it is, for the message.

    Raises
    ------
    FileFormatError
        When it is no such name: letters, digits, ``.``, ``_`` and ``-``, at most 100, the first a letter or digit.
    """
    if not isinstance(name, str) or not NAME.fullmatch(name):
        raise FileFormatError(
            f"{what} must consist of letters, digits, '.', '_' and '-', begin with a letter or digit and have at most "
            f"100 characters, not {excerpt(name)}"
        )
    return name


# --- bytes and text ---------------------------------------------------------------------------------------------------


def read_bytes(path: Path, kind: str, limit: int = MAX_TEXT) -> bytes:
    """Read a file whole.

    Parameters
    ----------
    path : Path
    kind : str
        What the file should be, for the message: ``"decision list"``.
    limit : int
        Bytes.

    Raises
    ------
    FileFormatError
        When there is no such file, it cannot be read, or it is longer than ``limit``.
    """
    with _opened(path, kind) as file:
        try:
            data = file.read(limit + 1)
        except OSError as error:
            raise FileFormatError(f"{path}: cannot be read: {error.strerror}") from error
    if len(data) > limit:
        raise FileFormatError(f"{path}: is longer than {_size(limit)}, the limit for a {kind}")
    return data


def read_text(path: Path, kind: str, limit: int = MAX_TEXT) -> str:
    """Read a text file; a byte order mark is ignored, and every end of a line becomes a line feed.

    Raises
    ------
    FileFormatError
        As `read_bytes`, and when it is not UTF-8 text.
    """
    return decoded(read_bytes(path, kind, limit), path, kind)


def decoded(data: bytes, path: Path, kind: str) -> str:
    """Decode the bytes of a text file, see `read_text`."""
    if data.startswith(_UTF16):
        raise FileFormatError(f"{path}: is not UTF-8 text but UTF-16; save it as UTF-8")
    data = data.removeprefix(codecs.BOM_UTF8)
    nul = data.find(b"\0")
    if nul >= 0:
        raise FileFormatError(f"{path}: holds a NUL byte (at byte {nul}), so it is no {kind}")
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise FileFormatError(f"{path}: is not UTF-8 text, so not a {kind} (byte {error.start})") from error
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _opened(path: Path, kind: str) -> BinaryIO:
    try:
        return path.open("rb")
    except FileNotFoundError as error:
        raise FileFormatError(f"{path}: there is no such {kind}") from error
    except IsADirectoryError as error:
        raise FileFormatError(f"{path}: is a folder, not a {kind}") from error
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be read: {error.strerror}") from error
    except ValueError as error:  # a NUL in the name
        raise FileFormatError(f"{str(path)!r} is no name of a file") from error


def _size(n_bytes: int) -> str:
    return f"{n_bytes // MIB} MiB" if n_bytes >= MIB else f"{n_bytes} bytes"


# --- logs and transcripts ---------------------------------------------------------------------------------------------


class LineReader:
    """Lines of a file, packed by gzip or not, one after the other; what was cut off or damaged ends them.

    Parameters
    ----------
    path : Path
    kind : str
        As in `read_bytes`.
    limit : int
        Bytes of the whole, unpacked.
    longest : int
        Bytes of a line.

    Attributes
    ----------
    cut : str
        Why the file ended early; ``""`` as long as it did not.
    unended : bool
        The line just read was the last, and has no end: whoever wrote it may have been stopped.

    Raises
    ------
    FileFormatError
        When there is no such file or it cannot be read; while reading, when there is more than the limits.
    """

    def __init__(self, path: Path, kind: str, limit: int = MAX_UNPACKED, longest: int = MAX_LINE) -> None:
        self.path, self.kind, self.limit, self.longest = path, kind, limit, longest
        self.cut = ""
        self.unended = False

    def __iter__(self) -> Iterator[bytes]:
        """Yield the lines without their ends; a byte order mark is ignored."""
        rest = b""
        for data in self._plain():
            lines = (rest + data).split(b"\n")
            rest = lines.pop()
            if len(rest) > self.longest:
                raise FileFormatError(
                    f"{self.path}: has a line of more than {_size(self.longest)}, so it is no {self.kind}"
                )
            yield from (line.removesuffix(b"\r") for line in lines)
        if rest:
            self.unended = True
            yield rest.removesuffix(b"\r")

    def _plain(self) -> Iterator[bytes]:
        total, first = 0, True
        for data in self._chunks():
            total += len(data)
            if total > self.limit:
                raise FileFormatError(
                    f"{self.path}: has more than {_size(self.limit)} unpacked, the limit for a {self.kind}"
                )
            yield data.removeprefix(codecs.BOM_UTF8) if first else data
            first = False

    def _chunks(self) -> Iterator[bytes]:
        with _opened(self.path, self.kind) as file:
            try:
                head = file.read(_CHUNK)
                if head.startswith(_GZIP):
                    yield from self._unpacked(head, file)
                    return
                while head:
                    yield head
                    head = file.read(_CHUNK)
            except OSError as error:
                raise FileFormatError(f"{self.path}: cannot be read: {error.strerror}") from error

    def _unpacked(self, packed: bytes, file: BinaryIO) -> Iterator[bytes]:
        """Unpack gzip members one after the other, a little at a time."""
        inflate = zlib.decompressobj(31)
        while packed:
            try:
                data = inflate.decompress(packed, _CHUNK)
            except zlib.error:
                self.cut = "it cannot be decompressed to its end: it is damaged"
                return
            if data:
                yield data
            packed = inflate.unconsumed_tail or file.read(_CHUNK)
            if inflate.eof:
                packed = inflate.unused_data + packed
                if not packed.strip(b"\0"):
                    return
                inflate = zlib.decompressobj(31)
        self.cut = "it cannot be decompressed to its end: it is cut off"


# --- JSON -------------------------------------------------------------------------------------------------------------


def load_json(text: str, constants: bool = False) -> Any:
    """Read JSON whose numbers are finite and not endless, and which is not nested too deeply.

    Parameters
    ----------
    text : str
    constants : bool
        Read NaN and Infinity, too: in results of our own, where nothing was played.

    Raises
    ------
    FileFormatError
    """
    try:
        constant = float if constants else _no_constant
        content = json.loads(text, parse_constant=constant, parse_int=_whole, parse_float=_real)
    except json.JSONDecodeError as error:
        raise FileFormatError(f"line {error.lineno}, column {error.colno}: not JSON: {error.msg}") from error
    except RecursionError as error:
        raise FileFormatError(f"nested more than {MAX_NESTING} levels deep") from error
    _check_nesting(content)
    return content


def _no_constant(name: str) -> float:
    raise FileFormatError(f"{name} is not a number of JSON")


def _whole(digits: str) -> int:
    if len(digits) > MAX_DIGITS:
        raise FileFormatError(f"a whole number of {len(digits)} digits; {MAX_DIGITS} are the limit")
    return int(digits)


def _real(digits: str) -> float:
    value = float(digits)
    if value in (float("inf"), float("-inf")):
        raise FileFormatError(f"the number {digits[:MAX_SHOWN]} is too great")
    return value


def _check_nesting(content: Any) -> None:
    level, depth = [content], 0
    while level:
        inner: list[Any] = []
        for value in level:
            if isinstance(value, dict | list) and depth == MAX_NESTING:
                raise FileFormatError(f"nested more than {MAX_NESTING} levels deep")
            if isinstance(value, dict):
                inner += value.keys()
                inner += value.values()
            elif isinstance(value, list):
                inner += value
            elif isinstance(value, str) and not value.isascii():
                _check_text(value)
        level, depth = inner, depth + 1


def _check_text(value: str) -> None:
    try:
        value.encode("utf-8")
    except UnicodeEncodeError as error:
        raise FileFormatError(f"{excerpt(value)} is no text: it holds half a character") from error


def parse_json(text: str, format_name: str, version: int) -> dict[str, Any]:
    """Read a JSON object that begins with the name and version of its format.

    Raises
    ------
    FileFormatError
        When it is no JSON object, of another format, or of a newer version.
    """
    content = load_json(text)
    if not isinstance(content, dict):
        raise FileFormatError(f"expected a JSON object, not a {type(content).__name__}")
    if content.get("format") != format_name:
        raise FileFormatError(f'"format" must be {format_name!r}, not {excerpt(content.get("format"))}')
    found = content.get("version")
    if not isinstance(found, int) or isinstance(found, bool) or not 1 <= found <= version:
        raise FileFormatError(f'"version" must be 1 to {version} for this program, not {excerpt(found)}')
    return content


def item(content: Any, key: str, kind: type | tuple[type, ...], where: str = "") -> Any:
    """Take an entry of a JSON object.

    Raises
    ------
    FileFormatError
        When it is missing or of another type; true and false are no numbers.
    """
    place = f"{where}: " if where else ""
    if not isinstance(content, dict) or key not in content:
        raise FileFormatError(f"{place}{key!r} is missing")
    value = content[key]
    kinds = kind if isinstance(kind, tuple) else (kind,)
    if not isinstance(value, kinds) or (isinstance(value, bool) and bool not in kinds):
        names = " or ".join("null" if k is type(None) else k.__name__ for k in kinds)
        raise FileFormatError(f"{place}{key!r} must be {names}, not {excerpt(value)}")
    return value


def whole(content: Any, key: str, where: str = "", low: int = 0, high: int = 2**53) -> int:
    """Take a whole number from ``low`` to ``high`` of a JSON object; errors as in `item`."""
    value = item(content, key, int, where)
    if not low <= value <= high:
        place = f"{where}: " if where else ""
        raise FileFormatError(f"{place}{key!r} must be {low} to {high}, not {excerpt(value)}")
    return int(value)
