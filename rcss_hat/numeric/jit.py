"""``njit`` with a cache that notices edits in imported modules.

Numba's own cache looks only at the file of the function it compiles: after an edit in a module that this file
imports, the cached machine code still holds the old callee. Here every kernel module gets a cache folder of its own,
named by a hash over its source and the sources of all modules of this project that it imports, directly or not.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import re
import sys
import tempfile
from collections.abc import Callable
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba import config, types
from numba.core.cpu import CPUTargetOptions

PACKAGES = ("rcss_hat", "fake_server")
_IMPORT = re.compile(
    r"^\s*(?:from\s+((?:rcss_hat|fake_server)[\w.]*)\s+import\s+(\([^)]*\)|[^\n#]*)|"
    r"import\s+((?:rcss_hat|fake_server)[\w.]*))",
    re.MULTILINE,
)
F = TypeVar("F", bound=Callable[..., Any])
_LEAN: dict[str, Any] = {"no_cfunc_wrapper": True}  # for callers in C, of which there are none
_SMALL_INTEGERS = (types.int8, types.uint8, types.int16, types.uint16, types.int32, types.uint32)
_BARE: dict[str, Any] = {"error_model": "numpy"}
if hasattr(CPUTargetOptions, "_nrt"):  # numba keeps it undocumented; without it kernels are slower, not wrong
    _BARE["_nrt"] = False


@lru_cache(maxsize=1)
def cache_root() -> Path:
    """Folder of all compiled kernels: ``$RCSS_HAT_CACHE``, the user's cache folder, or a temporary one.

    Returns
    -------
    Path
        An existing folder that can be written to.
    """
    home = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    wanted = os.environ.get("RCSS_HAT_CACHE") or f"{home}/rcss-hat"
    for folder in (Path(wanted).expanduser(), Path(tempfile.gettempdir()) / f"rcss-hat-{os.getuid()}"):
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=folder):
                return folder
        except OSError:
            continue
    return Path(tempfile.mkdtemp(prefix="rcss-hat-"))


@cache
def _source(module: str) -> str | None:
    loaded = sys.modules.get(module)
    path = getattr(loaded, "__file__", None)
    if path is None:
        try:
            spec = importlib.util.find_spec(module)
        except (ImportError, ValueError):
            return None
        path = spec.origin if spec else None
    return Path(path).read_text() if path and path.endswith(".py") else None


def _imports(source: str) -> set[str]:
    found = set()
    for match in _IMPORT.finditer(source):
        package, names, plain = match.groups()
        found.add(package or plain)
        for name in re.findall(r"\w+", names or ""):
            found.add(f"{package}.{name}")
    return found


@cache
def fingerprint(module: str) -> str:
    """Hash of a module's source and of every project module it imports, directly or not.

    Parameters
    ----------
    module : str
        Dotted module name, for example ``"fake_server.simulation.motion"``.

    Returns
    -------
    str
        Hexadecimal digest; changes whenever any of those sources changes.
    """
    seen: dict[str, str] = {}
    queue = [module]
    while queue:
        name = queue.pop()
        if name in seen:
            continue
        source = _source(name)
        if source is None:
            continue
        seen[name] = source
        queue.extend(_imports(source))
    digest = hashlib.sha256(f"{numba.__version__} {sys.version_info[:2]}".encode())
    for name in sorted(seen):
        digest.update(name.encode())
        digest.update(seen[name].encode())
    return digest.hexdigest()[:16]


def is_cached(module: str) -> bool:
    """Tell whether kernels of a module, as its sources are now, were compiled before on this machine."""
    settings: Any = config
    if settings.DISABLE_JIT or settings.CACHE_DIR:
        return True
    folder = cache_root() / f"{module}-{fingerprint(module)}"  # made at import; compiled kernels have an index in it
    return next(folder.rglob("*.nbi"), None) is not None


def njit(function: F) -> F:
    """Compile a function with numba, cached per state of the sources it depends on.

    With ``NUMBA_DISABLE_JIT=1`` the function is returned as it is.
    """
    return _compile(function, {})


def kernel(function: F) -> F:
    """Compile a kernel of the hot path: :func:`njit` for functions that allocate no array and return none.

    Such a function needs no reference counts of the arrays it works on, which would otherwise cost more than the
    arithmetic (measured: a factor of 1.5 to 4). Division by zero gives infinity or NaN as in NumPy, without a check.
    """
    return _compile(function, _BARE)


def inlined(function: F) -> F:
    """Compile a :func:`kernel` into its callers: for short functions, and for parts of a long one."""
    return _compile(function, {**_BARE, "forceinline": True})


def _compile(function: F, options: dict[str, Any]) -> F:
    settings: Any = config
    module = function.__module__
    before = settings.CACHE_DIR
    if not before:
        settings.CACHE_DIR = str(cache_root() / f"{module}-{fingerprint(module)}")
    try:
        compiled: Any = numba.njit(cache=True, **_LEAN, **options)(function)
    finally:
        settings.CACHE_DIR = before
    if not settings.DISABLE_JIT:
        _share_overloads(compiled)
    return cast(F, compiled)


def _share_overloads(dispatcher: Any) -> None:
    """Compile a kernel once for all integer types its callers in other kernels pass it.

    Numba compiles a function anew for every constant and every width of integer that a compiled caller passes, which
    here is a sixth of all compilation. Callers cast their arguments to what this returns.
    """
    resolve = dispatcher.get_call_template

    def resolve_widened(args: tuple[Any, ...], keywords: dict[str, Any]) -> Any:
        return resolve(tuple(_widened(a) for a in args), {name: _widened(a) for name, a in keywords.items()})

    dispatcher.get_call_template = resolve_widened


def _widened(kind: Any) -> Any:
    kind = types.unliteral(kind)
    return types.int64 if kind in _SMALL_INTEGERS else kind
