"""P A = L U, A x = b: elimination of a block-banded matrix, column by column, in steps of six.

Every sphere is one step of six columns. A column holds its elements from 2w spheres above the
diagonal to w spheres below it, in row ``6 (i − k + 2w) + p`` for component p of sphere i in column
k. Interchanges of rows fill the upper w spheres. U has a unit diagonal, and the diagonal of L is
stored as its reciprocal. Loops take four rows at a time and may pass the last row by two: the
factors are zero there, and change nothing.

A pivot on the diagonal is taken if it is at least a tenth of the norm of its column; if not,
rows are interchanged for the largest element. Growth of elements is then bounded as with
partial pivoting of that threshold (Duff, Erisman & Reid, Direct Methods for Sparse Matrices, 2nd
ed., section 5.2), and a chain whose diagonal blocks dominate needs no interchange and no fill.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nrchain._compile import inlined, part
from nrchain.motion.lanes import LANES, solve_lower, solve_upper, subtract

THRESHOLD = 0.1
"""Least size of a pivot on the diagonal, relative to the norm of its column."""


class Band(NamedTuple):
    """The columns of a block-banded matrix of n spheres that reach w neighbours, then its factors.

    ``columns`` (6n, height) is real or complex, ``pivots`` (6n,) are the distances of the rows
    interchanged, and ``tops`` (n,) the first sphere with elements in the columns of each.
    """

    columns: np.ndarray
    pivots: np.ndarray
    tops: np.ndarray
    reach: int


def allocate_band(spheres: int, reach: int, dtype: type) -> Band:
    """Arrays for a matrix of so many spheres."""
    columns: np.ndarray = np.zeros((6 * spheres, 6 * (3 * reach + 1) + LANES), dtype)
    return Band(columns, np.zeros(6 * spheres, np.int64), np.zeros(spheres, np.int64), reach)


def allocate_vectors(count: int, spheres: int, reach: int, dtype: type) -> np.ndarray:
    """Zeros (count, rows): vectors of so many spheres, with the room that loops need at the ends.

    Sphere i starts in row 12w + 6i.
    """
    return np.zeros((count, 18 * reach + 6 * spheres + LANES), dtype)


@inlined
def _rounded_up(rows):
    """The rows of whole vectors."""
    return (rows + LANES - 1) // LANES * LANES


@inlined
def _advance(columns, step, half, target, begin, end, to):
    """Apply the multipliers of a step to columns of ``target``, whose row ``to`` is its first."""
    c, d = 6 * step, 12 * half
    rows = _rounded_up(6 * half)
    for column in range(begin, end):
        x = solve_lower(columns, c, d, target, column, to)
        for r in range(0, rows, LANES):
            subtract(columns, c, d + 6 + r, target, column, to + 6 + r, x)


@inlined
def _retreat(columns, step, half, above, target, begin, end, to):
    """Solve for the rows of a step and subtract their part from the rows above."""
    c, d = 6 * step, 12 * half
    rows = _rounded_up(6 * above)
    for column in range(begin, end):
        x = solve_upper(columns, c, d, target, column, to)
        for r in range(-rows, 0, LANES):
            subtract(columns, c, d + r, target, column, to + r, x)


@inlined
def _square(value):
    """|z|² of a real or complex number."""
    return value.real * value.real + value.imag * value.imag


@inlined
def _pivot_row(columns, column, diagonal, end):
    """The row of the pivot: the diagonal if it is large enough, else the largest of the column."""
    size = _square(columns[column, diagonal])
    squares = 0.0
    for row in range(diagonal, end):
        squares += _square(columns[column, np.uintp(row)])
    if size >= THRESHOLD**2 * squares:
        return diagonal
    found = diagonal
    for row in range(diagonal + 1, end):
        if _square(columns[column, row]) > size:
            size, found = _square(columns[column, row]), row
    return found


@inlined
def _exchange(pivots, step, target, begin, end, to):
    """Interchange the rows of a step in columns of ``target``."""
    for p in range(6):
        upper, lower = to + p, to + p + pivots[6 * step + p]
        if upper == lower:
            continue
        for column in range(begin, end):
            kept = target[column, upper]
            target[column, upper] = target[column, lower]
            target[column, lower] = kept


@inlined
def _eliminate_within(columns, step, half, pivots):
    """Factorise the columns of a step; how many spheres its interchanges reach, −1 if singular."""
    c, d = 6 * step, 12 * half
    end, farthest = d + 6 * (half + 1), 0
    for p in range(6):
        diagonal = d + p
        row = _pivot_row(columns, c + p, diagonal, end)
        shift = row - diagonal
        pivots[c + p] = shift
        if shift != 0:
            farthest = max(farthest, row // 6 - 2 * half)
            for q in range(6):
                kept = columns[c + q, diagonal]
                columns[c + q, diagonal] = columns[c + q, row]
                columns[c + q, row] = kept
        pivot = columns[c + p, diagonal]
        if not _square(pivot) > 0.0:
            return -1
        inverse = 1.0 / pivot
        columns[c + p, diagonal] = inverse
        start = diagonal + 1
        rows = _rounded_up(end - start)
        for q in range(p + 1, 6):
            s = columns[c + q, diagonal] * inverse
            columns[c + q, diagonal] = s
            for r in range(0, rows, LANES):
                subtract(columns, c + p, start + r, columns, c + q, start + r, (s,))
    return farthest


@inlined
def clear(band):
    """The identity."""
    columns, diagonal = band.columns, 12 * band.reach
    columns[:] = 0.0
    for column in range(columns.shape[0]):
        columns[column, diagonal + column % 6] = 1.0


@inlined
def add_block(band, row, column, factor, block):
    """Add factor · block, the coupling of sphere ``row`` to sphere ``column``."""
    first, to = 6 * column, 6 * (row - column + 2 * band.reach)
    for q in range(6):
        for p in range(6):
            band.columns[first + q, to + p] += factor * block[p, q]


@inlined
def fill(band, blocks, held, scale):
    """I − scale · J of the first spheres of a chain, without blocks that wrap."""
    columns, half, spheres = band.columns, band.reach, band.tops.shape[0]
    diagonal, end = 12 * half, 6 * (3 * half + 1)
    for k in range(spheres):
        first = 6 * k
        for q in range(6):
            for row in range(6 * half):
                columns[first + q, row] = 0.0
            for row in range(end, columns.shape[1]):
                columns[first + q, row] = 0.0
        for m in range(2 * half + 1):
            i, to = k + m - half, 6 * (m + half)
            if i < 0 or i >= spheres or held[i] or held[k]:
                for q in range(6):
                    for p in range(6):
                        columns[first + q, to + p] = 0.0
                continue
            for q in range(6):
                for p in range(6):
                    columns[first + q, np.uintp(to + p)] = -scale * blocks[i, 2 * half - m, p, q]
        for q in range(6):
            columns[first + q, diagonal + q] += 1.0


@part
def eliminate(band):
    """Replace the matrix by its factors; whether it is regular."""
    columns, pivots, tops, half = band.columns, band.pivots, band.tops, band.reach
    spheres, last = tops.shape[0], 0
    for k in range(spheres):
        tops[k] = max(k - half, 0)
    for k in range(spheres):
        farthest = _eliminate_within(columns, k, half, pivots)
        if farthest < 0:
            return False
        last = min(max(last, k + half + farthest), spheres - 1)
        for m in range(k + half + 1, last + 1):
            tops[m] = min(tops[m], k)
        for m in range(k + 1, last + 1):
            to = 6 * (k - m + 2 * half)
            _exchange(pivots, k, columns, 6 * m, 6 * m + 6, to)
            _advance(columns, k, half, columns, 6 * m, 6 * m + 6, to)
    return True


@part
def substitute(band, vectors):
    """Replace vectors, in the layout of :func:`allocate_vectors`, by the solutions for them."""
    columns, pivots, tops, half = band.columns, band.pivots, band.tops, band.reach
    spheres, count = tops.shape[0], vectors.shape[0]
    for k in range(spheres):
        to = 12 * half + 6 * k
        _exchange(pivots, k, vectors, 0, count, to)
        _advance(columns, k, half, vectors, 0, count, to)
    for k in range(spheres - 1, -1, -1):
        to = 12 * half + 6 * k
        _retreat(columns, k, half, k - tops[k], vectors, 0, count, to)
