"""(I − cJ) x = b for a chain whose spheres couple to w neighbours, with c real or complex.

``blocks`` (N, 2w + 1, 6, 6) is J: ``blocks[i, w + m]`` couples sphere i to sphere i + m. Blocks
that leave an open chain are not read; those of a periodic chain wrap, and add up where they meet.
Rows and columns of clamped spheres are those of the identity.

An open chain is eliminated in the order of its spheres. A periodic chain is cut open by its last w
spheres: with A the matrix of the others, F and G the couplings, B the block of the last,

    (B − G A⁻¹ F) x₂ = b₂ − G A⁻¹ b₁,   x₁ = A⁻¹ b₁ − (A⁻¹ F) x₂.

Pivots are chosen among all rows within reach (:mod:`nrchain.motion.band_columns`), so that open
chains are stable with any diagonal blocks. The errors of a periodic chain grow with A⁻¹ F, the
response of the others to the last spheres. ``factorise`` returns :data:`UNSTABLE` if it exceeds
:data:`LARGEST_RESPONSE`, which needs A nearly singular where the whole matrix is not: a slightly
different c helps.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nrchain._compile import inlined, kernel
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
    """Factors of I − cJ and the work arrays of ``solve``; a thread needs its own.

    ``band`` is A, ``cut`` the matrix of the last spheres of a periodic chain, ``ties`` (w, 2w + 1,
    6, 6) is G, and ``responses`` A⁻¹ F by columns.
    """

    band: Band
    cut: Band
    ties: np.ndarray
    responses: np.ndarray
    vector: np.ndarray
    cut_vector: np.ndarray


def allocate(count: int, reach: int, periodic: bool, dtype: type) -> Factors:
    """Arrays for N = ``count`` spheres, w = ``reach``; ``dtype`` is float or complex, as c."""
    cut = min(reach, count) if periodic else 0
    inner, cut_reach = count - cut, max(cut - 1, 0)
    return Factors(
        allocate_band(inner, reach, dtype),
        allocate_band(cut, cut_reach, dtype),
        np.zeros((cut, 2 * reach + 1, 6, 6), dtype),
        allocate_vectors(6 * cut, inner, reach, dtype),
        allocate_vectors(1, inner, reach, dtype),
        allocate_vectors(1, cut, cut_reach, dtype),
    )


@kernel
def factorise(blocks, held, scale, factors):
    """Set ``factors`` to those of I − scale · J: FINE, SINGULAR or UNSTABLE.

    ``scale`` is real or complex as the arrays of ``factors``; ``held`` (N,) marks clamped spheres.
    """
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


@kernel
def solve(factors, vector):
    """Replace ``vector`` (N, 6), of the type of ``factors``, by (I − cJ)⁻¹ vector."""
    band, right, cut_right = factors.band, factors.vector, factors.cut_vector
    ties, count = factors.ties, vector.shape[0]
    inner, start, cut_start = band.tops.shape[0], 12 * band.reach, 12 * factors.cut.reach
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


@kernel
def solve_slots(factors, slots, work, vector):
    """As ``solve`` for the spheres ``slots``, six elements each, with zeros for all others.

    ``work`` (N, 6) is scratch space.
    """
    work[:] = 0.0
    for slot in range(slots.shape[0]):
        for p in range(6):
            work[slots[slot], p] = vector[6 * slot + p]
    solve(factors, work)
    for slot in range(slots.shape[0]):
        for p in range(6):
            vector[6 * slot + p] = work[slots[slot], p]
