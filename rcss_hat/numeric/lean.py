"""Numba's compiler without what kernels never need, which is a quarter of its time.

A kernel is plain arithmetic on arrays: it holds no closure, comprehension or ``with``, and makes no array. Its
compilation leaves out the passes for these, asks once per kernel that Python calls whether somebody has registered new
functions with numba, and remembers how a function's call with some types was resolved.
"""

from __future__ import annotations

import contextlib
import gc
from collections.abc import Iterator
from functools import cache
from typing import Any, ClassVar

from numba.core import compiler, compiler_machinery, cpu, registry, types
from numba.core.compiler_lock import global_compiler_lock
from numba.core.targetconfig import ConfigStack
from numba.core.typed_passes import NativeLowering
from numba.core.typing import Context

from rcss_hat.numeric.lowering import LeanLowering

_UNNEEDED = {
    "WithLifting", "InlineClosureLikes", "MakeFunctionToJitFunction", "InlineInlinables", "InlineOverloads",
    "FindLiterallyCalls", "LiteralUnroll", "LiteralPropagationSubPipelinePass", "NopythonRewrites", "AnnotateTypes",
    "NoPythonSupportedFeatureValidation", "DumpParforDiagnostics",
}  # fmt: skip
_open: list[None] = []


class Pipeline(compiler.CompilerBase):
    """Numba's usual passes, without those for what kernels do not hold."""

    _passes: ClassVar[list[tuple[Any, str]]] = []

    def define_pipelines(self) -> list[Any]:
        """Return the one way to compile a kernel."""
        if not self._passes:
            usual: Any = compiler.DefaultPassBuilder.define_nopython_pipeline(self.state)
            needed = ((each, why) for each, why in usual.passes if each.__name__ not in _UNNEEDED)
            self._passes.extend((LeanLowering if each is NativeLowering else each, why) for each, why in needed)
        manager = compiler_machinery.PassManager("kernel")
        for each, why in self._passes:
            manager.add_pass(each, why)
        manager.finalize()
        return [manager]


@contextlib.contextmanager
def undisturbed() -> Iterator[None]:
    """Compile a kernel with all it calls: nothing is registered with numba meanwhile, and no garbage is collected.

    The collector would take a third of the time of a compiler that keeps all it makes.
    """
    with global_compiler_lock:  # which numba takes, too, but later
        if _open:
            yield
            return
        collects = gc.isenabled()
        for context in (typing_context(), registry.cpu_target.target_context):
            context.refresh()
        _open.append(None)
        gc.disable()
        try:
            yield
        finally:
            _open.clear()
            if collects:
                gc.enable()


class Typing(Context):
    """Numba's knowledge of functions and types, with what came of asking it."""

    _resolved: dict[Any, Any]

    def refresh(self) -> None:
        """Look for functions that somebody has registered; while a kernel is compiled, for what that has made."""
        if _open:
            self._load_builtins()
        else:
            super().refresh()

    def resolve_function_type(self, func: Any, args: Any, kws: Any) -> Any:
        """Return the signature of a call, asking numba's many templates once for each function and types."""
        if type(func) is not types.Function:
            return super().resolve_function_type(func, args, kws)
        key = func, tuple(args), tuple(kws.items()), ConfigStack.top_or_none()
        found = self._resolved.get(key)
        if found is None:
            found = super().resolve_function_type(func, args, kws)
            if found is not None and all(kind.is_precise() for kind in (*args, *kws.values())):
                self._resolved[key] = found
        return found


@cache
def typing_context() -> Any:
    """Return numba's own context as a `Typing`: both see the same functions."""
    context = Typing.__new__(Typing)
    context.__dict__.update(registry.cpu_target.typing_context.__dict__, _resolved={})
    return context


class Machine(cpu.CPUContext):
    """What numba knows of the machine it compiles for."""

    _sizes: dict[str, int]

    def refresh(self) -> None:
        """Look for implementations that somebody has registered; while a kernel is compiled, for what that has made."""
        if _open:
            for known in list(self._registries):
                self.install_registry(known)
        else:
            super().refresh()

    def get_abi_sizeof(self, ty: Any) -> int:
        """Return the size of a type (bytes), which numba asks LLVM's parser for, for every variable."""
        size = self._sizes.get(str(ty))
        if size is None:
            size = self._sizes[str(ty)] = super().get_abi_sizeof(ty)
        return size


class _Flags(compiler.Flags):
    """Flags of a compilation that are quick to compare, which numba does some 50 times per line it compiles."""

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        if isinstance(other, _Flags):
            return bool(self._values == other._values)
        return bool(super().__eq__(other))

    def __hash__(self) -> int:
        return len(self._values)

    def __str__(self) -> str:
        return "flags"  # for numba's events, which nobody here reads

    __repr__ = __str__


def compare_flags_quickly(kernel: Any) -> None:
    """Let numba compare the flags of a kernel's compilation by what is set."""
    kernel._compiler._customize_flags = _Flags


@cache
def _described(record: Any) -> str:
    return str(_describe(record))


_Record: Any = types.Record
_describe = _Record.__repr__
_Record.__repr__ = _described  # numba spells out all fields of a record thousands of times, a tenth of its time
