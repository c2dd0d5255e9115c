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
"""Rows of a vector of the machine."""

STEP = 6
"""Columns of a step."""

TINY = 1e-250
"""What is smaller is taken as 0: solutions that decay along a chain would end in numbers below the
normal range, which are slow."""

LARGEST = 1e300
"""Bound on |z|² of a pivot, within which 1/z = z*/|z|²."""

THRESHOLD = 0.1
"""Least size of a pivot on the diagonal, relative to the norm of its column."""

_LINE = 64
"""Bytes that a cache fetches at once."""

_FAST = sorted(ARITHMETIC)
_REAL, _INDEX = ir.DoubleType(), ir.IntType(32)
_BYTES = ir.IntType(8).as_pointer()

Parts = tuple[Any, ...]
"""A number in registers: its real part, and its imaginary part if it is complex. Or vectors that
repeat each of them."""


class _Numbers:
    """Arithmetic with numbers and vectors of four numbers, real or complex.

    Complex numbers stand in memory, and in vectors, as pairs. Products with a vector need the
    vector times i as well: :meth:`with_turned`.
    """

    def __init__(self, builder: Any, kind: Any) -> None:
        self._builder, self.is_complex = builder, isinstance(kind, types.Complex)
        self._parts = 2 if self.is_complex else 1
        self._width = LANES * self._parts
        self._type = ir.VectorType(_REAL, self._width)
        self.zero = ir.Constant(self._type, self._width * [0.0])
        self.zero_number = self._parts * (ir.Constant(_REAL, 0.0),)

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
        return self._builder.gep(address, [ir.Constant(_INDEX, k)]) if k else address

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
        zero, one = ir.Constant(_REAL, 0.0), ir.Constant(_REAL, 1.0)
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
            self._at_most(size, ir.Constant(_REAL, LARGEST)),
        )
        return tuple(self._builder.select(fits, part, zero) for part in inverse), fits

    def _at_most(self, value: Any, most: Any) -> Any:
        return self._builder.fcmp_ordered("<=", value, most)

    def are_tiny(self, numbers: list[Parts]) -> Any:
        """Whether all numbers are tiny."""
        magnitude = self._builder.module.declare_intrinsic("llvm.fabs", [_REAL])
        size = ir.Constant(_REAL, 0.0)
        for part in (part for number in numbers for part in number):
            size = self._builder.fadd(size, self._builder.call(magnitude, [part]), flags=_FAST)
        return self._builder.fcmp_ordered("<", size, ir.Constant(_REAL, TINY))

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
        first = ir.Constant(_INDEX, 0)
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
        mask = ir.Constant(ir.VectorType(_INDEX, self._width), lanes)
        return self.times(self._builder.shuffle_vector(reals, reals, mask), scale)

    def transposed(self, rows: list[Any]) -> list[Any]:
        """The columns of a square of real numbers, four by four."""

        def mixed(first: Any, second: Any, *lanes: int) -> Any:
            mask = ir.Constant(ir.VectorType(_INDEX, LANES), lanes)
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
            self._builder.extract_element(vector, ir.Constant(_INDEX, place)) for place in places
        )

    def insert(self, vector: Any, number: Parts, lane: int) -> Any:
        """The vector with a number in one lane."""
        for k, part in enumerate(number):
            place = ir.Constant(_INDEX, self._parts * lane + k)
            vector = self._builder.insert_element(vector, part, place)
        return vector

    def joined(self, first: Any, second: Any, lane: int) -> Any:
        """The lanes of one vector before ``lane``, and of another from there on."""
        split = self._parts * min(max(lane, 0), LANES)
        lanes = [k if k < split else self._width + k for k in range(self._width)]
        mask = ir.Constant(ir.VectorType(_INDEX, self._width), lanes)
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
        total = self._builder.extract_element(vector, ir.Constant(_INDEX, 0))
        return self._at_most(total, ir.Constant(_REAL, most))

    def _shuffled(self, vector: Any, lanes: list[int]) -> Any:
        mask = ir.Constant(ir.VectorType(_INDEX, self._width), lanes)
        return self._builder.shuffle_vector(vector, ir.Constant(self._type, ir.Undefined), mask)


