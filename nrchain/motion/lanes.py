"""Machine instructions for elimination: numbers and vectors of four, real or complex.

The compiler cannot tell that columns do not overlap, and uses no vector instructions for plain
loops over them. Written out number by number, these loops would take seconds to compile.
:mod:`nrchain.motion.panel_steps` has functions that kernels call, and generates their instructions
with the classes here.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils

from nrchain._compile import ARITHMETIC

LANES = 4
"""Rows of a vector of the machine."""

STEP = 6
"""Columns of a step."""

TINY = 1e-250
"""What is smaller is taken as 0: solutions that decay along a chain would end in numbers below the
normal range, which are slow."""

LARGEST = 1e300
"""Bound on |z|² of a pivot, within which 1/z = z*/|z|²."""

LINE = 64
"""Bytes that a cache fetches at once."""

_FAST = sorted(ARITHMETIC)
REAL, INDEX = ir.DoubleType(), ir.IntType(32)
BYTES = ir.IntType(8).as_pointer()

Parts = tuple[Any, ...]
"""A number in registers: its real part, and its imaginary part if it is complex. Or vectors that
repeat each of them."""


class Numbers:
    """Arithmetic with numbers and vectors of four numbers, real or complex.

    Complex numbers stand in memory, and in vectors, as pairs. Products with a vector need the
    vector times i as well: :meth:`with_turned`.
    """

    def __init__(self, builder: Any, kind: Any) -> None:
        self._builder, self.is_complex = builder, isinstance(kind, types.Complex)
        self._parts = 2 if self.is_complex else 1
        self._width = LANES * self._parts
        self._type = ir.VectorType(REAL, self._width)
        self.zero = ir.Constant(self._type, self._width * [0.0])
        self.zero_number = self._parts * (ir.Constant(REAL, 0.0),)

    # numbers

    def load(self, address: Any) -> Parts:
        return tuple(self._builder.load(self._moved(address, k)) for k in range(self._parts))

    def store(self, number: Parts, address: Any) -> None:
        for k, part in enumerate(number):
            self._builder.store(part, self._moved(address, k))

    def unpacked(self, context: Any, kind: Any, value: Any) -> Parts:
        """The parts of a number of numba."""
        if not self.is_complex:
            return (value,)
        number = context.make_complex(self._builder, kind, value=value)
        return number.real, number.imag

    def _moved(self, address: Any, k: int) -> Any:
        return self._builder.gep(address, [ir.Constant(INDEX, k)]) if k else address

    def less_product(self, total: Parts, a: Parts, b: Parts) -> Parts:
        """total − a b."""
        first = self._less(total[0], a[0], b[0])
        if not self.is_complex:
            return (first,)
        second = self._less(total[1], a[0], b[1])
        return self._plus(first, a[1], b[1]), self._less(second, a[1], b[0])

    def _less(self, total: Any, a: Any, b: Any) -> Any:
        return self._builder.fsub(total, self.times(a, b), flags=_FAST)

    def _plus(self, total: Any, a: Any, b: Any) -> Any:
        return self._builder.fadd(total, self.times(a, b), flags=_FAST)

    def times(self, a: Any, b: Any) -> Any:
        return self._builder.fmul(a, b, flags=_FAST)

    def plus_real_product(self, total: Parts, a: Any, b: Parts) -> Parts:
        """total + a b for a real number a."""
        return tuple(self._plus(part, a, of_b) for part, of_b in zip(total, b, strict=True))

    def reciprocal(self, number: Parts) -> tuple[Parts, Any]:
        """1/z, and whether 0 < |z|² ≤ :data:`LARGEST`; zeros if not."""
        zero, one = ir.Constant(REAL, 0.0), ir.Constant(REAL, 1.0)
        size = self.times(number[0], number[0])
        if self.is_complex:
            size = self._plus(size, number[1], number[1])
            share = self._builder.fdiv(one, size)
            parts = number[0], self._builder.fneg(number[1])
            inverse = tuple(self.times(part, share) for part in parts)
        else:
            inverse = (self._builder.fdiv(one, number[0]),)
        fits = self._builder.and_(
            self._builder.fcmp_ordered(">", size, zero),
            self._at_most(size, ir.Constant(REAL, LARGEST)),
        )
        return tuple(self._builder.select(fits, part, zero) for part in inverse), fits

    def _at_most(self, value: Any, most: Any) -> Any:
        return self._builder.fcmp_ordered("<=", value, most)

    def are_tiny(self, numbers: list[Parts]) -> Any:
        """Whether all numbers are tiny."""
        magnitude = self._builder.module.declare_intrinsic("llvm.fabs", [REAL])
        size = ir.Constant(REAL, 0.0)
        for part in (part for number in numbers for part in number):
            size = self._builder.fadd(size, self._builder.call(magnitude, [part]), flags=_FAST)
        return self._builder.fcmp_ordered("<", size, ir.Constant(REAL, TINY))

    # vectors

    def vector(self, address: Any) -> Any:
        loaded = self._builder.load(self._builder.bitcast(address, self._type.as_pointer()))
        loaded.align = 8
        return loaded

    def store_vector(self, vector: Any, address: Any) -> None:
        place = self._builder.bitcast(address, self._type.as_pointer())
        self._builder.store(vector, place).align = 8

    def repeated(self, number: Parts) -> Parts:
        """A number in all lanes."""
        unset = ir.Constant(self._type, ir.Undefined)
        first = ir.Constant(INDEX, 0)
        filled = (self._builder.insert_element(unset, part, first) for part in number)
        return tuple(self._shuffled(vector, self._width * [0]) for vector in filled)

    def repeated_pairs(self, number: Parts) -> Any:
        """A number in all lanes, its parts side by side."""
        vector = ir.Constant(self._type, ir.Undefined)
        for lane in range(LANES):
            vector = self.insert(vector, number, lane)
        return vector

    def scaled_reals(self, reals: Any, scale: Any) -> Any:
        """The product of four real numbers with a number of :meth:`repeated_pairs`."""
        lanes = [place // self._parts for place in range(self._width)]
        mask = ir.Constant(ir.VectorType(INDEX, self._width), lanes)
        return self.times(self._builder.shuffle_vector(reals, reals, mask), scale)

    def transposed(self, rows: list[Any]) -> list[Any]:
        """The columns of a square of real numbers, four by four."""

        def mixed(first: Any, second: Any, *lanes: int) -> Any:
            mask = ir.Constant(ir.VectorType(INDEX, LANES), lanes)
            return self._builder.shuffle_vector(first, second, mask)

        even, odd = (
            [mixed(rows[k], rows[k + 1], lane, 4 + lane, 2 + lane, 6 + lane) for k in (0, 2)]
            for lane in (0, 1)
        )
        return [
            mixed(*pairs, lane, lane + 1, lane + 4, lane + 5)
            for lane in (0, 2)
            for pairs in (even, odd)
        ]

    def spread(self, vector: Any, lane: int) -> Parts:
        """The number of one lane in all lanes."""
        places = range(self._parts * lane, self._parts * (lane + 1))
        return tuple(self._shuffled(vector, self._width * [place]) for place in places)

    def extract(self, vector: Any, lane: int) -> Parts:
        """The number of one lane."""
        places = range(self._parts * lane, self._parts * (lane + 1))
        return tuple(
            self._builder.extract_element(vector, ir.Constant(INDEX, place)) for place in places
        )

    def insert(self, vector: Any, number: Parts, lane: int) -> Any:
        """The vector with a number in one lane."""
        for k, part in enumerate(number):
            place = ir.Constant(INDEX, self._parts * lane + k)
            vector = self._builder.insert_element(vector, part, place)
        return vector

    def joined(self, first: Any, second: Any, lane: int) -> Any:
        """The lanes of one vector before ``lane``, and of another from there on."""
        split = self._parts * min(max(lane, 0), LANES)
        lanes = [k if k < split else self._width + k for k in range(self._width)]
        mask = ir.Constant(ir.VectorType(INDEX, self._width), lanes)
        return self._builder.shuffle_vector(first, second, mask)

    def with_turned(self, vector: Any) -> Parts:
        """v; and i v = (−y, x, …) if it is complex."""
        if not self.is_complex:
            return (vector,)
        signs = ir.Constant(self._type, LANES * [-1.0, 1.0])
        turned = self._shuffled(vector, [place ^ 1 for place in range(self._width)])
        return vector, self._builder.fmul(turned, signs, flags=_FAST)

    def less_vector(self, total: Any, turned: Parts, factor: Parts) -> Any:
        """total − factor · v for v :meth:`with_turned` and a repeated factor."""
        for vector, part in zip(turned, factor, strict=True):
            total = self._less(total, vector, part)
        return total

    def sum_of_products(self, vectors: list[Any], factors: list[Parts]) -> Any:
        """Σ factors · vectors."""
        parts = []
        for k in range(self._parts):
            total = self.zero
            for vector, factor in zip(vectors, factors, strict=True):
                total = self._plus(total, vector, factor[k])
            parts.append(total)
        return parts[0] if len(parts) == 1 else self.plus(parts[0], self.with_turned(parts[1])[1])

    def plus_vector(self, total: Any, turned: Parts, factor: Parts) -> Any:
        """total + factor · v, as :meth:`less_vector`."""
        for vector, part in zip(turned, factor, strict=True):
            total = self._plus(total, vector, part)
        return total

    def product_of_lanes(self, first: Any, second: Any) -> Any:
        """a b in each lane."""
        if not self.is_complex:
            return self.times(first, second)
        real, imaginary = (
            self._shuffled(second, [place & ~1 | k for place in range(self._width)]) for k in (0, 1)
        )
        vector, turned = self.with_turned(first)
        return self._plus(self.times(vector, real), turned, imaginary)

    def plus(self, first: Any, second: Any) -> Any:
        return self._builder.fadd(first, second, flags=_FAST)

    def minus(self, first: Any, second: Any) -> Any:
        return self._builder.fsub(first, second, flags=_FAST)

    def plus_squares(self, total: Any, vector: Any) -> Any:
        return self._plus(total, vector, vector)

    def has_sum_of_at_most(self, vector: Any, most: float) -> Any:
        """Whether the sum over all lanes is a number, and not larger."""
        width = self._width
        while width > 1:
            width //= 2
            lanes = [k % width + width for k in range(self._width)]
            vector = self.plus(vector, self._shuffled(vector, lanes))
        total = self._builder.extract_element(vector, ir.Constant(INDEX, 0))
        return self._at_most(total, ir.Constant(REAL, most))

    def _shuffled(self, vector: Any, lanes: list[int]) -> Any:
        mask = ir.Constant(ir.VectorType(INDEX, self._width), lanes)
        return self._builder.shuffle_vector(vector, ir.Constant(self._type, ir.Undefined), mask)


class Columns:
    """Neighbouring columns of an array, from one row on, in a kernel under compilation."""

    def __init__(self, builder: Any, parts: int, begins: list[Any]) -> None:
        self._builder, self._parts, self._begins = builder, parts, begins

    def from_row(self, row: Any) -> Columns:
        """The same columns, with another first row."""
        doubles = self._builder.mul(row, ir.Constant(row.type, self._parts))
        begins = [self._builder.gep(begin, [doubles]) for begin in self._begins]
        return Columns(self._builder, self._parts, begins)

    def at(self, column: int, row: int = 0) -> Any:
        """The address of an element."""
        place = ir.Constant(INDEX, row * self._parts)
        return self._builder.gep(self._begins[column], [place]) if row else self._begins[column]

    def below(self, row: int) -> list[Any]:
        """The addresses of all columns in a row."""
        return [self.at(column, row) for column in range(len(self._begins))]


def columns_of(
    context: Any, builder: Any, array: Any, value: Any, first: Any, row: Any, *, count: int
) -> Columns:
    """So many columns of an array, from column ``first`` and from this row on."""
    struct = context.make_array(array)(context, builder, value)
    rows = cgutils.unpack_tuple(builder, struct.shape, 2)[1]
    parts = 2 if isinstance(array.dtype, types.Complex) else 1
    begin, begins = builder.bitcast(struct.data, REAL.as_pointer()), []
    for p in range(count):
        column = builder.add(first, ir.Constant(first.type, p))
        offset = builder.add(builder.mul(column, rows), row)
        begins.append(builder.gep(begin, [builder.mul(offset, ir.Constant(offset.type, parts))]))
    return Columns(builder, parts, begins)


def block_of(context: Any, builder: Any, array: Any, value: Any, i: Any, m: Any) -> Any:
    """The address of a block."""
    struct = context.make_array(array)(context, builder, value)
    width = cgutils.unpack_tuple(builder, struct.shape, 4)[1]
    block = builder.add(builder.mul(i, width), m)
    return builder.gep(struct.data, [builder.mul(block, ir.Constant(block.type, STEP * STEP))])


def fetch_line(builder: Any, place: Any, for_writing: int) -> None:
    """Ask for the line at an address."""
    kind = ir.FunctionType(ir.VoidType(), [BYTES, *3 * [INDEX]])
    prefetch = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0i8")
    soon, data = 3, 1
    builder.call(prefetch, [place, *(ir.Constant(INDEX, k) for k in (for_writing, soon, data))])
