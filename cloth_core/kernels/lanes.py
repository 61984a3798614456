"""Vectors of processor lanes, for the few loops whose shape LLVM does not find by itself.

A value of :class:`Lanes` is ``LANES`` numbers of one type that are worked on at once; LLVM maps it to whatever
vector registers the processor has. The functions below are for use within kernels alone.
"""

from __future__ import annotations

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.extending import intrinsic, register_model

LANES = 16
"""Numbers in a vector: two registers of eight floats hide the latency of a product."""

_FUSED = ("contract",)


class Lanes(types.Type):
    """The numba type of a vector of ``LANES`` numbers of ``dtype``."""

    def __init__(self, dtype: types.Float) -> None:
        self.dtype = dtype
        super().__init__(name=f"Lanes({dtype})")


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: object, kind: Lanes) -> None:
        element = ir.DoubleType() if kind.dtype == types.float64 else ir.FloatType()
        super().__init__(manager, kind, ir.VectorType(element, LANES))


@intrinsic
def spread(typingctx, number):
    """All lanes hold ``number``."""

    def codegen(context, builder, signature, args):
        return _spread(context, builder, signature.return_type, args[0])

    return Lanes(number)(number), codegen


@intrinsic
def load(typingctx, array, start):
    """The lanes that begin at ``array[start]``, of a contiguous (N,) array."""

    def codegen(context, builder, signature, args):
        place = _place(context, builder, signature, args)
        return builder.load(place, align=_alignment(signature.args[0]))

    return Lanes(array.dtype)(array, start), codegen


@intrinsic
def store(typingctx, array, start, lanes):
    """Put ``lanes`` into ``array``, from ``start`` on."""

    def codegen(context, builder, signature, args):
        place = _place(context, builder, signature, args[:2], signature.args[2])
        builder.store(args[2], place, align=_alignment(signature.args[0]))
        return context.get_dummy_value()

    return types.void(array, start, lanes), codegen


@intrinsic
def add_product(typingctx, total, lanes, number):
    """``total`` + ``lanes`` * ``number``, rounded once where the processor can."""

    def codegen(context, builder, signature, args):
        factor = _spread(context, builder, signature.return_type, args[2])
        return builder.fadd(args[0], builder.fmul(args[1], factor, flags=_FUSED), flags=_FUSED)

    return total(total, lanes, total.dtype), codegen


def _spread(context, builder, kind, number):
    vector = context.get_value_type(kind)
    one = builder.insert_element(ir.Constant(vector, ir.Undefined), number, ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(one, one, ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES))


def _place(context, builder, signature, args, lanes=None):
    kind = signature.args[0]
    array = context.make_array(kind)(context, builder, value=args[0])
    pointer = cgutils.gep(builder, array.data, args[1])
    vector = context.get_value_type(lanes or signature.return_type)
    return builder.bitcast(pointer, vector.as_pointer())


def _alignment(kind):
    return kind.dtype.bitwidth // 8
