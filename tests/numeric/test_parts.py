"""Kernels as parts of the kernels that call them."""

from __future__ import annotations

import importlib.util
import itertools
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba.core import event

from rcss_hat.numeric import cache_folders, jit, parts

pytestmark = pytest.mark.compiled
SOURCE = """
from rcss_hat.numeric.jit import inlined, kernel, njit

@kernel
def tripled(numbers, k):
    return 3.0 * numbers[k]

@inlined
def sum_of_tripled(numbers):
    total = 0.0
    for k in range(numbers.shape[0]):
        total += tripled(numbers, k)
    return total

@njit
def checked(numbers):
    if numbers.shape[0] == 0:
        raise ValueError("no numbers at all")
    return sum_of_tripled(numbers)

@njit
def whole(numbers):
    return checked(numbers) + 1.0
"""
_names = itertools.count()


@pytest.fixture
def load(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[], Any]]:
    """Import the kernels above anew each time, as another process and another installation would."""
    if jit.config.DISABLE_JIT:  # type: ignore[attr-defined]
        pytest.skip("nothing is compiled")
    monkeypatch.setenv("RCSS_HAT_CACHE", str(tmp_path / "cache"))
    for found in (cache_folders.cache_root, cache_folders.shared_roots):
        found.cache_clear()
    name = f"kernels_{os.getpid()}_{next(_names)}"

    def imported() -> Any:
        file = tmp_path / f"installation_{next(_names)}" / f"{name}.py"
        file.parent.mkdir()
        file.write_text(SOURCE)
        spec = importlib.util.spec_from_file_location(name, file)
        assert spec is not None and spec.loader is not None
        module = sys.modules[name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    yield imported
    sys.modules.pop(name, None)
    monkeypatch.undo()
    for found in (cache_folders.cache_root, cache_folders.shared_roots):
        found.cache_clear()


class _Compiled(event.Listener):
    def __init__(self) -> None:
        self.dispatchers: list[Any] = []

    def on_start(self, event: Any) -> None:
        self.dispatchers.append(event.data["dispatcher"])

    def on_end(self, event: Any) -> None:
        pass


def compiled_by(call: Callable[[], object]) -> list[tuple[str, bool]]:
    """Names of what a call compiled, and whether it was compiled as a part."""
    listener = _Compiled()
    event.register("numba:compile", listener)
    try:
        call()
    finally:
        event.unregister("numba:compile", listener)
    return sorted((d.py_func.__name__, isinstance(d, parts.Part)) for d in listener.dispatchers)


NUMBERS = np.array([1.0, 2.0, 4.0])


def test_this_version_of_numba_is_known() -> None:
    assert parts.SUPPORTED


def test_only_what_python_calls_is_more_than_a_part(load: Callable[[], Any]) -> None:
    kernels = load()
    expected = [("checked", True), ("sum_of_tripled", True), ("tripled", True), ("whole", False)]
    assert compiled_by(lambda: kernels.whole(NUMBERS)) == expected
    assert kernels.whole(NUMBERS) == 22.0
    assert compiled_by(lambda: kernels.sum_of_tripled(NUMBERS)) == [("sum_of_tripled", False)]


def test_another_installation_compiles_nothing_and_links_parts(load: Callable[[], Any]) -> None:
    load().whole(NUMBERS)
    again = load()
    assert compiled_by(lambda: again.whole(NUMBERS)) == [] and again.whole(NUMBERS) == 22.0
    assert compiled_by(lambda: again.checked(NUMBERS)) == [("checked", False)]
    assert again.checked(NUMBERS) == 21.0


def test_a_part_is_compiled_for_itself(load: Callable[[], Any]) -> None:
    kernels = load()
    assert compiled_by(lambda: jit.compile_part(kernels.tripled, NUMBERS, 0)) == [("tripled", True)]
    assert compiled_by(lambda: kernels.sum_of_tripled(NUMBERS)) == [("sum_of_tripled", False)]


@pytest.mark.parametrize("supported", [True, False])
def test_parts_raise_what_they_raise_and_count_the_same(
    load: Callable[[], Any], monkeypatch: pytest.MonkeyPatch, supported: bool
) -> None:
    monkeypatch.setattr(parts, "SUPPORTED", supported)
    for kernels in (load(), load()):
        assert kernels.whole(NUMBERS) == 22.0
        with pytest.raises(ValueError, match="no numbers at all"):
            kernels.whole(NUMBERS[:0])
    made = compiled_by(lambda: kernels.whole(NUMBERS.astype(np.float32)))
    assert any(part for _, part in made) is supported
