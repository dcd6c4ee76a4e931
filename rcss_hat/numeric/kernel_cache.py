"""Caches of compiled kernels: those that are only read, and one's own."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from numba.core import caching

from rcss_hat.numeric.cache_folders import Folder, clear_gone, used

# Numba made these names public lately.
_caching: Any = caching
_Locator: Any = getattr(caching, "CacheLocator", None) or _caching._CacheLocator
_Implementation: Any = getattr(caching, "CompileResultCacheImpl", None) or _caching._CompileResultCacheImpl


class _InFolder(_Locator):
    """Puts a function's files into a folder, made with the first file."""

    def __init__(self, folder: Folder, line: int) -> None:
        self._folder, self._line = folder, line

    def ensure_cache_path(self) -> None:
        path = self._folder.path
        if not path.exists():
            path.mkdir(parents=True, exist_ok=True)
            clear_gone((path.parent if path.name == "parts" else path).parents[1])

    def get_cache_path(self) -> str:
        return str(self._folder.path)

    def get_source_stamp(self) -> str:
        return ""  # the folder's name is one

    def get_disambiguator(self) -> str:
        return str(self._line)


class _KernelCache(caching.FunctionCache):
    def __init__(self, function: Any, folder: Folder) -> None:
        locator = _InFolder(folder, function.__code__.co_firstlineno)

        class Implementation(_Implementation):
            def __init__(self, function: Any) -> None:
                self._lineno, self._locator = locator._line, locator
                name = f"{Path(function.__code__.co_filename).stem}.{function.__qualname__}"
                self._filename_base = self.get_filename_base(name, getattr(sys, "abiflags", ""))

        self._impl_class = Implementation
        super().__init__(function)
        self._folder = folder

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        """Return what numba keeps a compiled function under: with the processor it is for, not the one it runs on."""
        signature, _, *rest = super()._index_key(sig, codegen)
        return (signature, tuple(self._folder.target), *rest)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the compiled function, or None."""
        found = super().load_overload(sig, target_context)
        if found is not None:
            used(self._folder.path)
        return found


class _OnlyRead(_KernelCache):
    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep nothing."""


class Caches:
    """Caches that are looked into one after the other; what is compiled goes into the last.

    Takes the place of the cache of a numba dispatcher.

    Parameters
    ----------
    function : callable
        The plain function.
    read : iterable of Folder
        Those that are only read. Nothing is wrong with one that is not there.
    own : Folder or None
        The one that is read last and written to; None where there is none.
    """

    def __init__(self, function: Any, read: Iterable[Folder], own: Folder | None) -> None:
        self._read = [_OnlyRead(function, folder) for folder in read if folder.path.is_dir()]
        self._own: Any = caching.NullCache() if own is None else _KernelCache(function, own)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the compiled function, or None."""
        for cache in (*self._read, self._own):
            found = cache.load_overload(sig, target_context)
            if found is not None:
                return found
        return None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._own, name)
