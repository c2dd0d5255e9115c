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
from numba import carray

from nrchain._addresses import (
    ROW,
    blocks_in,
    compile_term,
    complex_at,
    floats_at,
    integers_at,
    matrix_in,
    table_of,
    vector_in,
)
from nrchain._compile import inlined
from nrchain.motion.band_columns import (
    Band,
    add_block,
    allocate_band,
    allocate_vectors,
    clear,
    eliminate,
    fill,
    substitute,
)
from nrchain.motion.lanes import LANES, subtract

FINE, SINGULAR, UNSTABLE = 0, 1, 2

LARGEST_RESPONSE = 1e8
"""Bound on the norm of a column of A⁻¹ F: the solution keeps half its digits."""


class Factors(NamedTuple):
    """Factors of I − cJ.

    ``band`` is A, ``cut`` the matrix of the last spheres of a periodic chain, ``ties`` (w, 2w + 1,
    6, 6) is G, and ``responses`` A⁻¹ F by columns.
    """

    band: Band
    cut: Band
    ties: np.ndarray
    responses: np.ndarray


# Places of arrays in the table: J, its clamped spheres and c; the factors; vectors to solve for.
BLOCKS, HELD, SCALE = range(3)
COLUMNS, PIVOTS, TOPS, CUT_COLUMNS, CUT_PIVOTS, CUT_TOPS, TIES, RESPONSES = range(3, 11)
VECTOR, CUT_VECTOR, WHOLE = range(11, 14)
ARRAYS = 14


numbers_at: Any = None
"""Pointers to real or to complex numbers: :func:`compile_term` puts one of them in its place."""


@inlined
def _factors_in(t, numbers_at):
    """The factors in a table."""
    reach, cut = t[BLOCKS, 2] // 2, t[CUT_TOPS, 1]
    return Factors(
        Band(
            matrix_in(t, COLUMNS, numbers_at),
            vector_in(t, PIVOTS, integers_at),
            vector_in(t, TOPS, integers_at),
            reach,
        ),
        Band(
            matrix_in(t, CUT_COLUMNS, numbers_at),
            vector_in(t, CUT_PIVOTS, integers_at),
            vector_in(t, CUT_TOPS, integers_at),
            max(cut - 1, 0),
        ),
        blocks_in(t, TIES, numbers_at),
        matrix_in(t, RESPONSES, numbers_at),
    )


def _factorise(context, _source, _order, _slots, _width):
    """Replace the factors by those of I − cJ; FINE, SINGULAR or UNSTABLE."""
    t = carray(integers_at(context), (ARRAYS, ROW))
    blocks, held = blocks_in(t, BLOCKS, floats_at), vector_in(t, HELD, integers_at)
    scale = vector_in(t, SCALE, numbers_at)[0]
    factors = _factors_in(t, numbers_at)
    band, cut = factors.band, factors.cut
    count = blocks.shape[0]
    inner = band.tops.shape[0]
    fill(band, blocks, held, scale)
    regular = eliminate(band)
    if inner == count:
        return FINE if regular else SINGULAR
    if not regular:
        return UNSTABLE
    _set_couplings(blocks, held, scale, factors)
    substitute(band, factors.responses)
    for column in range(factors.responses.shape[0]):
        squares = 0.0
        for row in range(factors.responses.shape[1]):
            value = factors.responses[column, row]
            squares += value.real * value.real + value.imag * value.imag
        if not squares < LARGEST_RESPONSE**2:
            return UNSTABLE
    _subtract_responses(factors, count)
    return FINE if eliminate(cut) else SINGULAR


@inlined
def _set_couplings(blocks, held, scale, factors):
    """Set F, G and the block of the last spheres of a periodic chain."""
    cut, ties, responses = factors.cut, factors.ties, factors.responses
    count, width = blocks.shape[0], blocks.shape[1]
    half, inner = width // 2, factors.band.tops.shape[0]
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
                    add_block(cut, last - inner, j - inner, -scale, blocks[last, m])
                else:
                    for p in range(6):
                        for q in range(6):
                            ties[last - inner, m, p, q] = -scale * blocks[last, m, p, q]
            i = (last - m + half) % count
            if i < inner and not held[i]:
                for q in range(6):
                    column, row = 6 * (last - inner) + q, 12 * half + 6 * i
                    for p in range(6):
                        responses[column, row + p] -= scale * blocks[i, m, p, q]


@inlined
def _subtract_responses(factors, count):
    """B − G A⁻¹ F."""
    cut, ties, responses = factors.cut, factors.ties, factors.responses
    width, inner = ties.shape[1], factors.band.tops.shape[0]
    half = width // 2
    for column in range(responses.shape[0]):
        for last in range(ties.shape[0]):
            to = 6 * (last - column // 6 + 2 * cut.reach)
            for m in range(width):
                j = (inner + last + m - half) % count
                if j >= inner:
                    continue
                row = 12 * half + 6 * j
                for p in range(6):
                    change = cut.columns[column, to + p]
                    for q in range(6):
                        change -= ties[last, m, p, q] * responses[column, row + q]
                    cut.columns[column, to + p] = change


def _solve(context, source, order, slots, _width):
    """Replace the vector at ``source`` by (I − cJ)⁻¹ vector.

    It has six elements for every sphere; or for the ``slots`` spheres at the address ``order``, if
    that is not 0, with zeros for all others.
    """
    t = carray(integers_at(context), (ARRAYS, ROW))
    factors = _factors_in(t, numbers_at)
    band, ties, count = factors.band, factors.ties, t[BLOCKS, 1]
    right, cut_right = matrix_in(t, VECTOR, numbers_at), matrix_in(t, CUT_VECTOR, numbers_at)
    inner, start, cut_start = band.tops.shape[0], 12 * band.reach, 12 * factors.cut.reach
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
        half = band.reach
        for last in range(count - inner):
            for p in range(6):
                value = vector[inner + last, p]
                for m in range(2 * half + 1):
                    j = (inner + last + m - half) % count
                    if j >= inner:
                        continue
                    for q in range(6):
                        value -= ties[last, m, p, q] * right[0, start + 6 * j + q]
                cut_right[0, cut_start + 6 * last + p] = value
        substitute(factors.cut, cut_right)
        for last in range(count - inner):
            row = cut_start + 6 * last
            x0, x1, x2 = cut_right[0, row], cut_right[0, row + 1], cut_right[0, row + 2]
            x3, x4, x5 = cut_right[0, row + 3], cut_right[0, row + 4], cut_right[0, row + 5]
            for p in range(6):
                vector[inner + last, p] = cut_right[0, row + p]
            for r in range(start, start + 6 * inner, LANES):
                subtract(factors.responses, 6 * last, r, right, 0, r, (x0, x1, x2, x3, x4, x5))
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
        band, rest = allocate_band(inner, reach, kind), allocate_band(cut, cut_reach, kind)
        self.scale: np.ndarray = np.zeros(1, kind)
        self._arrays: tuple[np.ndarray, ...] = (
            blocks,
            held,
            self.scale,
            *band[:3],
            *rest[:3],
            np.zeros((cut, 2 * reach + 1, 6, 6), kind),
            allocate_vectors(6 * cut, inner, reach, kind),
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
