"""t −= Σ_p s_p v_p for four adjacent elements: the inner loop of elimination, in vectors.

The compiler cannot tell that the columns do not overlap, and does not use vector instructions for
the plain loop.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from nrchain._compile import ARITHMETIC

LANES = 4
"""Elements of one call."""

_FAST = sorted(ARITHMETIC)
_REAL = ir.DoubleType()


def _define(
    typing: Any,
    source: Any,
    first: Any,
    start: Any,
    target: Any,
    column: Any,
    to: Any,
    factors: Any,
) -> Any:
    """The signature of ``subtract``, and the function that generates its instructions."""
    signature = types.void(source, first, start, target, column, to, factors)
    is_complex = isinstance(source.dtype, types.Complex)
    width = LANES * (2 if is_complex else 1)
    vector = ir.VectorType(_REAL, width)

    def place(context: Any, builder: Any, kind: Any, array: Any, index: Any) -> Any:
        struct = context.make_array(kind)(context, builder, array)
        shape = cgutils.unpack_tuple(builder, struct.shape, 2)
        row, element = index
        offset = builder.add(builder.mul(row, shape[1]), element)
        pointer = builder.gep(struct.data, [offset])
        return builder.bitcast(pointer, vector.as_pointer())

    def load(builder: Any, pointer: Any) -> Any:
        loaded = builder.load(pointer)
        loaded.align = 8
        return loaded

    def splat(builder: Any, values: list[Any]) -> Any:
        """The vector that repeats ``values``, one number or a pair."""
        filled = ir.Constant(vector, ir.Undefined)
        for lane, value in enumerate(values):
            filled = builder.insert_element(filled, value, ir.Constant(ir.IntType(32), lane))
        return shuffle(builder, filled, [lane % len(values) for lane in range(width)])

    def shuffle(builder: Any, value: Any, lanes: list[int]) -> Any:
        mask = ir.Constant(ir.VectorType(ir.IntType(32), width), lanes)
        return builder.shuffle_vector(value, ir.Constant(vector, ir.Undefined), mask)

    def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        source_, first_, start_, target_, column_, to_, factors_ = arguments
        out = place(context, builder, target, target_, (column_, to_))
        total = load(builder, out)
        for p, factor in enumerate(cgutils.unpack_tuple(builder, factors_, len(factors))):
            row = builder.add(first_, ir.Constant(first_.type, p))
            values = load(builder, place(context, builder, source, source_, (row, start_)))
            if not is_complex:
                product = builder.fmul(splat(builder, [factor]), values, flags=_FAST)
                total = builder.fsub(total, product, flags=_FAST)
                continue
            number = context.make_complex(builder, factors.dtype, value=factor)
            product = builder.fmul(splat(builder, [number.real]), values, flags=_FAST)
            total = builder.fsub(total, product, flags=_FAST)
            turned = shuffle(builder, values, [lane ^ 1 for lane in range(width)])
            # i (x + iy) = −y + ix
            signed = splat(builder, [builder.fneg(number.imag), number.imag])
            product = builder.fmul(signed, turned, flags=_FAST)
            total = builder.fsub(total, product, flags=_FAST)
        builder.store(total, out).align = 8
        return context.get_dummy_value()

    return signature, generate


subtract: Any = intrinsic(_define)
"""target[column, to:to + 4] −= Σ_p factors[p] source[first + p, start:start + 4], in kernels.

``subtract(source, first, start, target, column, to, factors)`` takes real or complex arrays in the
order of C, and a tuple of the same kind of numbers. Indices are not checked.
"""
