"""How kernels get at fields and elements of record arrays: in less than half of the instructions numba writes for it.

``match["pos"][0, i, 1]`` is what kernels do most. Numba takes the arrays apart and puts them together through memory,
part by part, and leaves it to the optimiser to find out that it need not have. Here parts are taken out of values,
which leaves less to write, to read and to optimise; what is computed is the same.
"""

from __future__ import annotations

from functools import reduce
from typing import Any

from llvmlite import ir as llvmir
from numba.core import cgutils, ir, lowering, typed_passes, types
from numba.core.compiler_machinery import register_pass
from numba.core.imputils import impl_ret_borrowed
from numba.np.arrayobj import load_item, store_item


class _Parts:
    """An array's value in a kernel, taken apart."""

    def __init__(self, lower: Lowering, kind: types.Array, value: Any) -> None:
        self._builder, self._value = lower.builder, value
        self._position = lower.context.data_model_manager[kind].get_field_position

    def of(self, name: str, axis: int | None = None) -> Any:
        """Return a field; of shape and strides that of an axis."""
        at = self._position(name)
        return self._builder.extract_value(self._value, at if axis is None else [at, axis])


class Lowering(lowering.Lower):
    """Numba's own, but for fields of record arrays and for single numbers."""

    def lower_inst(self, inst: Any) -> Any:
        """Write an instruction; numba would search in vain for a special way to set ``x[0]``."""
        if isinstance(inst, ir.StaticSetItem) and inst.index_var and self._is_number(inst.target, inst.index_var):
            return self.lower_setitem(inst.target, inst.index_var, inst.value, self.fndesc.calltypes[inst])
        return super().lower_inst(inst)

    def lower_expr(self, resty: Any, expr: Any) -> Any:
        """Write an expression."""
        if expr.op == "static_getitem":
            kind = self.typeof(expr.value.name)
            if isinstance(kind, types.Array) and isinstance(kind.dtype, types.Record) and isinstance(expr.index, str):
                return self._field(kind, self.loadvar(expr.value.name), expr.index, resty)
            if expr.index_var and self._is_number(expr.value, expr.index_var):
                return self.lower_getitem(resty, expr, expr.value, expr.index_var, self.fndesc.calltypes[expr])
        return super().lower_expr(resty, expr)

    def lower_getitem(self, resty: Any, expr: Any, value: Any, index: Any, signature: Any) -> Any:
        """Write ``value[index]``."""
        if not self._is_number(value, index):
            return super().lower_getitem(resty, expr, value, index, signature)
        kind = self.typeof(value.name)
        number = load_item(self.context, self.builder, kind, self._place(kind, value, index))
        return self.context.cast(self.builder, number, kind.dtype, resty)

    def lower_setitem(self, target_var: Any, index_var: Any, value_var: Any, signature: Any) -> Any:
        """Write ``target_var[index_var] = value_var``."""
        if not self._is_number(target_var, index_var):
            return super().lower_setitem(target_var, index_var, value_var, signature)
        kind = self.typeof(target_var.name)
        value = self.loadvar(value_var.name)
        number = self.context.cast(self.builder, value, self.typeof(value_var.name), kind.dtype)
        return store_item(self.context, self.builder, kind, number, self._place(kind, target_var, index_var))

    def _is_number(self, array: Any, index: Any) -> bool:
        """Tell whether an index, as many integers as the array has axes, names a single number."""
        kind, indices = self.typeof(array.name), self._indices(index)
        return (
            isinstance(kind, types.Array)
            and isinstance(kind.dtype, types.Number | types.Boolean)
            and len(indices) == kind.ndim
            and all(isinstance(each, types.Integer) for each in indices)
            and not self.context.enable_boundscheck
        )

    def _indices(self, index: Any) -> tuple[Any, ...]:
        kind: Any = self.typeof(index.name)
        several: bool = isinstance(kind, types.BaseTuple)
        return tuple(kind.types) if several else (kind,)

    def _place(self, kind: types.Array, array: Any, index: Any) -> Any:
        """Return a pointer to a single number."""
        builder, parts, value = self.builder, _Parts(self, kind, self.loadvar(array.name)), self.loadvar(index.name)
        several = isinstance(self.typeof(index.name), types.BaseTuple)
        steps = []
        for axis, of in enumerate(self._indices(index)):
            if isinstance(of, types.IntegerLiteral) and of.literal_value == 0:
                continue
            number = builder.extract_value(value, axis) if several else value
            steps.append(self._step(kind, parts, axis, self._whole(parts, axis, of, number)))
        offset = reduce(builder.add, steps) if steps else self.context.get_constant(types.intp, 0)
        if kind.layout == "C":
            return builder.gep(parts.of("data"), [offset])
        return cgutils.pointer_add(builder, parts.of("data"), offset)

    def _whole(self, parts: _Parts, axis: int, of: Any, value: Any) -> Any:
        """Return an index that counts from the front."""
        if isinstance(of, types.IntegerLiteral) and of.literal_value > 0:
            return self.context.get_constant(types.intp, of.literal_value)
        if not of.signed:
            return self.context.cast(self.builder, value, of, types.uintp)
        value = self.context.cast(self.builder, value, of, types.intp)
        behind = self.builder.add(value, parts.of("shape", axis))
        return self.builder.select(self.builder.icmp_signed("<", value, value.type(0)), behind, value)

    def _step(self, kind: types.Array, parts: _Parts, axis: int, index: Any) -> Any:
        """Return how far an index of one axis leads: in elements, or in bytes where the layout is not C's."""
        if kind.layout != "C":
            return self.builder.mul(parts.of("strides", axis), index)
        return reduce(self.builder.mul, (parts.of("shape", later) for later in range(axis + 1, kind.ndim)), index)

    def _field(self, kind: types.Array, value: Any, name: str, resty: types.Array) -> Any:
        """Return a field of a record array, which is an array with the axes of the field after those of the records."""
        context, builder, parts = self.context, self.builder, _Parts(self, kind, value)
        record: Any = kind.dtype
        field = record.typeof(name)
        inner = (field.shape, field.strides) if isinstance(field, types.NestedArray) else ((), ())
        constant = [[context.get_constant(types.intp, each) for each in of] for of in inner]
        shape = [parts.of("shape", axis) for axis in range(kind.ndim)] + constant[0]
        strides = [parts.of("strides", axis) for axis in range(kind.ndim)] + constant[1]
        item = context.get_data_type(resty.dtype)
        begin = context.get_constant(types.intp, record.offset(name))
        made = {
            "meminfo": parts.of("meminfo"),
            "parent": parts.of("parent"),
            "nitems": reduce(builder.mul, shape),
            "itemsize": context.get_constant(types.intp, context.get_abi_sizeof(item)),
            "data": cgutils.pointer_add(builder, parts.of("data"), begin, return_type=item.as_pointer()),
            "shape": cgutils.pack_array(builder, shape),
            "strides": cgutils.pack_array(builder, strides),
        }
        model, array = (
            context.data_model_manager[resty],
            llvmir.Constant(context.get_value_type(resty), llvmir.Undefined),
        )
        for field_name, part in made.items():
            array = builder.insert_value(array, part, model.get_field_position(field_name))
        return impl_ret_borrowed(context, builder, resty, array)


@register_pass(mutates_CFG=True, analysis_only=False)
class LeanLowering(typed_passes.NativeLowering):
    """Numba's pass from its own instructions to LLVM's, with `Lowering`."""

    _name = "lean_lowering"

    @property
    def lowering_class(self) -> type[Lowering]:
        """Return what writes the instructions."""
        return Lowering
