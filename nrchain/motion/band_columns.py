"""P A = L U, A x = b: elimination of a block-banded matrix, column by column, in steps of six.

Every sphere is one step of six columns. A column of sphere k holds its elements from some spheres
above the diagonal to w spheres below it, in row ``6 (i − k + above) + p`` for component p of sphere
i. There are w spheres above, or 2w if interchanges of rows fill more. U has a unit diagonal. In
each step L⁻¹ takes the place of L (:func:`~nrchain.motion.panel_steps.eliminate_panel`): steps are
products, without a sequence of divisions. Loops take four rows at a time and may pass the last row
by two: the factors are zero there, and change nothing.

A pivot on the diagonal is taken if it is at least a tenth of the norm of its column; if not,
rows are interchanged for the largest element. Growth of elements is then bounded as with
partial pivoting of that threshold (Duff, Erisman & Reid, Direct Methods for Sparse Matrices, 2nd
ed., section 5.2), and a chain whose diagonal blocks dominate needs no interchange and no fill.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nrchain._compile import inlined, part
from nrchain.motion.lanes import LANES, LARGEST
from nrchain.motion.panel_steps import (
    THRESHOLD,
    advance,
    advance_pair,
    announce,
    eliminate_panel,
    retreat,
    set_block,
)

FINE, SINGULAR, NARROW = range(3)
"""Statuses of elimination; NARROW if interchanges need more rows above the diagonal."""


class Band(NamedTuple):
    """The columns of a block-banded matrix of n spheres that reach w neighbours, then its factors.

    ``columns`` (6n, height) is real or complex, with ``above`` spheres above the diagonal.
    ``pivots`` (6n,) are the distances of the rows interchanged, and ``moved`` (n,) how many rows of
    a step to look at for them. ``panels`` (12, rows) is room for the columns of a step.
    """

    columns: np.ndarray
    pivots: np.ndarray
    moved: np.ndarray
    panels: np.ndarray
    reach: int
    above: int


@inlined
def height_of(reach, above):
    """Rows of a column: those from the diagonal on fill whole vectors."""
    return 6 * above + (6 * (reach + 1) + LANES - 1) // LANES * LANES


def allocate_band(spheres: int, reach: int, dtype: type) -> tuple[np.ndarray, ...]:
    """The arrays of a band of so many spheres, with room for 2w spheres above the diagonal.

    There is one column more, for loops that pass the last row.
    """
    return (
        np.zeros((6 * spheres + 1, height_of.py_func(reach, 2 * reach)), dtype),
        np.zeros(6 * spheres, np.int64),
        np.zeros(spheres, np.int64),
        np.zeros((12, height_of.py_func(reach, 0)), dtype),
    )


def allocate_vectors(count: int, spheres: int, reach: int, dtype: type) -> np.ndarray:
    """Zeros (count, rows): vectors of so many spheres, with the room that loops need at the ends.

    Sphere i starts in row 12w + 6i.
    """
    return np.zeros((count, 18 * reach + 6 * spheres + LANES), dtype)


@inlined
def _square(value):
    """|z|² of a real or complex number."""
    return value.real * value.real + value.imag * value.imag


@part
def _exchange(pivots, step, target, column, to):
    """Interchange the rows of a step in a column of ``target``."""
    for p in range(6):
        upper, lower = to + p, to + p + pivots[6 * step + p]
        kept = target[column, upper]
        target[column, upper] = target[column, lower]
        target[column, lower] = kept


@inlined
def _pivot_row(panels, column, p):
    """The row of pivot p: that if its element is large enough, else that of the largest below.

    −1 if the column vanishes, or has elements that are not finite.
    """
    first = size = _square(panels[column, p])
    squares, found = 0.0, p
    for row in range(p, panels.shape[1]):
        square = _square(panels[column, row])
        squares += square
        if square > size:
            size, found = square, row
    if not 0.0 < squares < LARGEST:
        return -1
    return p if first >= THRESHOLD**2 * squares else found


@part
def _interchange(band, step):
    """Interchange the rows of the first pivot of a step that is too small.

    Returns 1 + how many spheres below the other row is; 0 if all pivots are large enough, −1 if the
    columns are singular. Above, ``panels`` has the columns of the step, and below each column as it
    was when its pivot was taken.
    """
    columns, panels, pivots, moved = band.columns, band.panels, band.pivots, band.moved
    # a number that the compiler does not know: it would write out the loops
    six = panels.shape[0] // 2
    first, diagonal = six * step, six * band.above
    for p in range(moved[step], six):
        row = _pivot_row(panels, six + p, p)
        if row < 0:
            return -1
        pivots[first + p] = row - p
        if row == p:
            continue
        for r in range(panels.shape[1]):
            for q in range(six):
                columns[first + q, diagonal + r] = panels[q, r]
        for q in range(six):
            columns[first + q, diagonal + p] = panels[q, row]
            columns[first + q, diagonal + row] = panels[q, p]
        moved[step] = p + 1
        for later in range(p + 1, six):
            pivots[first + later] = 0
        return 1 + row // six
    return 0


@inlined
def clear(band):
    """The identity."""
    columns, diagonal = band.columns, 6 * band.above
    columns[:] = 0.0
    for column in range(columns.shape[0]):
        columns[column, diagonal + column % 6] = 1.0


@inlined
def _fill(band, k, blocks, held, scale):
    """The columns of sphere k of I − scale · J, without blocks that leave the chain."""
    columns, half, spheres, first = band.columns, band.reach, band.moved.shape[0], 6 * k
    begin, end = 6 * (band.above - half), 6 * (band.above + half + 1)
    for column in range(first, first + 6):
        columns[column, :begin] = 0.0
        columns[column, end:] = 0.0
    for m in range(2 * half + 1):
        i, to = k + half - m, end - 6 * (m + 1)
        if i < 0 or i >= spheres or held[i] or held[k]:
            columns[first : first + 6, to : to + 6] = 0.0
        else:
            set_block(columns, first, to, blocks, i, m, -scale)
    for q in range(6):
        columns[first + q, 6 * band.above + q] += 1.0


@part
def eliminate(band, blocks, held, scale):
    """Factorise I − scale · J of the first spheres of a chain; a status.

    Its columns are set where the elimination first reaches them; if there are no ``blocks``, they
    are set already.
    """
    columns, half, above = band.columns, band.reach, band.above
    spheres, chunks = band.moved.shape[0], band.panels.shape[1] // LANES
    last, unset = 0, min(spheres, blocks.shape[0])
    for k in range(-above, spheres):
        if k + above < unset:
            _fill(band, k + above, blocks, held, scale)
            announce(columns, 6 * (k + above + 1))
        if k < 0:
            continue
        band.moved[k], farthest = 0, 0
        while not eliminate_panel(columns, 6 * k, 6 * above, band.panels, chunks):
            found = _interchange(band, k)
            if found == 0:
                break
            if found < 0:
                return SINGULAR
            farthest = max(farthest, found - 1)
            if farthest > above - half:
                return NARROW
        last = min(max(last, k + half + farthest), spheres - 1)
        for column in range(6 * (k + 1), 6 * (last + 1), 2):
            to = 6 * (k - column // 6 + above)
            if band.moved[k]:
                _exchange(band.pivots, k, columns, column, to)
                _exchange(band.pivots, k, columns, column + 1, to)
            advance_pair(columns, 6 * k, 6 * above, columns, column, to, chunks)
    return FINE


@part
def substitute(band, vectors):
    """Replace vectors, in the layout of :func:`allocate_vectors`, by the solutions for them."""
    columns, half, above = band.columns, band.reach, band.above
    spheres, count, chunks = band.moved.shape[0], vectors.shape[0], band.panels.shape[1] // LANES
    for k in range(spheres):
        to = 12 * half + 6 * k
        for column in range(count):
            if band.moved[k]:
                _exchange(band.pivots, k, vectors, column, to)
            advance(columns, 6 * k, 6 * above, vectors, column, to, chunks)
    for k in range(spheres - 1, -1, -1):
        to = 12 * half + 6 * k
        for column in range(count):
            retreat(columns, 6 * k, 6 * above, vectors, column, to, 6 * above)
