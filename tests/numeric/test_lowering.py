"""Compiled kernels reach fields and elements of record arrays as plain Python does, with far fewer instructions."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba.core import codegen
from numba.core.caching import NullCache

from rcss_hat.numeric import jit

pytestmark = pytest.mark.compiled
if jit.config.DISABLE_JIT:  # type: ignore[attr-defined]
    pytest.skip("nothing is compiled", allow_module_level=True)

INNER = np.dtype([("x", "f4"), ("n", "i2")])
RECORD = np.dtype([
    ("flag", "?"), ("small", "i1"), ("count", "u8"), ("number", "f8"), ("pair", "f4", (2,)),
    ("grid", "i4", (3, 2)), ("inner", INNER), ("inners", INNER, (2,)),
])  # fmt: skip


def records(count: int = 4, seed: int = 1) -> np.ndarray[Any, Any]:
    drawn = np.random.default_rng(seed)
    made = np.frombuffer(drawn.integers(0, 2, count * RECORD.itemsize, dtype=np.uint8).tobytes(), dtype=RECORD).copy()
    made["number"], made["pair"] = drawn.normal(size=count), drawn.normal(size=(count, 2))
    made["grid"] = drawn.integers(-9, 9, (count, 3, 2))
    made["inner"]["x"], made["inners"]["x"] = drawn.normal(size=count), drawn.normal(size=(count, 2))
    return made


@jit.kernel
def fields(r: Any, i: int, j: int, u: np.uint32, out: Any) -> None:
    out[0] = r["number"][i]
    out[1] = r["pair"][i, j]
    out[2] = r["grid"][i, u, j]
    out[3] = r["grid"][-1, 2, -2]
    out[4] = r["grid"][0, 0, 0]
    out[5] = r["flag"][i]
    out[6] = r["small"][u] + r["count"][i]
    out[7] = r["inner"]["x"][i]
    out[8] = r["inners"]["n"][i, j]
    out[9] = r["grid"].shape[1] * 100 + r["grid"].size + r["pair"].ndim
    out[-1] = r["grid"][i][2][1]


@jit.kernel
def writes(r: Any, i: int, j: int, plain: Any) -> None:
    r["number"][i] = j
    r["pair"][i, 0] = r["number"][i] / 3.0
    r["grid"][i, j, -1] = 2.9
    r["flag"][-1] = r["count"][i] > 0
    r["small"][0] = -3
    r["inners"]["x"][i, j] = 0.1
    plain[i, j] = i + 10 * j
    plain[-1, 0] += 1


@given(st.integers(-4, 3), st.integers(-2, 1), st.integers(0, 2), st.integers(0, 9))
def test_fields_and_elements_are_those_of_plain_python(i: int, j: int, u: int, seed: int) -> None:
    found, wanted = np.zeros(12), np.zeros(12)
    fields(records(seed=seed), i, j, u, found)
    fields.py_func(records(seed=seed), i, j, u, wanted)  # type: ignore[attr-defined]
    assert found.tobytes() == wanted.tobytes()


@given(st.integers(-4, 3), st.integers(-2, 1))
def test_what_is_written_is_what_plain_python_writes(i: int, j: int) -> None:
    for plain in (np.zeros((4, 3), dtype="f4"), np.zeros((4, 6), dtype="i4")[:, ::2], np.zeros((3, 4), order="F").T):
        found, wanted = (records(), plain.copy(order="K")), (records(), plain.copy(order="K"))
        writes(found[0], i, j, found[1])
        writes.py_func(wanted[0], i, j, wanted[1])  # type: ignore[attr-defined]
        assert found[0].tobytes() == wanted[0].tobytes() and found[1].tobytes() == wanted[1].tobytes()


def test_slices_of_records_stay_where_they_are() -> None:
    @jit.kernel
    def first_of(r: Any) -> float:
        one = r[1:2]
        one["number"][0] = 7.0
        return float(one["pair"][0, 1])

    r = records()
    assert first_of(r) == float(r["pair"][1, 1])
    assert r["number"].tolist().count(7.0) == 1 and r["number"][1] == 7.0


def test_an_access_is_written_in_far_fewer_instructions(monkeypatch: pytest.MonkeyPatch) -> None:
    written = list[int]()
    add = codegen.CPUCodeLibrary.add_ir_module

    def counted(self: Any, module: Any) -> None:
        written.append(str(module).count(" = "))
        add(self, module)

    def access(r: Any, i: int) -> float:
        return r["pair"][i, 1]  # type: ignore[no-any-return]

    monkeypatch.setattr(codegen.CPUCodeLibrary, "add_ir_module", counted)
    kind = numba.typeof(records())
    ours: Any = jit.kernel(access)
    ours._cache = NullCache()  # it is to be compiled, also when an earlier run has left it
    ours.compile((kind, numba.int64))
    of_kernel = written[0]
    written.clear()
    numba.njit(error_model="numpy", _nrt=False)(access).compile((kind, numba.int64))
    assert of_kernel < 0.6 * written[0]
