"""Arrays in compiled code from nothing but their addresses, for callers to whom many arguments are too expensive."""

from __future__ import annotations

from typing import Any

from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import get_itemsize, make_array, populate_array


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


array_at: Any = intrinsic(_array_at)
"""In kernels, ``array_at(address, shape, dtype)`` is the array that begins at an address; ``shape`` is a tuple of int,
``dtype`` a constant of the module. Whoever has the address sees to it that the array lives as long."""
