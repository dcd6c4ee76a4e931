"""Kernels as parts of others: typed and lowered once, optimised and made machine code with the kernel Python calls.

Numba makes machine code of every function it compiles, and of everything that function calls once more: in a tree of
300 kernels that is most of the work. What compiled code calls is kept here as LLVM's code instead, which the kernel
that Python calls is linked from; the optimiser then sees the whole program, once.

Numba has no public way to do this, so what is overridden here is its own; :data:`SUPPORTED` is false where a version
of numba lacks it. Then everything is compiled as numba does, which takes longer and computes the same.
"""

from __future__ import annotations

import copy
from functools import cached_property
from typing import Any

from llvmlite import binding as llvm
from numba.core import codegen, cpu, dispatcher, registry

from rcss_hat.numeric import lean

SUPPORTED = all(
    hasattr(owner, name)
    for owner, name in (
        (codegen.JITCodeLibrary, "_get_module_for_linking"),
        (codegen.JITCodeLibrary, "_finalize_dynamic_globals"),
        (codegen.JITCodeLibrary, "_optimize_final_module"),
        (codegen.JITCPUCodegen, "_module_pass_manager"),
        (codegen.JITCodeLibrary, "serialize_using_object_code"),
        (codegen.JITCPUCodegen, "set_env"),
        (cpu.CPUContext, "get_executable"),
        (registry.CPUTarget, "_toplevel_target_context"),
        (dispatcher.Dispatcher, "add_overload"),
        (getattr(dispatcher, "_FunctionCompiler", None), "_customize_flags"),
    )
)


class _Library(codegen.JITCodeLibrary):
    """A function as LLVM's code, with the libraries of what it calls beside it."""

    def _optimize_functions(self, ll_module: Any) -> None:
        ll_module.data_layout = self._codegen._data_layout
        for function in ll_module.functions:
            if not function.is_declaration:
                manager, builder = self._codegen._function_pass_manager()
                manager.run(function, builder)

    def finalize(self) -> None:
        self._raise_if_finalized()
        self._finalize_dynamic_globals()
        self._finalized = True

    def _get_module_for_linking(self) -> Any:
        """Return a module with this function and everything it calls."""
        found: dict[Any, Any] = {}
        self._gather(found)
        module = found.pop(self).clone()
        for part in found.values():  # callers first: the linker takes in what is called by then
            module.link_in(part, preserve=True)
        return module

    def _gather(self, found: dict[Any, Any]) -> None:
        self._ensure_finalized()
        if self in found:
            return
        found[self] = self._shared()
        for library in self._linking_libraries:
            if isinstance(library, _Library):
                library._gather(found)
            elif library not in found:
                found[library] = library._get_module_for_linking()

    def _shared(self) -> Any:
        """Return the function's own module, whose symbols may be there more than once."""
        if self._shared_module is None:
            for function in self._final_module.functions:
                if not function.is_declaration and function.linkage == llvm.Linkage.external:
                    function.linkage = "linkonce_odr"
            self._shared_module = self._final_module
        return self._shared_module

    def serialize_using_object_code(self) -> tuple[str, str, bytes]:
        """Return what is written to the cache; whoever reads it needs no other file."""
        self._final_module = self._shared_module = self._get_module_for_linking()
        self._linking_libraries = []
        return self.name, "bitcode", self._final_module.as_bitcode()

    @classmethod
    def _unserialize(cls, owner: Any, state: tuple[str, str, bytes]) -> Any:
        name, _, data = state
        library = owner.create_library(name)
        library._final_module = llvm.parse_bitcode(data)
        library.finalize()
        return library


class _Codegen(codegen.JITCPUCodegen):
    _library_class = _Library

    def set_env(self, env_name: str, env: Any) -> None:
        """Do nothing: there is no machine code yet that could want it; see `set_environments`."""


class _Context(lean.Machine):
    def get_executable(self, library: Any, fndesc: Any, env: Any) -> Any:
        """Return a name for the function; nobody can call it from Python."""
        return object()


class _Whole(codegen.JITCodeLibrary):
    """What Python calls, linked with all its parts, which nobody else can call."""

    def _optimize_final_module(self) -> None:
        """Optimise, knowing all callers: parts lose the arguments they do not use, and move into an only caller.

        Numba does it twice, the first time for reference counts, which kernels have none of.
        """
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == llvm.Linkage.linkonce_odr:
                function.linkage = "internal"
        manager, builder = self._codegen._module_pass_manager()
        manager.run(self._final_module, builder)


class _WholeCodegen(codegen.JITCPUCodegen):
    _library_class = _Whole


class _Target(registry.CPUTarget):
    """The machine numba compiles for, with its state; only libraries are made in another way."""

    def __init__(self, context: type[lean.Machine], generator: type[codegen.JITCPUCodegen]) -> None:
        super().__init__("cpu")
        self._classes = context, generator

    @cached_property
    def _toplevel_target_context(self) -> Any:
        context = copy.copy(registry.cpu_target.target_context)
        context._internal_codegen = copy.copy(context._internal_codegen)
        context.__class__, context._internal_codegen.__class__ = self._classes
        context.typing_context, context._sizes = self.typing_context, {}
        return context

    @property
    def typing_context(self) -> Any:
        return lean.typing_context()


_WHOLE = _Target(lean.Machine, _WholeCodegen)


def link_closely(kernel: Any) -> None:
    """Let numba optimise a kernel together with its parts, which are for it alone.

    Parameters
    ----------
    kernel : numba dispatcher
    """
    lean.compare_flags_quickly(kernel)
    kernel._compiler.targetdescr = _WHOLE


class Part(registry.CPUDispatcher):
    """What compiled callers see of a kernel.

    Parameters
    ----------
    kernel : numba dispatcher
        What Python calls.
    """

    targetdescr = _Target(_Context, _Codegen)

    def __init__(self, kernel: Any) -> None:
        options = {**kernel.targetoptions, "no_cpython_wrapper": True}
        super().__init__(kernel.py_func, kernel.locals, options, kernel._compiler.pipeline_class)
        lean.compare_flags_quickly(self)

    def add_overload(self, result: Any) -> None:
        """Keep a compiled specialisation, for compiled callers only."""
        self.overloads[tuple(result.signature.args)] = result


def set_environments(result: Any) -> None:
    """Give the functions that a compiled kernel was linked from what they raise and print: their environments.

    Parameters
    ----------
    result : numba CompileResult
    """
    for environment in result._find_referenced_environments():
        result.codegen.set_env(environment.env_name, environment)
