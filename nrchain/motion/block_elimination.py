"""(I − cJ) x = b for a chain whose spheres couple to w neighbours, with c real or complex.

``blocks`` (N, 2w + 1, 6, 6) is J: ``blocks[i, w + m]`` couples sphere i to sphere i + m. Blocks
that leave an open chain are not read; those of a periodic chain wrap, and add up where they meet.
Rows and columns of clamped spheres are those of the identity.

An open chain is eliminated in the order of its spheres. A periodic chain is cut open by its last w
spheres: with A the matrix of the others, F and G the couplings, B the block of the last,

    (B − G A⁻¹ F) x₂ = b₂ − G A⁻¹ b₁,   x₁ = A⁻¹ b₁ − (A⁻¹ F) x₂.

Pivots are chosen among all rows within reach (:mod:`nrchain.motion.band_columns`), so that open
chains are stable with any diagonal blocks. The errors of a periodic chain grow with A⁻¹ F, the
response of the others to the last spheres. It is :data:`UNSTABLE` if that exceeds
:data:`LARGEST_RESPONSE`, which needs A nearly singular where the whole matrix is not: a slightly
different c helps.

Factors and solutions are two functions by address, for real and for complex c. Their context is the
table of the arrays of an :class:`Elimination`; Python and the steps of integrators call the same
machine code.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from nrchain._addresses import (
    ROW,
    blocks_in,
    carray,
    compile_term,
    complex_at,
    floats_at,
    integers_at,
    matrix_in,
    table_of,
    vector_in,
)
from nrchain._compile import inlined, part
from nrchain.motion.band_columns import (
    FINE,
    NARROW,
    Band,
    allocate_band,
    allocate_vectors,
    clear,
    eliminate,
    height_of,
    substitute,
)
from nrchain.motion.lanes import LANES
from nrchain.motion.panel_steps import add_block, subtract

UNSTABLE = 3

LARGEST_RESPONSE = 1e8
"""Bound on the norm of a column of A⁻¹ F: the solution keeps half its digits."""


class Factors(NamedTuple):
    """Factors of I − cJ.

    ``band`` is A, ``cut`` the matrix of the last spheres of a periodic chain, and ``responses``
    A⁻¹ F by columns. ``ties`` (6w (2w + 1), 8) is G: six columns of each block of :func:`_tie`.
    """

    band: Band
    cut: Band
    ties: np.ndarray
    responses: np.ndarray


# Places of arrays in the table: J, its clamped spheres and c; the factors; vectors to solve for.
BLOCKS, HELD, SCALE = range(3)
BAND, CUT_BAND, TIES, RESPONSES, ABOVE = 3, 7, 11, 12, 13
VECTOR, CUT_VECTOR, WHOLE = range(14, 17)
ARRAYS = 17


numbers_at: Any = None
"""Pointers to real or to complex numbers: :func:`compile_term` puts one of them in its place."""


@inlined
def _band_in(t, k, reach, above, numbers_at):
    """The band whose arrays begin at place k."""
    columns = carray(numbers_at(t[k, 0]), (6 * t[k + 2, 1], height_of(reach, above)))
    pivots, moved = vector_in(t, k + 1, integers_at), vector_in(t, k + 2, integers_at)
    return Band(columns, pivots, moved, matrix_in(t, k + 3, numbers_at), reach, above)


@inlined
def _factors_in(t, above, numbers_at):
    """The factors in a table; so many spheres ``above`` the diagonal of A."""
    reach, cut = t[BLOCKS, 2] // 2, max(t[RESPONSES, 1] // 6 - 1, 0)
    return Factors(
        _band_in(t, BAND, reach, above, numbers_at),
        _band_in(t, CUT_BAND, cut, 2 * cut, numbers_at),
        matrix_in(t, TIES, numbers_at),
        matrix_in(t, RESPONSES, numbers_at),
    )


def _factorise(context, _source, _order, _slots, _width):
    """Replace the factors by those of I − cJ; FINE, SINGULAR or UNSTABLE."""
    t = carray(integers_at(context), (ARRAYS, ROW))
    blocks, held = blocks_in(t, BLOCKS, floats_at), vector_in(t, HELD, integers_at)
    scale = vector_in(t, SCALE, numbers_at)[0]
    above, reach = vector_in(t, ABOVE, integers_at), blocks.shape[1] // 2
    # few chains need room for interchanges, and long ones are faster without
    for spheres in (reach, 2 * reach):
        above[0] = spheres
        factors = _factors_in(t, spheres, numbers_at)
        status = eliminate(factors.band, blocks, held, scale)
        if status != NARROW:
            break
    count, cut = blocks.shape[0], factors.cut
    if factors.band.moved.shape[0] == count:
        return status
    if status:
        return UNSTABLE
    _set_couplings(blocks, held, scale, factors)
    substitute(factors.band, factors.responses)
    for column in range(factors.responses.shape[0]):
        squares = 0.0
        for row in range(factors.responses.shape[1]):
            value = factors.responses[column, row]
            squares += value.real * value.real + value.imag * value.imag
        if not squares < LARGEST_RESPONSE**2:
            return UNSTABLE
    _subtract_responses(factors, count)
    return eliminate(cut, blocks[:0], held, scale)


@inlined
def _tie(last, m, width):
    """The first column of the block that ties one of the last spheres to its neighbour m."""
    return 6 * (last * width + m)


@part
def _subtract_ties(ties, last, half, inner, count, vectors, target, column, to):
    """Subtract G · vector in the rows of one of the last spheres."""
    for m in range(2 * half + 1):
        j = (inner + last + m - half) % count
        if j < inner:
            tie, row = _tie(last, m, 2 * half + 1), 12 * half + 6 * j
            subtract(ties, tie, 0, target, column, to, vectors, column, row, 6)


@part
def _set_couplings(blocks, held, scale, factors):
    """Set F, G and the block of the last spheres of a periodic chain."""
    cut, ties, responses = factors.cut, factors.ties, factors.responses
    count, width = blocks.shape[0], blocks.shape[1]
    half, inner = width // 2, factors.band.moved.shape[0]
    clear(cut)
    ties[:] = 0.0
    responses[:] = 0.0
    for last in range(inner, count):
        if held[last]:
            continue
        for m in range(width):
            j = (last + m - half) % count
            if not held[j]:
                if j >= inner:
                    row = 6 * (last - j + cut.above)
                    add_block(cut.columns, 6 * (j - inner), row, blocks, last, m, -scale)
                else:
                    add_block(ties, _tie(last - inner, m, width), 0, blocks, last, m, -scale)
            i = (last - m + half) % count
            if i < inner and not held[i]:
                column, row = 6 * (last - inner), 12 * half + 6 * i
                add_block(responses, column, row, blocks, i, m, -scale)


@part
def _subtract_responses(factors, count):
    """B − G A⁻¹ F."""
    cut, ties, responses = factors.cut, factors.ties, factors.responses
    half, inner = factors.band.reach, factors.band.moved.shape[0]
    for column in range(responses.shape[0]):
        for last in range(count - inner):
            to = 6 * (last - column // 6 + cut.above)
            _subtract_ties(ties, last, half, inner, count, responses, cut.columns, column, to)


def _solve(context, source, order, slots, _width):
    """Replace the vector at ``source`` by (I − cJ)⁻¹ vector.

    It has six elements for every sphere; or for the ``slots`` spheres at the address ``order``, if
    that is not 0, with zeros for all others.
    """
    t = carray(integers_at(context), (ARRAYS, ROW))
    factors = _factors_in(t, vector_in(t, ABOVE, integers_at)[0], numbers_at)
    band, cut, ties, count = factors.band, factors.cut, factors.ties, t[BLOCKS, 1]
    right, cut_right = matrix_in(t, VECTOR, numbers_at), matrix_in(t, CUT_VECTOR, numbers_at)
    inner, start, cut_start = band.moved.shape[0], 12 * band.reach, 12 * cut.reach
    vector = carray(numbers_at(source), (count, 6))
    spheres = carray(integers_at(order), slots)
    if order:
        given = carray(numbers_at(source), (slots, 6))
        vector = matrix_in(t, WHOLE, numbers_at)
        vector[:] = 0.0
        for slot in range(slots):
            for p in range(6):
                vector[spheres[slot], p] = given[slot, p]
    for i in range(inner):
        for p in range(6):
            right[0, start + 6 * i + p] = vector[i, p]
    substitute(band, right)
    if inner < count:
        for last in range(count - inner):
            for p in range(6):
                cut_right[0, cut_start + 6 * last + p] = vector[inner + last, p]
        for last in range(count - inner):
            to = cut_start + 6 * last
            _subtract_ties(ties, last, band.reach, inner, count, right, cut_right, 0, to)
        substitute(cut, cut_right)
        for last in range(count - inner):
            row, responses = cut_start + 6 * last, factors.responses
            subtract(responses, 6 * last, start, right, 0, start, cut_right, 0, row, 6 * inner)
            for p in range(6):
                vector[inner + last, p] = cut_right[0, row + p]
    for i in range(inner):
        for p in range(6):
            vector[i, p] = right[0, start + 6 * i + p]
    if order:
        given = carray(numbers_at(source), (slots, 6))
        for slot in range(slots):
            for p in range(6):
                given[slot, p] = vector[spheres[slot], p]
    return FINE


class Elimination:
    """Factors of I − cJ for one J, and solutions with them; a thread needs its own.

    Parameters
    ----------
    blocks, held
        J (N, 2w + 1, 6, 6) and (N,) integers, 1 for clamped spheres: kept, and read by
        :meth:`factorise`.
    periodic
        Whether the chain closes.
    kind
        float or complex, the type of c and of the vectors.

    Attributes
    ----------
    table
        Addresses of all arrays, the context of the functions at ``factorise_at`` and ``solve_at``.
    scale
        (1,), c, which a caller in machine code sets before it calls ``factorise_at``.
    """

    def __init__(self, blocks: np.ndarray, held: np.ndarray, periodic: bool, kind: type) -> None:
        count, reach = blocks.shape[0], blocks.shape[1] // 2
        cut = min(reach, count) if periodic else 0
        inner, cut_reach = count - cut, max(cut - 1, 0)
        self.scale: np.ndarray = np.zeros(1, kind)
        self._arrays: tuple[np.ndarray, ...] = (
            blocks,
            held,
            self.scale,
            *allocate_band(inner, reach, kind),
            *allocate_band(cut, cut_reach, kind),
            np.zeros((6 * cut * (2 * reach + 1), 2 * LANES), kind),
            allocate_vectors(6 * cut, inner, reach, kind),
            np.zeros(1, np.int64),
            allocate_vectors(1, inner, reach, kind),
            allocate_vectors(1, cut, cut_reach, kind),
            np.zeros((count, 6), kind),
        )
        self.table = table_of(self._arrays)
        numbers_at = complex_at if kind is complex else floats_at
        factorise = compile_term(_factorise, numbers_at=numbers_at)
        solve = compile_term(_solve, numbers_at=numbers_at)
        self.factorise_at, self.solve_at = factorise.address, solve.address
        self._factorise, self._solve = factorise.ctypes, solve.ctypes

    def factorise(self, scale: complex) -> int:
        """Take c = ``scale``: FINE, SINGULAR or UNSTABLE."""
        self.scale[0] = scale
        return int(self._factorise(self.table.ctypes.data, 0, 0, 0, 0))

    def solve(self, vector: np.ndarray, spheres: np.ndarray | None = None) -> None:
        """Replace ``vector`` by (I − cJ)⁻¹ vector.

        It is contiguous, with six elements for every sphere, or for each of ``spheres`` and zeros
        for all others.
        """
        order, slots = (0, 0) if spheres is None else (spheres.ctypes.data, len(spheres))
        self._solve(self.table.ctypes.data, vector.ctypes.data, order, slots, 0)
