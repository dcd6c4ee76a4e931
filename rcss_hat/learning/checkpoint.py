"""Checkpoints: named arrays and a JSON header in one ``.npz`` file, written at once or not at all."""

from __future__ import annotations

import json
import os
import tempfile
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

FORMAT = "rcss-hat checkpoint"
VERSION = 1
_HEADER = "header"


class CheckpointError(ValueError):
    """A file is not a checkpoint that this version can use; the message says why."""


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """What a checkpoint file holds.

    Attributes
    ----------
    header : dict
        JSON data: settings and everything that is not an array.
    arrays : dict of str to ndarray
    path : Path
    """

    header: dict[str, Any]
    arrays: dict[str, NDArray[Any]]
    path: Path

    def array(self, name: str, dtype: np.dtype, shape: tuple[int, ...]) -> NDArray[Any]:
        """Return an array after checking what it is.

        Raises
        ------
        CheckpointError
            When it is missing or has another type or shape.
        """
        if name not in self.arrays:
            raise CheckpointError(f"{self.path}: no array {name!r}; there are {', '.join(sorted(self.arrays))}")
        found = self.arrays[name]
        if found.dtype != dtype:
            raise CheckpointError(f"{self.path}: {name} was written by another version (its record type differs)")
        if found.shape != shape:
            raise CheckpointError(f"{self.path}: {name} has shape {found.shape}, this learner needs {shape}")
        return np.ascontiguousarray(found)


def save_checkpoint(path: Path | str, header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write a checkpoint; a reader sees the old file or the new one, never a half.

    Parameters
    ----------
    path : Path or str
        Should end in ``.npz``.
    header : mapping
        JSON data.
    arrays : mapping of str to ndarray
        No object arrays; ``header`` is not a name for an array.

    Raises
    ------
    ValueError
        When an array holds Python objects or is called ``header``.
    OSError
        When the folder cannot be written to.
    """
    for name, array in arrays.items():
        if name == _HEADER or array.dtype.hasobject:
            raise ValueError(f"cannot save an array of type {array.dtype} under the name {name!r}")
    target = Path(path)
    text = json.dumps({"format": FORMAT, "version": VERSION, **header})
    members = {_HEADER: np.frombuffer(text.encode(), dtype=np.uint8), **arrays}
    handle, temporary = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            np.savez_compressed(file, allow_pickle=False, **members)
            file.flush()
            os.fsync(file.fileno())
        Path(temporary).replace(target)
    finally:
        Path(temporary).unlink(missing_ok=True)


def load_checkpoint(path: Path | str) -> Checkpoint:
    """Read a checkpoint.

    Raises
    ------
    CheckpointError
        When the file is not a checkpoint, is damaged, or is of a newer version.
    FileNotFoundError
    """
    source = Path(path)
    try:
        with np.load(source, allow_pickle=False) as members:
            arrays = {name: members[name] for name in members.files}
        header = json.loads(arrays.pop(_HEADER).tobytes().decode())
    except (zipfile.BadZipFile, zlib.error, ValueError, KeyError, EOFError, TypeError) as problem:
        raise CheckpointError(f"{source} is not a checkpoint of {FORMAT.split()[0]}, or is damaged") from problem
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        raise CheckpointError(f"{source} is not a checkpoint of {FORMAT.split()[0]}")
    if header.get("version") != VERSION:
        raise CheckpointError(f"{source} has checkpoint version {header.get('version')}; this program reads {VERSION}")
    return Checkpoint(header, arrays, source)
