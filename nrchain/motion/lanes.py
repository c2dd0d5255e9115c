"""The inner loops of elimination as machine instructions: six columns at a time, four rows at once.

The compiler cannot tell that columns do not overlap, and uses no vector instructions for plain
loops over them. Written out number by number, these loops would take seconds to compile. Here each
is a function that kernels call, with its instructions generated for real or complex arrays.
Arrays are two-dimensional in the order of C, and indices are not checked.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from nrchain._compile import ARITHMETIC

LANES = 4
"""Rows of one call of ``subtract``."""

STEP = 6
"""Columns of a step."""

TINY = 1e-250
"""What is smaller is taken as 0: solutions that decay along a chain would end in numbers below the
normal range, which are slow."""

_FAST = sorted(ARITHMETIC)
_REAL, _INDEX = ir.DoubleType(), ir.IntType(32)

Parts = tuple[Any, ...]
"""A number in registers: its real part, and its imaginary part if it is complex."""


class _Array:
    """An array in a kernel under compilation."""

    def __init__(self, context: Any, builder: Any, kind: Any, value: Any) -> None:
        struct = context.make_array(kind)(context, builder, value)
        self._builder, self._data = builder, struct.data
        self._rows = cgutils.unpack_tuple(builder, struct.shape, 2)[1]

    def at(self, column: Any, row: Any) -> Any:
        """The address of an element."""
        offset = self._builder.add(self._builder.mul(column, self._rows), row)
        return self._builder.bitcast(self._builder.gep(self._data, [offset]), _REAL.as_pointer())


class _Numbers:
    """Arithmetic with real numbers, or with pairs of parts."""

    def __init__(self, builder: Any, is_complex: bool) -> None:
        self.builder, self.count = builder, 2 if is_complex else 1

    def load(self, address: Any) -> Parts:
        return tuple(self.builder.load(self._part(address, k)) for k in range(self.count))

    def store(self, number: Parts, address: Any) -> None:
        for k, part in enumerate(number):
            self.builder.store(part, self._part(address, k))

    def _part(self, address: Any, k: int) -> Any:
        return self.builder.gep(address, [ir.Constant(_INDEX, k)]) if k else address

    def product(self, a: Parts, b: Parts) -> Parts:
        if self.count == 1:
            return (self._times(a[0], b[0]),)
        zero = ir.Constant(_REAL, 0.0)
        real, imaginary = self.less_product((zero, zero), a, b)
        return self.builder.fneg(real), self.builder.fneg(imaginary)

    def less_product(self, total: Parts, a: Parts, b: Parts) -> Parts:
        """total − a b."""
        subtract, add = self.builder.fsub, self.builder.fadd
        first = subtract(total[0], self._times(a[0], b[0]), flags=_FAST)
        if self.count == 1:
            return (first,)
        second = subtract(total[1], self._times(a[0], b[1]), flags=_FAST)
        return (
            add(first, self._times(a[1], b[1]), flags=_FAST),
            subtract(second, self._times(a[1], b[0]), flags=_FAST),
        )

    def _times(self, a: Any, b: Any) -> Any:
        return self.builder.fmul(a, b, flags=_FAST)

    def without_tiny(self, numbers: list[Parts]) -> list[Parts]:
        """The numbers, or zeros if all are tiny."""
        size, zero = ir.Constant(_REAL, 0.0), ir.Constant(_REAL, 0.0)
        magnitude = self.builder.module.declare_intrinsic("llvm.fabs", [_REAL])
        for part in (part for number in numbers for part in number):
            size = self.builder.fadd(size, self.builder.call(magnitude, [part]), flags=_FAST)
        tiny = self.builder.fcmp_ordered("<", size, ir.Constant(_REAL, TINY))
        return [tuple(self.builder.select(tiny, zero, part) for part in n) for n in numbers]


def _solution(is_lower: bool) -> Any:
    """The function of a triangular system of six, for ``intrinsic``."""

    def define(
        typing: Any, columns: Any, first: Any, diagonal: Any, target: Any, column: Any, row: Any
    ) -> Any:
        kind = columns.dtype
        result = types.UniTuple(kind, STEP)
        signature = result(columns, first, diagonal, target, column, row)

        def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
            factors = _Array(context, builder, columns, arguments[0])
            vectors = _Array(context, builder, target, arguments[3])
            numbers = _Numbers(builder, isinstance(kind, types.Complex))

            def shifted(value: Any, by: int) -> Any:
                return builder.add(value, ir.Constant(value.type, by))

            def factor(p: int, q: int) -> Parts:
                return numbers.load(factors.at(shifted(arguments[1], p), shifted(arguments[2], q)))

            places = [vectors.at(arguments[4], shifted(arguments[5], p)) for p in range(STEP)]
            found = [numbers.load(place) for place in places]
            for p in range(STEP) if is_lower else reversed(range(STEP)):
                if is_lower:
                    found[p] = numbers.product(found[p], factor(p, p))
                for q in range(p + 1, STEP) if is_lower else range(p):
                    found[q] = numbers.less_product(found[q], factor(p, q), found[p])
            found = numbers.without_tiny(found)
            for number, place in zip(found, places, strict=True):
                numbers.store(number, place)
            return context.make_tuple(
                builder, result, [_packed(context, builder, kind, number) for number in found]
            )

        return signature, generate

    return define


def _packed(context: Any, builder: Any, kind: Any, number: Parts) -> Any:
    """A number as numba keeps it."""
    if len(number) == 1:
        return number[0]
    value = context.make_complex(builder, kind)
    value.real, value.imag = number
    return value._getvalue()


def _subtraction(
    typing: Any,
    source: Any,
    first: Any,
    start: Any,
    target: Any,
    column: Any,
    to: Any,
    factors: Any,
) -> Any:
    """The function of ``subtract``, for ``intrinsic``."""
    signature = types.void(source, first, start, target, column, to, factors)
    is_complex = isinstance(source.dtype, types.Complex)
    width = LANES * (2 if is_complex else 1)
    vector = ir.VectorType(_REAL, width)
    unset = ir.Constant(vector, ir.Undefined)

    def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        def load(address: Any) -> Any:
            loaded = builder.load(address)
            loaded.align = 8
            return loaded

        def shuffled(value: Any, lanes: list[int]) -> Any:
            mask = ir.Constant(ir.VectorType(_INDEX, width), lanes)
            return builder.shuffle_vector(value, unset, mask)

        def repeated(*values: Any) -> Any:
            """The vector that repeats one number or a pair."""
            filled = unset
            for lane, value in enumerate(values):
                filled = builder.insert_element(filled, value, ir.Constant(_INDEX, lane))
            return shuffled(filled, [lane % len(values) for lane in range(width)])

        def less(total: Any, factor: Any, values: Any) -> Any:
            product = builder.fmul(factor, values, flags=_FAST)
            return builder.fsub(total, product, flags=_FAST)

        sources = _Array(context, builder, source, arguments[0])
        place = _Array(context, builder, target, arguments[3]).at(arguments[4], arguments[5])
        place = builder.bitcast(place, vector.as_pointer())
        total = load(place)
        for p, factor in enumerate(cgutils.unpack_tuple(builder, arguments[6], len(factors))):
            row = builder.add(arguments[1], ir.Constant(arguments[1].type, p))
            values = load(builder.bitcast(sources.at(row, arguments[2]), vector.as_pointer()))
            if not is_complex:
                total = less(total, repeated(factor), values)
                continue
            number = context.make_complex(builder, factors.dtype, value=factor)
            total = less(total, repeated(number.real), values)
            # i (x + iy) = −y + ix
            turned = shuffled(values, [lane ^ 1 for lane in range(width)])
            total = less(total, repeated(builder.fneg(number.imag), number.imag), turned)
        builder.store(total, place).align = 8
        return context.get_dummy_value()

    return signature, generate


subtract: Any = intrinsic(_subtraction)
"""target[column, to:to + 4] −= Σ_p factors[p] source[first + p, start:start + 4].

``subtract(source, first, start, target, column, to, factors)`` with a tuple of factors.
"""

solve_lower: Any = intrinsic(_solution(is_lower=True))
"""x = L⁻¹ target[column, row:row + 6], in place and as a tuple.

``solve_lower(columns, first, diagonal, target, column, row)``: L is the lower triangle of the six
columns from ``first`` on, rows from ``diagonal`` on, with the reciprocals of its diagonal.
"""

solve_upper: Any = intrinsic(_solution(is_lower=False))
"""As ``solve_lower`` for the upper triangle, with ones on its diagonal."""