class _Columns:
    """Neighbouring columns of an array, from one row on, in a kernel under compilation."""

    def __init__(self, builder: Any, parts: int, begins: list[Any]) -> None:
        self._builder, self._parts, self._begins = builder, parts, begins

    def from_row(self, row: Any) -> _Columns:
        """The same columns, with another first row."""
        doubles = self._builder.mul(row, ir.Constant(row.type, self._parts))
        begins = [self._builder.gep(begin, [doubles]) for begin in self._begins]
        return _Columns(self._builder, self._parts, begins)

    def at(self, column: int, row: int = 0) -> Any:
        """The address of an element."""
        place = ir.Constant(_INDEX, row * self._parts)
        return self._builder.gep(self._begins[column], [place]) if row else self._begins[column]

    def below(self, row: int) -> list[Any]:
        """The addresses of all columns in a row."""
        return [self.at(column, row) for column in range(len(self._begins))]


def _columns(
    context: Any, builder: Any, array: Any, value: Any, first: Any, row: Any, *, count: int
) -> _Columns:
    """So many columns of an array, from column ``first`` and from this row on."""
    struct = context.make_array(array)(context, builder, value)
    rows = cgutils.unpack_tuple(builder, struct.shape, 2)[1]
    parts = 2 if isinstance(array.dtype, types.Complex) else 1
    begin, begins = builder.bitcast(struct.data, _REAL.as_pointer()), []
    for p in range(count):
        column = builder.add(first, ir.Constant(first.type, p))
        offset = builder.add(builder.mul(column, rows), row)
        begins.append(builder.gep(begin, [builder.mul(offset, ir.Constant(offset.type, parts))]))
    return _Columns(builder, parts, begins)


def _panel(typing: Any, columns: Any, first: Any, diagonal: Any, kept: Any, chunks: Any) -> Any:
    """The function of ``eliminate_panel``, for ``intrinsic``."""
    signature = types.boolean(columns, first, diagonal, kept, chunks)

    def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        n, zero = _Numbers(builder, columns.dtype), arguments[1].type(0)
        panel = _columns(
            context, builder, columns, arguments[0], arguments[1], arguments[2], count=STEP
        )
        copy = _columns(context, builder, kept, arguments[3], zero, zero, count=2 * STEP)
        squares, in_range = _eliminate_top(n, builder, panel, copy)
        total = cgutils.alloca_once_value(builder, squares)
        begin = ir.Constant(arguments[4].type, 2)
        step = ir.Constant(arguments[4].type, 1)
        with cgutils.for_range_slice(builder, begin, arguments[4], step) as (chunk, _):
            row = builder.mul(chunk, ir.Constant(chunk.type, LANES))
            squares = builder.load(total)
            squares = _eliminate_below(n, panel, panel.from_row(row), copy.from_row(row), squares)
            builder.store(squares, total)
        most = 1.0 / THRESHOLD**2 - 1.0
        return builder.and_(in_range, n.has_sum_of_at_most(builder.load(total), most))

    return signature, generate


