"""Arrays in compiled code from nothing but their addresses, for callers to whom many arguments are too expensive."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
from numba import config, types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import get_itemsize, make_array, populate_array
from numpy.typing import DTypeLike, NDArray


def address_of(array: NDArray[Any]) -> int:
    """Return where an array begins.

    Raises
    ------
    ValueError
        When its elements do not lie one after the other, in C's order: an address tells no strides.
    """
    if not array.flags.c_contiguous:
        raise ValueError("an address stands for an array in C's order, without gaps")
    return int(array.ctypes.data)


def _plain_array_at(address: int, shape: tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
    kind, count = np.dtype(dtype), int(np.prod(shape))
    if count == 0:
        return np.zeros(shape, dtype=kind)
    memory = (ctypes.c_byte * (count * kind.itemsize)).from_address(int(address))
    return np.ctypeslib.as_array(memory).view(kind).reshape(shape)


def _array_at(typing_context: Any, address: Any, shape: Any, dtype: Any) -> Any:
    """Type the call of `array_at`, and generate its code."""
    kind = types.Array(dtype.dtype, len(shape), "C")

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        array = make_array(kind)(context, builder)
        size = context.get_constant(types.intp, get_itemsize(context, kind))
        sides = [
            context.cast(builder, side, of, types.intp)
            for side, of in zip(cgutils.unpack_tuple(builder, arguments[1]), signature.args[1], strict=True)
        ]
        strides = [size]
        for side in reversed(sides[1:]):
            strides.insert(0, builder.mul(strides[0], side))
        data = builder.inttoptr(arguments[0], context.get_data_type(kind.dtype).as_pointer())
        populate_array(array, data=data, shape=sides, strides=strides, itemsize=size, meminfo=None)
        return array._getvalue()

    return kind(types.int64, shape, dtype), generate


_settings: Any = config
array_at: Any = _plain_array_at if _settings.DISABLE_JIT else intrinsic(_array_at)
"""``array_at(address, shape, dtype)`` is the array that begins at an address; ``shape`` is a tuple of int,
``dtype`` a constant of the module. Whoever has the address sees to it that the array lives as long."""
