"""Kernels called by their address, so that compiled code can call what it was not compiled with.

A compiled loop calls a kernel of a transfer method, which may come from another package. Were the kernel an argument,
numba would compile the loop anew for every method and could not cache it. So the loop finds the kernel's address in a
record and calls whatever stands there, by a signature that is fixed: a call costs some 20 ns.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import config, types
from numba.core import cgutils
from numba.extending import intrinsic

from rcss_hat.numeric.jit import pointed


class Slot:
    """A place for kernels of one signature.

    Parameters
    ----------
    returns : numba type
    arguments : numba types

    Attributes
    ----------
    at : callable
        In kernels: ``SLOT.at(address)`` is the kernel with that address; assign it to a name of its module first.
    """

    def __init__(self, returns: types.Type, *arguments: types.Type) -> None:
        self.signature = returns(*arguments)
        self._addresses: dict[Callable[..., Any], int] = {}
        self._kept: list[Callable[..., Any]] = []
        settings: Any = config
        self.at: Any = self._plain_at if settings.DISABLE_JIT else _caller(types.FunctionType(self.signature))

    def address(self, function: Callable[..., Any]) -> int:
        """Compile a plain Python function for this place, or load it from the cache, and return its address.

        Addresses hold for this process only.

        Raises
        ------
        TypeError
            When the function does not return what the place wants.
        """
        if function not in self._addresses:
            self._addresses[function] = self._compile(function)
        return self._addresses[function]

    def _compile(self, function: Callable[..., Any]) -> int:
        settings: Any = config
        if settings.DISABLE_JIT:
            self._kept.append(function)
            return len(self._kept) - 1
        compiled = pointed(function, self.signature)
        self._kept.append(compiled)  # its machine code would go with it
        entry = compiled.overloads[tuple(self.signature.args)]
        if entry.signature.return_type != self.signature.return_type:
            returned, wanted = entry.signature.return_type, self.signature.return_type
            raise TypeError(f"{function.__name__} returns {returned}, not {wanted}")
        return int(entry.library.get_pointer_to_function(entry.fndesc.llvm_cfunc_wrapper_name))

    def _plain_at(self, address: int) -> Callable[..., Any]:
        return self._kept[int(address)]


def _caller(kind: types.FunctionType) -> Any:
    @intrinsic
    def at(typing_context: Any, address: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            function = cgutils.create_struct_proxy(kind)(context, builder)
            function.c_addr = builder.inttoptr(arguments[0], cgutils.voidptr_t)
            function.py_addr = cgutils.get_null_value(function.py_addr.type)
            if hasattr(function, "jit_addr"):  # numba 0.60 and later: another way to the same function
                function.jit_addr = cgutils.get_null_value(function.jit_addr.type)
            return function._getvalue()

        return kind(address), generate

    return at
