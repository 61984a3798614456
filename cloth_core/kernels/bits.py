"""Counting bits, in one instruction."""

from __future__ import annotations

from numba.core import types
from numba.extending import intrinsic

from cloth_core.kernels import part_kernel


@intrinsic
def ones(typingctx, word):
    """How many bits of an int64 are set; for use within kernels alone."""

    def codegen(context, builder, signature, args):
        return builder.ctpop(args[0])

    return types.int64(types.int64), codegen


@part_kernel
def ones_below(word, bit):
    """How many bits of an int64 are set below ``bit`` (0 .. 63)."""
    return ones(word & ((1 << bit) - 1))
