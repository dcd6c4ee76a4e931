"""Kernels are compiled without what they never need, and nothing else about numba changes."""

from __future__ import annotations

import gc
import operator
import threading
from typing import Any

import numba
import numpy as np
import pytest
from numba.core import compiler, registry, types
from numba.core.typing import templates

from rcss_hat.numeric import jit, lean, parts

pytestmark = pytest.mark.compiled
if jit.config.DISABLE_JIT:  # type: ignore[attr-defined]
    pytest.skip("nothing is compiled", allow_module_level=True)


def usual_passes() -> set[str]:
    manager: Any = compiler.DefaultPassBuilder.define_nopython_pipeline(_state())
    return {each.__name__ for each, _ in manager.passes}


def _state() -> Any:
    state: Any = compiler.StateDict()
    state.func_ir, state.flags = None, compiler.Flags()
    return state


def test_what_is_left_out_of_the_passes_is_what_numba_has() -> None:
    assert usual_passes() >= lean._UNNEEDED


def test_only_kernels_are_compiled_without_some_passes() -> None:
    @jit.njit
    def doubled(numbers: Any) -> Any:
        return np.array([2.0 * x for x in numbers])

    assert doubled(np.arange(3.0)).tolist() == [0.0, 2.0, 4.0]

    @jit.kernel
    def comprehends(numbers: Any) -> float:
        doubled = [2.0 * x for x in numbers]
        return doubled[0]

    with pytest.raises(numba.core.errors.NumbaError):
        comprehends(np.arange(3.0))


def test_garbage_is_collected_again_after_a_compilation_and_after_one_that_fails() -> None:
    assert gc.isenabled()
    with lean.undisturbed():
        assert not gc.isenabled()
        with lean.undisturbed():
            pass
        assert not gc.isenabled()
    assert gc.isenabled()
    with pytest.raises(RuntimeError), lean.undisturbed():
        raise RuntimeError
    assert gc.isenabled()


def test_threads_compile_side_by_side() -> None:
    def plus(much: float) -> Any:
        @jit.kernel
        def inner(x: float) -> float:
            return x + much

        @jit.kernel
        def outer(x: float) -> float:
            return 2.0 * inner(x)

        return outer

    kernels = [plus(float(k)) for k in range(8)]
    found: dict[int, float] = {}
    threads = [threading.Thread(target=lambda k=k: found.update({k: kernels[k](1.0)})) for k in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == {k: 2.0 + 2.0 * k for k in range(8)}
    assert gc.isenabled()


def test_a_call_is_resolved_once_for_each_function_and_types(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = list[tuple[Any, ...]]()
    apply = templates.ConcreteTemplate.apply

    def counted(self: Any, args: Any, kws: Any) -> Any:
        asked.append(args)
        return apply(self, args, kws)

    monkeypatch.setattr(templates.ConcreteTemplate, "apply", counted)
    context = lean.typing_context()
    context.refresh()
    minus = context.resolve_value_type(operator.sub)
    monkeypatch.setattr(context, "_resolved", {})
    first = context.resolve_function_type(minus, (types.float64, types.int64), {})
    before = len(asked)
    assert before > 0
    assert context.resolve_function_type(minus, (types.float64, types.int64), {}) is first
    assert len(asked) == before
    assert context.resolve_function_type(minus, (types.int64, types.int64), {}).return_type == types.int64


def test_sizes_of_types_are_those_that_numba_finds() -> None:
    machine, plain = parts.Part.targetdescr.target_context, registry.cpu_target.target_context
    for kind in (types.float32, types.int64, types.UniTuple(types.int8, 3), numba.typeof(np.zeros((2, 2)))):
        value = plain.get_value_type(kind)
        assert machine.get_abi_sizeof(value) == machine.get_abi_sizeof(value) == plain.get_abi_sizeof(value)
