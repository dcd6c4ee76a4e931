"""Where compiled kernels lie: those that this installation came with, those somebody shares, and one's own.

Numba's own cache belongs to the path of a source file and looks at no other: after an edit in a module that this file
imports, the cached machine code still holds the old callee, and a second installation finds nothing. Here a kernel's
folder is named by its module and a fingerprint of everything it depends on, ``MODULE/FINGERPRINT``, so that every
installation of the same version finds what one of them has compiled, and what does not fit is never looked at.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import sys
import tempfile
import time
from collections.abc import Iterator
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numba
from numba import config

from rcss_hat.numeric.sources import source_digest
from rcss_hat.numeric.targets import Target, own_target, readable_targets

SHIPPED = Path(__file__).parents[1] / "kernels"
"""Kernels that an installation came with; see `rcss_hat.compile`."""
KEPT = 4
"""Versions of a module whose kernels are kept in one's own cache: those used last."""
FORGOTTEN_DAYS = 30.0
"""After so many days without use they are not kept either."""
_VERSION = re.compile(r"[0-9a-f]{16}")
_FORMERLY = re.compile(r"(rcss_hat|fake_server)[\w.]*-[0-9a-f]{16}(-parts)?")


class Folder(NamedTuple):
    """A module's kernels in one place.

    Attributes
    ----------
    path : Path
        It need not exist.
    target : Target
        What they are compiled for.
    """

    path: Path
    target: Target

    @property
    def parts(self) -> Folder:
        """Where the same kernels lie as parts of others; see `rcss_hat.numeric.parts`."""
        return self._replace(path=self.path / "parts")


@lru_cache(maxsize=1)
def cache_root() -> Path | None:
    """Folder of the kernels compiled here: ``$RCSS_HAT_CACHE``, the user's cache folder, or a temporary one.

    Returns
    -------
    Path or None
        An existing folder that can be written to; None where there is none: then kernels live as long as the process.
    """
    settings: Any = config
    if settings.CACHE_DIR:  # numba's own variable: there, and nowhere else
        return Path(settings.CACHE_DIR)
    users = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache") / "rcss-hat"
    folders = [Path(os.environ.get("RCSS_HAT_CACHE") or users), users]
    with contextlib.suppress(OSError):  # of a machine without any folder that can be written to
        folders.append(Path(tempfile.gettempdir()) / f"rcss-hat-{_user()}")
    return next((folder for folder in _expanded(folders) if _takes_files(folder)), None)


@lru_cache(maxsize=1)
def shared_roots() -> tuple[Path, ...]:
    """Folders of kernels that somebody else compiled: ``$RCSS_HAT_CACHE``, where it can only be read, and `SHIPPED`."""
    settings: Any = config
    if settings.CACHE_DIR:
        return ()
    wanted = os.environ.get("RCSS_HAT_CACHE")
    folders = [*_expanded([Path(wanted)] if wanted else []), SHIPPED]
    return tuple(f for f in folders if f != cache_root() and os.access(f, os.R_OK | os.X_OK))


def _user() -> str:
    return str(os.getuid()) if hasattr(os, "getuid") else os.environ.get("USERNAME", "")


def _expanded(folders: list[Path]) -> list[Path]:
    """Put in the home folder; those of nobody's home are left out."""
    found = []
    for folder in folders:
        try:
            found.append(folder.expanduser())
        except RuntimeError:  # this user has no home
            continue
    return found


def _takes_files(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


@cache
def fingerprint(module: str, target: Target) -> str:
    """Hash of the sources that a module's kernels depend on, and of what compiles them for which processor.

    Parameters
    ----------
    module : str
        Dotted module name.
    target : Target

    Returns
    -------
    str
        16 hexadecimal digits; they change whenever any of the sources, numba or Python's version changes.
    """
    tools = f"{numba.__version__} {sys.version_info[:2]} {tuple(target)}"
    return hashlib.sha256(f"{tools} {source_digest(module)}".encode()).hexdigest()[:16]


def _in(root: Path, module: str, target: Target) -> Folder:
    return Folder(root / module / fingerprint(module, target), target)


def own_folder(module: str) -> Folder | None:
    """Where kernels of a module are kept that are compiled here; None where that is nowhere."""
    root = cache_root()
    return None if root is None else _in(root, module, own_target())


def readable_folders(module: str) -> Iterator[Folder]:
    """Yield where kernels of a module may lie that were compiled elsewhere and run here, beside `own_folder`."""
    for root in shared_roots():
        for target in readable_targets():
            yield _in(root, module, target)


def is_cached(*modules: str) -> bool:
    """Tell whether kernels of these modules, as their sources are now, were compiled before for this processor."""
    settings: Any = config
    if settings.DISABLE_JIT:
        return True

    def compiled(module: str) -> bool:  # compiled kernels have an index in their folder
        folders = [*readable_folders(module), *filter(None, [own_folder(module)])]
        return any(next(folder.path.glob("*.nbi"), None) is not None for folder in folders)

    return all(compiled(module) for module in modules)


@cache
def used(folder: Path) -> None:
    """Note that kernels of a folder were used; those used last are kept. Once per process."""
    with contextlib.suppress(OSError):
        os.utime(folder)


@cache
def clear_gone(root: Path, kept: int = KEPT) -> None:
    """Remove from a cache the kernels of versions that are gone: of old ones, and not used lately. Once per process.

    Nobody needs to be asked: what is missing is compiled again.

    Parameters
    ----------
    root : Path
    kept : int
        Versions of a module that stay: those used last.
    """
    oldest = time.time() - FORGOTTEN_DAYS * 86_400.0
    for module in _folders(root):
        if _FORMERLY.fullmatch(module.name):
            gone = [module] if _age(module) < oldest else []
        else:
            versions = sorted((f for f in _folders(module) if _VERSION.fullmatch(f.name)), key=_age, reverse=True)
            gone = [v for place, v in enumerate(versions) if place >= kept or _age(v) < oldest]
        for folder in gone:
            _remove(folder)


def _folders(folder: Path) -> list[Path]:
    with contextlib.suppress(OSError):
        return [path for path in folder.iterdir() if path.is_dir()]
    return []


def _age(folder: Path) -> float:
    """Return when a folder was used last (s, as `time.time`)."""
    with contextlib.suppress(OSError):
        return folder.stat().st_mtime
    return 0.0


def _remove(folder: Path) -> None:
    """Remove numba's files, and folders that are empty then: nothing that somebody else put there."""
    for path in sorted(folder.rglob("*"), reverse=True):
        with contextlib.suppress(OSError):
            if path.is_dir():
                path.rmdir()
            elif path.suffix in (".nbi", ".nbc") or ".nb" in path.name:
                path.unlink()
    with contextlib.suppress(OSError):
        folder.rmdir()
