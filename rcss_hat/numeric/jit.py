"""``njit`` with a cache that notices edits in imported modules; see `rcss_hat.numeric.cache_folders`."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, TypeVar, cast

import numba
from numba import config, types
from numba.core.cpu import CPUTargetOptions

from rcss_hat.numeric import lean, parts
from rcss_hat.numeric.cache_folders import own_folder, readable_folders
from rcss_hat.numeric.kernel_cache import Caches

F = TypeVar("F", bound=Callable[..., Any])
_LEAN: dict[str, Any] = {"no_cfunc_wrapper": True}  # for callers in C, of which there are none
_SMALL_INTEGERS = (types.int8, types.uint8, types.int16, types.uint16, types.int32, types.uint32)
_BARE: dict[str, Any] = {"error_model": "numpy", "pipeline_class": lean.Pipeline}
if hasattr(CPUTargetOptions, "_nrt"):  # numba keeps it undocumented; without it kernels are slower, not wrong
    _BARE["_nrt"] = False


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


def releasing(function: F) -> F:
    """Compile a :func:`kernel` that Python calls and that holds no lock of Python's: threads run side by side."""
    return _compile(function, {**_BARE, "nogil": True})


def inlined(function: F) -> F:
    """Compile a :func:`kernel` into its callers: for short functions, and for parts of a long one."""
    return _compile(function, {**_BARE, "forceinline": True})


def pointed(function: Callable[..., Any], signature: Any) -> Any:
    """Compile a function now, for callers that have nothing but its address; see `rcss_hat.numeric.pointers`."""
    return _compile(function, {**_BARE, "no_cfunc_wrapper": False}, signature)


def compile_part(function: Callable[..., Any], *arguments: Any) -> None:
    """Compile a kernel as compiled callers call it, with arguments of these types.

    Parameters
    ----------
    function : callable
        What :func:`kernel` or another decorator of this module returned.
    arguments
        Values of the right types; nothing is called.
    """
    settings: Any = config
    if not settings.DISABLE_JIT:
        cast(Any, function).get_call_template(tuple(numba.typeof(a) for a in arguments), {})


def _compile(function: F, options: dict[str, Any], signature: Any = None) -> F:
    settings: Any = config
    compiled: Any = numba.njit(**{**_LEAN, **options})(function)
    if settings.DISABLE_JIT:
        return cast(F, compiled)
    _give_cache(compiled)
    if parts.SUPPORTED:
        parts.link_closely(compiled)
    _call_parts(compiled)
    if signature is not None:
        compiled.compile(signature)
        compiled.disable_compile()
    return cast(F, compiled)


def _give_cache(dispatcher: Any, as_part: bool = False) -> None:
    """Let a dispatcher keep what it compiles, and look first where somebody else has compiled it."""
    module = dispatcher.py_func.__module__
    own, read = own_folder(module), list(readable_folders(module))
    if as_part:
        own, read = own and own.parts, [folder.parts for folder in read]
    dispatcher._cache = Caches(dispatcher.py_func, read, own)


def _call_parts(kernel: Any) -> None:
    """Let compiled callers call a kernel as a part of theirs, compiled once for all integer types they pass it.

    Numba compiles a function anew for every constant and every width of integer that a compiled caller passes, which
    here is a sixth of all compilation. Callers cast their arguments to what this returns.
    """
    resolve, overload, compile_kernel = kernel.get_call_template, kernel.get_overload, kernel.compile

    @cache
    def part() -> Any:
        made = parts.Part(kernel)
        _give_cache(made, as_part=True)
        return made

    def resolve_widened(args: tuple[Any, ...], keywords: dict[str, Any]) -> Any:
        widened = tuple(_widened(a) for a in args), {name: _widened(a) for name, a in keywords.items()}
        with lean.undisturbed():
            return part().get_call_template(*widened) if parts.SUPPORTED else resolve(*widened)

    def compile_whole(signature: Any) -> Any:
        with lean.undisturbed():
            entry = compile_kernel(signature)
        if parts.SUPPORTED:
            parts.set_environments(next(reversed(kernel.overloads.values())))
        return entry

    kernel.get_call_template, kernel.compile = resolve_widened, compile_whole
    kernel.get_overload = lambda signature: part().get_overload(signature) if parts.SUPPORTED else overload(signature)


def _widened(kind: Any) -> Any:
    kind = types.unliteral(kind)
    return types.int64 if kind in _SMALL_INTEGERS else kind