def _eliminate_top(n: _Numbers, builder: Any, panel: _Columns, copy: _Columns) -> tuple[Any, Any]:
    """The first two vectors of rows; squares of multipliers, and whether pivots are in range."""
    v = [[n.vector(panel.at(q, LANES * h)) for h in (0, 1)] for q in range(STEP)]
    for q in range(STEP):
        for h in (0, 1):
            n.store_vector(v[q][h], copy.at(q, LANES * h))
    squares, in_range, inverses = n.zero, ir.Constant(ir.IntType(1), 1), []
    for p in range(STEP):
        of_row = [n.spread(v[q][p // LANES], p % LANES) for q in range(STEP)]
        inverse, fits = n.reciprocal(n.extract(v[p][p // LANES], p % LANES))
        in_range = builder.and_(in_range, fits)
        inverses.append(inverse)
        for h in (0, 1):
            n.store_vector(v[p][h], copy.at(STEP + p, LANES * h))
            lane = p + 1 - LANES * h
            if lane >= LANES:
                continue
            below = n.with_turned(n.joined(n.zero, v[p][h], lane))
            minus = n.less_vector(n.zero, below, n.repeated(inverse))
            squares = n.plus_squares(squares, minus)
            turned = n.with_turned(minus)
            for q in range(STEP):
                if q != p:
                    v[q][h] = n.plus_vector(v[q][h], turned, of_row[q])
            v[p][h] = n.joined(v[p][h], minus, lane)
    one = tuple(ir.Constant(_REAL, value) for value in ((1.0, 0.0) if n.is_complex else (1.0,)))
    for h in (0, 1):
        scales = n.zero
        for lane in range(LANES):
            p = LANES * h + lane
            scales = n.insert(scales, inverses[p] if p < STEP else one, lane)
        for q in range(STEP):
            scaled = n.product_of_lanes(v[q][h], scales)
            if q // LANES == h:
                scaled = n.insert(scaled, inverses[q], q % LANES)
            n.store_vector(scaled, panel.at(q, LANES * h))
    return squares, in_range


def _eliminate_below(
    n: _Numbers, panel: _Columns, rows: _Columns, copy: _Columns, squares: Any
) -> Any:
    """A vector of rows below, with the factors of the first six; adds squares of multipliers."""
    v = [n.vector(place) for place in rows.below(0)]
    for q in range(STEP):
        n.store_vector(v[q], copy.at(q))
    for p in range(STEP):
        n.store_vector(v[p], copy.at(STEP + p))
        turned = n.with_turned(v[p])
        for q in range(STEP):
            factor = n.repeated(n.load(panel.at(q, p)))
            v[q] = n.less_vector(n.zero if p == q else v[q], turned, factor)
        squares = n.plus_squares(squares, v[p])
    for q in range(STEP):
        n.store_vector(v[q], rows.at(q))
    return squares


def _advance(count: int) -> Any:
    """The function of ``advance`` for so many columns, for ``intrinsic``."""

    def define(
        typing: Any,
        columns: Any,
        first: Any,
        diagonal: Any,
        target: Any,
        column: Any,
        row: Any,
        chunks: Any,
    ) -> Any:
        signature = types.void(columns, first, diagonal, target, column, row, chunks)

        def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
            n = _Numbers(builder, columns.dtype)
            source = _columns(context, builder, columns, *arguments[:3], count=STEP)
            to = _columns(context, builder, target, *arguments[3:6], count=count)
            x = [[n.load(to.at(m, p)) for p in range(STEP)] for m in range(count)]
            repeated = [[n.repeated(number) for number in of_column] for of_column in x]

            def multiply() -> None:
                _multiply_top(n, source, to, repeated)
                begin = ir.Constant(arguments[6].type, 2)
                step = ir.Constant(arguments[6].type, 1)
                with cgutils.for_range_slice(builder, begin, arguments[6], step) as (chunk, _):
                    r = builder.mul(chunk, ir.Constant(chunk.type, LANES))
                    vectors = [n.vector(place) for place in source.from_row(r).below(0)]
                    for place, factors in zip(to.from_row(r).below(0), repeated, strict=True):
                        change = n.sum_of_products(vectors, factors)
                        n.store_vector(n.plus(n.vector(place), change), place)

            if count > 1:  # columns of a matrix do not decay along the chain
                multiply()
                return context.get_dummy_value()
            with builder.if_else(n.are_tiny(x[0])) as (vanishes, counts):
                with vanishes:
                    _store_all(n, [n.zero_number] * STEP, to)
                with counts:
                    multiply()
            return context.get_dummy_value()

        return signature, generate

    return define


def _multiply_top(n: _Numbers, source: _Columns, to: _Columns, x: list[list[Parts]]) -> None:
    """The first two vectors of rows: L⁻¹ x, below the diagonal on which U begins, and two more."""
    top = [n.joined(n.zero, n.vector(source.at(p)), p) for p in range(LANES)]
    below = [n.joined(n.zero, n.vector(source.at(p, LANES)), p - LANES) for p in range(STEP)]
    for m, factors in enumerate(x):
        old = n.joined(n.zero, n.vector(to.at(m, LANES)), STEP - LANES)
        n.store_vector(n.sum_of_products(top, factors[:LANES]), to.at(m))
        n.store_vector(n.plus(old, n.sum_of_products(below, factors)), to.at(m, LANES))


def _retreat(
    typing: Any,
    columns: Any,
    first: Any,
    diagonal: Any,
    target: Any,
    column: Any,
    row: Any,
    above: Any,
) -> Any:
    """The function of ``retreat``, for ``intrinsic``."""
    signature = types.void(columns, first, diagonal, target, column, row, above)

    def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        n = _Numbers(builder, columns.dtype)
        source = _columns(context, builder, columns, *arguments[:3], count=STEP)
        to = _columns(context, builder, target, *arguments[3:6], count=1)
        x = [n.load(to.at(0, p)) for p in range(STEP)]
        for p in reversed(range(STEP)):
            for q in range(p):
                x[q] = n.less_product(x[q], n.load(source.at(p, q)), x[p])
        with builder.if_else(n.are_tiny(x)) as (vanishes, counts):
            with vanishes:
                _store_all(n, [n.zero_number] * STEP, to)
            with counts:
                repeated = [n.repeated(number) for number in x]
                begin, zero = builder.neg(arguments[6]), arguments[6].type(0)
                step = ir.Constant(zero.type, LANES)
                with cgutils.for_range_slice(builder, begin, zero, step) as (r, _):
                    vectors = list(map(n.vector, source.from_row(r).below(0)))
                    place = to.from_row(r).at(0)
                    change = n.sum_of_products(vectors, repeated)
                    n.store_vector(n.minus(n.vector(place), change), place)
                # the last vector may reach two rows too far
                _store_all(n, x, to)
        return context.get_dummy_value()

    return signature, generate


def _subtraction(
    typing: Any,
    source: Any,
    first: Any,
    row: Any,
    target: Any,
    column: Any,
    to: Any,
    vectors: Any,
    vector: Any,
    at: Any,
    rows: Any,
) -> Any:
    """The function of ``subtract``, for ``intrinsic``."""
    signature = types.void(source, first, row, target, column, to, vectors, vector, at, rows)

    def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        n, zero = _Numbers(builder, source.dtype), arguments[9].type(0)
        columns = _columns(context, builder, source, *arguments[:3], count=STEP)
        result = _columns(context, builder, target, *arguments[3:6], count=1)
        factors = _columns(context, builder, vectors, *arguments[6:9], count=1)
        x = [n.repeated(n.load(factors.at(0, p))) for p in range(STEP)]
        with cgutils.for_range_slice(
            builder, zero, arguments[9], ir.Constant(zero.type, LANES)
        ) as (r, _):
            place = result.from_row(r).at(0)
            change = n.sum_of_products(list(map(n.vector, columns.from_row(r).below(0))), x)
            n.store_vector(n.minus(n.vector(place), change), place)
        return context.get_dummy_value()

    return signature, generate


def _setting(
    typing: Any, columns: Any, first: Any, row: Any, blocks: Any, i: Any, m: Any, factor: Any
) -> Any:
    """The function of ``set_block``, for ``intrinsic``."""
    signature = types.void(columns, first, row, blocks, i, m, factor)

    def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        n, reals = _Numbers(builder, columns.dtype), _Numbers(builder, types.float64)
        block = _block_at(context, builder, blocks, *arguments[3:6])
        to = _columns(context, builder, columns, *arguments[:3], count=STEP)
        scale = n.repeated_pairs(n.unpacked(context, factor, arguments[6]))
        # the next column takes the same block of the next sphere
        following = builder.add(arguments[4], arguments[4].type(1))
        following = _block_at(context, builder, blocks, arguments[3], following, arguments[5])
        following = builder.bitcast(following, _BYTES)
        for offset in range(0, 8 * STEP * STEP, _LINE):
            _fetch(builder, builder.gep(following, [ir.Constant(_INDEX, offset)]), for_writing=0)
        last = STEP - LANES
        for p in (0, last):
            for q in (0, last):
                rows = [
                    reals.vector(builder.gep(block, [ir.Constant(_INDEX, STEP * (p + k) + q)]))
                    for k in range(LANES)
                ]
                for k, column in enumerate(reals.transposed(rows)):
                    if q == 0 or k >= LANES - last:
                        n.store_vector(n.scaled_reals(column, scale), to.at(q + k, p))
        return context.get_dummy_value()

    return signature, generate


def _announcement(typing: Any, columns: Any, first: Any) -> Any:
    """The function of ``announce``, for ``intrinsic``."""
    signature = types.void(columns, first)

    def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        zero, line = arguments[1].type(0), ir.Constant(arguments[1].type, _LINE)
        begin = _columns(
            context, builder, columns, arguments[0], arguments[1], zero, count=STEP + 1
        )
        first, last = (builder.ptrtoint(begin.at(q), zero.type) for q in (0, STEP))
        with cgutils.for_range_slice(builder, first, last, line) as (address, _):
            _fetch(builder, builder.inttoptr(address, _BYTES), for_writing=1)
        return context.get_dummy_value()

    return signature, generate


def _fetch(builder: Any, place: Any, for_writing: int) -> None:
    """Ask for the line at an address."""
    kind = ir.FunctionType(ir.VoidType(), [_BYTES, *3 * [_INDEX]])
    prefetch = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0i8")
    soon, data = 3, 1
    builder.call(prefetch, [place, *(ir.Constant(_INDEX, k) for k in (for_writing, soon, data))])


def _block_at(context: Any, builder: Any, array: Any, value: Any, i: Any, m: Any) -> Any:
    """The address of a block."""
    struct = context.make_array(array)(context, builder, value)
    width = cgutils.unpack_tuple(builder, struct.shape, 4)[1]
    block = builder.add(builder.mul(i, width), m)
    return builder.gep(struct.data, [builder.mul(block, ir.Constant(block.type, STEP * STEP))])


def _block(
    typing: Any, columns: Any, first: Any, row: Any, blocks: Any, i: Any, m: Any, factor: Any
) -> Any:
    """The function of ``add_block``, for ``intrinsic``."""
    signature = types.void(columns, first, row, blocks, i, m, factor)

    def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        n = _Numbers(builder, columns.dtype)
        block = _block_at(context, builder, blocks, *arguments[3:6])
        scale = n.unpacked(context, factor, arguments[6])
        with cgutils.for_range(builder, arguments[1].type(STEP)) as loop:
            place = _columns(
                context,
                builder,
                columns,
                arguments[0],
                builder.add(arguments[1], loop.index),
                arguments[2],
                count=1,
            )
            for p in range(STEP):
                element = builder.add(loop.index, ir.Constant(loop.index.type, STEP * p))
                value = builder.load(builder.gep(block, [element]))
                to = place.at(0, p)
                n.store(n.plus_real_product(n.load(to), value, scale), to)
        return context.get_dummy_value()

    return signature, generate


def _store_all(n: _Numbers, numbers: list[Parts], to: _Columns) -> None:
    for p, number in enumerate(numbers):
        n.store(number, to.at(0, p))


eliminate_panel: Any = intrinsic(_panel)
"""Gaussian elimination in six columns without interchanges; whether its pivots are large enough.

``eliminate_panel(columns, first, diagonal, kept, chunks)``: the rows from ``diagonal`` on, four
times ``chunks``, are copied to ``kept``, followed by each column at the time of its pivot. They are
replaced by the transformation of the step

    [ L⁻¹ ; −M L⁻¹ ],   with [ D ; B ] = [ L ; M ] U,

D being the first six rows. U has a unit diagonal, and is kept above the diagonal of L⁻¹.
"""

advance: Any = intrinsic(_advance(1))
"""Apply the transformation of a step, [ L⁻¹ 0 ; −M L⁻¹ 1 ], to rows of a column.

``advance(columns, first, diagonal, target, column, row, chunks)`` with the columns of
``eliminate_panel``; ``row`` is the first of ``target[column]``.
"""

advance_pair: Any = intrinsic(_advance(2))
"""As ``advance`` for two columns at once: factors are loaded once for both."""

retreat: Any = intrinsic(_retreat)
"""x = U⁻¹ target[column, row:row + 6] in place, with U of :func:`eliminate_panel`.

The product of x with rows above is subtracted from the rows above.

``retreat(columns, first, diagonal, target, column, row, above)``: so many rows ``above``.
"""

subtract: Any = intrinsic(_subtraction)
"""target[column, to + r] −= Σ_p source[first + p, row + r] vectors[vector, at + p], r < ``rows``.

``subtract(source, first, row, target, column, to, vectors, vector, at, rows)``.
"""

set_block: Any = intrinsic(_setting)
"""columns[first + q, row + p] = factor blocks[i, m, p, q].

``set_block(columns, first, row, blocks, i, m, factor)`` with real ``blocks``.
"""

announce: Any = intrinsic(_announcement)
"""Fetch six columns into the cache, to be written soon: ``announce(columns, first)``."""

add_block: Any = intrinsic(_block)
"""As ``set_block``, added to the elements."""
