"""Checkpoints: named arrays and a JSON header in one ``.npz`` file, written at once or not at all."""

from __future__ import annotations

import io
import json
import math
import os
import tempfile
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.inputs import MIB, decoded, excerpt, load_json

FORMAT = "rcss-hat checkpoint"
VERSION = 1
MAX_UNPACKED = 512 * MIB
"""Bytes; learners of 11v11 with traces and a pseudo-action have a third of that."""
MAX_MEMBERS = 64
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
            raise CheckpointError(f"{self.path}: {name} has shape {excerpt(found.shape)}, this learner needs {shape}")
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
        When the file is not a checkpoint, is damaged, is of a newer version, or unpacks to more than `MAX_UNPACKED`.
    FileNotFoundError
    """
    source = Path(path)
    try:
        members = _members(source)
        header = load_json(decoded(members.pop(_HEADER).tobytes(), source, "checkpoint"))
    except (FileNotFoundError, CheckpointError):
        raise
    except Exception as problem:
        # zipfile, zlib and NumPy raise nearly everything there is for damaged input.
        raise CheckpointError(f"{source} is not a checkpoint of {FORMAT.split()[0]}, or is damaged") from problem
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        raise CheckpointError(f"{source} is not a checkpoint of {FORMAT.split()[0]}")
    if header.get("version") != VERSION:
        version = excerpt(header.get("version"))
        raise CheckpointError(f"{source} has checkpoint version {version}; this program reads {VERSION}")
    return Checkpoint(header, members, source)


def _members(source: Path) -> dict[str, NDArray[Any]]:
    """Read the arrays of a zip file, after what it says of their sizes has been checked."""
    with zipfile.ZipFile(source) as file:
        entries = file.infolist()
        unpacked = sum(entry.file_size for entry in entries)
        if unpacked > MAX_UNPACKED or len(entries) > MAX_MEMBERS:
            raise CheckpointError(
                f"{source} unpacks to {unpacked / MIB:.0f} MiB in {len(entries)} arrays; the limits are "
                f"{MAX_UNPACKED // MIB} MiB and {MAX_MEMBERS}"
            )
        return {entry.filename.removesuffix(".npy"): _array(file.read(entry)) for entry in entries}


def _array(data: bytes) -> NDArray[Any]:
    """Read one ``.npy``; its header must tell exactly as many bytes as there are, before any room is made for them."""
    file = io.BytesIO(data)
    version = np.lib.format.read_magic(file)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, dtype = read(file)
    if dtype.hasobject or math.prod(shape) * dtype.itemsize != len(data) - file.tell() or min(shape, default=0) < 0:
        raise ValueError("the array is not as long as it says")
    file.seek(0)
    return np.lib.format.read_array(file, allow_pickle=False)
