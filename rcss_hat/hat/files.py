"""Files that a person keeps: written whole or not at all, read with errors that name the file."""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path
from typing import Any


class FileFormatError(ValueError):
    """A file does not hold what it should; the message names the file, the place and what would be right."""


def write_text(path: Path, text: str) -> None:
    """Replace a file in one step, so that a crash leaves the old one or the new one.

    Parameters
    ----------
    path : Path
        Folders that are missing are made.
    text : str
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    temporary = Path(name)
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        temporary.chmod(_usual_mode())
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def _usual_mode() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask


def read_text(path: Path, kind: str) -> str:
    """Read a text file.

    Parameters
    ----------
    path : Path
    kind : str
        What the file should be, for the message: ``"decision list"``.

    Raises
    ------
    FileFormatError
        When there is no such file or it is not UTF-8 text.
    """
    try:
        return path.read_text(encoding="utf-8")
    except FileNotFoundError as error:
        raise FileFormatError(f"{path}: there is no such {kind}") from error
    except IsADirectoryError as error:
        raise FileFormatError(f"{path}: is a folder, not a {kind}") from error
    except UnicodeDecodeError as error:
        raise FileFormatError(f"{path}: is not UTF-8 text, so not a {kind} (byte {error.start})") from error


def parse_json(text: str, format_name: str, version: int) -> dict[str, Any]:
    """Read a JSON object that begins with the name and version of its format.

    Raises
    ------
    FileFormatError
        When it is no JSON object, of another format, or of a newer version.
    """
    try:
        content = json.loads(text)
    except json.JSONDecodeError as error:
        raise FileFormatError(f"line {error.lineno}, column {error.colno}: not JSON: {error.msg}") from error
    if not isinstance(content, dict):
        raise FileFormatError(f"expected a JSON object, not a {type(content).__name__}")
    if content.get("format") != format_name:
        raise FileFormatError(f'"format" must be {format_name!r}, not {content.get("format")!r}')
    if not isinstance(content.get("version"), int) or not 1 <= content["version"] <= version:
        raise FileFormatError(f'"version" must be 1 to {version} for this program, not {content.get("version")!r}')
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
        raise FileFormatError(f"{place}{key!r} must be {names}, not {value!r}")
    return value
