"""The steps of elimination in six columns, as functions that kernels call.

Arrays are two-dimensional in the order of C, and indices are not checked.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from nrchain.motion.lanes import (
    BYTES,
    INDEX,
    LANES,
    LINE,
    REAL,
    STEP,
    Columns,
    Numbers,
    Parts,
    block_of,
    columns_of,
    fetch_line,
)

THRESHOLD = 0.1
"""Least size of a pivot on the diagonal, relative to the norm of its column."""


def _panel(typing: Any, columns: Any, first: Any, diagonal: Any, kept: Any, chunks: Any) -> Any:
    """The function of ``eliminate_panel``, for ``intrinsic``."""
    signature = types.boolean(columns, first, diagonal, kept, chunks)

    def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        n, zero = Numbers(builder, columns.dtype), arguments[1].type(0)
        panel = columns_of(
            context, builder, columns, arguments[0], arguments[1], arguments[2], count=STEP
        )
        copy = columns_of(context, builder, kept, arguments[3], zero, zero, count=2 * STEP)
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


def _eliminate_top(n: Numbers, builder: Any, panel: Columns, copy: Columns) -> tuple[Any, Any]:
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
    one = tuple(ir.Constant(REAL, value) for value in ((1.0, 0.0) if n.is_complex else (1.0,)))
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


def _eliminate_below(n: Numbers, panel: Columns, rows: Columns, copy: Columns, squares: Any) -> Any:
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
            n = Numbers(builder, columns.dtype)
            source = columns_of(context, builder, columns, *arguments[:3], count=STEP)
            to = columns_of(context, builder, target, *arguments[3:6], count=count)
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


def _multiply_top(n: Numbers, source: Columns, to: Columns, x: list[list[Parts]]) -> None:
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
        n = Numbers(builder, columns.dtype)
        source = columns_of(context, builder, columns, *arguments[:3], count=STEP)
        to = columns_of(context, builder, target, *arguments[3:6], count=1)
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
        n, zero = Numbers(builder, source.dtype), arguments[9].type(0)
        columns = columns_of(context, builder, source, *arguments[:3], count=STEP)
        result = columns_of(context, builder, target, *arguments[3:6], count=1)
        factors = columns_of(context, builder, vectors, *arguments[6:9], count=1)
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
        n, reals = Numbers(builder, columns.dtype), Numbers(builder, types.float64)
        block = block_of(context, builder, blocks, *arguments[3:6])
        to = columns_of(context, builder, columns, *arguments[:3], count=STEP)
        scale = n.repeated_pairs(n.unpacked(context, factor, arguments[6]))
        # the next column takes the same block of the next sphere
        following = builder.add(arguments[4], arguments[4].type(1))
        following = block_of(context, builder, blocks, arguments[3], following, arguments[5])
        following = builder.bitcast(following, BYTES)
        for offset in range(0, 8 * STEP * STEP, LINE):
            fetch_line(builder, builder.gep(following, [ir.Constant(INDEX, offset)]), for_writing=0)
        last = STEP - LANES
        for p in (0, last):
            for q in (0, last):
                rows = [
                    reals.vector(builder.gep(block, [ir.Constant(INDEX, STEP * (p + k) + q)]))
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
        zero, line = arguments[1].type(0), ir.Constant(arguments[1].type, LINE)
        begin = columns_of(
            context, builder, columns, arguments[0], arguments[1], zero, count=STEP + 1
        )
        first, last = (builder.ptrtoint(begin.at(q), zero.type) for q in (0, STEP))
        with cgutils.for_range_slice(builder, first, last, line) as (address, _):
            fetch_line(builder, builder.inttoptr(address, BYTES), for_writing=1)
        return context.get_dummy_value()

    return signature, generate


def _block(
    typing: Any, columns: Any, first: Any, row: Any, blocks: Any, i: Any, m: Any, factor: Any
) -> Any:
    """The function of ``add_block``, for ``intrinsic``."""
    signature = types.void(columns, first, row, blocks, i, m, factor)

    def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        n = Numbers(builder, columns.dtype)
        block = block_of(context, builder, blocks, *arguments[3:6])
        scale = n.unpacked(context, factor, arguments[6])
        with cgutils.for_range(builder, arguments[1].type(STEP)) as loop:
            place = columns_of(
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


def _store_all(n: Numbers, numbers: list[Parts], to: Columns) -> None:
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
