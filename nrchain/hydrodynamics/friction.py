"""(v, ω)_i = Σ_j μ_ij · (F, T)_j: friction between spheres, summed over pairs.

The mobilities μ_ij are those of Rotne, Prager and Yamakawa
(:mod:`nrchain.hydrodynamics.rotne_prager`). The matrix of all pairs is positive definite at any
positions unless two spheres coincide. A matrix cut at a reach along the chain may lose this
property when spheres nearly touch.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from numba import prange

from nrchain._addresses import (
    ROW,
    Term,
    blocks_in,
    carray,
    compile_term,
    floats_at,
    integers_at,
    matrix_in,
    table_of,
    vector_in,
)
from nrchain._compile import kernel, part
from nrchain.hydrodynamics import sharing
from nrchain.hydrodynamics.images import Layout
from nrchain.hydrodynamics.pairs import NEAR
from nrchain.hydrodynamics.rotne_prager import sum_changes, sum_twists
from nrchain.hydrodynamics.sharing import PARALLEL_PAIRS, compile_sum
from nrchain.hydrodynamics.tree.choice import friction_tree


@cache
def _twist_kernel(parallel: bool):
    """Compile the sum over pairs: see :meth:`PairFriction.apply`."""

    def add_twists(sources, radius, first_slot, reach, twists):
        for i in prange(twists.shape[0]):
            me = first_slot + i
            first, last = max(0, me - reach), min(sources.shape[1], me + reach + 1)
            before = sum_twists(sources, radius, me, first, me)
            after = sum_twists(sources, radius, me, me + 1, last)
            for k in range(3):
                twists[i, k] += sources[3 + k, me] + before[k] + after[k]
                twists[i, 3 + k] += (sources[6 + k, me] + before[3 + k] + after[3 + k]) / radius

    return compile_sum(add_twists, parallel)


@cache
def _product_kernel(parallel: bool):
    """Compile the derivative of the sum: see :meth:`PairFriction.add_product`."""

    def add_product(sources, changes, radius, first_slot, reach, twists):
        for i in prange(twists.shape[0]):
            me = first_slot + i
            first, last = max(0, me - reach), min(sources.shape[1], me + reach + 1)
            before = sum_changes(sources, changes, radius, me, first, me)
            after = sum_changes(sources, changes, radius, me, me + 1, last)
            for k in range(3):
                twists[i, k] += changes[3 + k, me] + before[k] + after[k]
                twists[i, 3 + k] += (changes[6 + k, me] + before[3 + k] + after[3 + k]) / radius

    return compile_sum(add_product, parallel)


@kernel
def _columns(sources, changes, units, radius, me, j, columns):
    """columns (6, 9) = ∂(v, ω)_me/∂(r, F, T)_j, including j = me."""
    columns[:] = 0.0
    if j == me:
        for k in range(3):
            columns[k, 3 + k] = units[1]
            columns[3 + k, 6 + k] = units[2] / radius
        return
    for column in range(9):
        changes[column, j] = units[column // 3]
        twist = sum_changes(sources, changes, radius, me, j, j + 1)
        changes[column, j] = 0.0
        for row in range(6):
            columns[row, column] = twist[row] if row < 3 else twist[row] / radius


@kernel
def _add_blocks(sources, changes, units, radius, first_slot, near, wrench_blocks, blocks):
    """blocks += μ·∂W + ∂μ·W of the pairs within ``near``: see :meth:`PairFriction.add_jacobian`."""
    count, width = blocks.shape[0], blocks.shape[1]
    columns = np.empty((6, 9))
    changes[:] = 0.0
    for i in range(count):
        me = first_slot + i
        for j in range(max(0, me - near), min(sources.shape[1], me + near + 1)):
            _columns(sources, changes, units, radius, me, j, columns)
            place = width // 2 + j - me
            for row in range(6):
                for k in range(3):
                    blocks[i, place, row, k] += columns[row, k]
                    blocks[i, width // 2, row, k] -= columns[row, k]
            place -= wrench_blocks.shape[1] // 2
            for m in range(max(0, -place), min(wrench_blocks.shape[1], width - place)):
                wrench_block = wrench_blocks[(j - first_slot) % count, m]
                _add_matrix_product(columns[:, 3:], wrench_block, blocks[i, place + m])


@part
def _add_matrix_product(first, second, out):
    for p in range(6):
        for q in range(6):
            total = 0.0
            for k in range(6):
                total += first[p, k] * second[k, q]
            out[p, q] += total


@kernel
def _lay_out(vectors, wrenches, units, spheres, shifts, weights, rows):
    """Fill the rows r, f and τ, or their changes, slot by slot of a layout."""
    for slot in range(spheres.shape[0]):
        sphere = spheres[slot]
        for k in range(3):
            rows[k, slot] = vectors[sphere, k]
            rows[3 + k, slot] = weights[slot] * wrenches[sphere, k] * units[1]
            rows[6 + k, slot] = weights[slot] * wrenches[sphere, 3 + k] * units[2]
        rows[0, slot] += shifts[slot]


# Places of arrays in the table of a term: rows of sources and of their changes; units; spheres,
# shifts and weights of a layout; ∂W; N, the first slot and the reach; a.
SOURCES, CHANGES, UNITS, SPHERES, SHIFTS, WEIGHTS, WRENCH_BLOCKS, PLACE, RADIUS = range(9)


@part
def _sources_at(t, positions, wrenches):
    """Lay out the sources of a term for positions and wrenches at these addresses."""
    n, sources = vector_in(t, PLACE, integers_at)[0], matrix_in(t, SOURCES, floats_at)
    _lay_out(
        carray(floats_at(positions), (n, 3)),
        carray(floats_at(wrenches), (n, 6)),
        vector_in(t, UNITS, floats_at),
        vector_in(t, SPHERES, integers_at),
        vector_in(t, SHIFTS, floats_at),
        vector_in(t, WEIGHTS, floats_at),
        sources,
    )
    return sources


add: Any = None
"""The sum over pairs of a term: :func:`compile_term` puts its kernel in this place."""


def _apply_at(context, positions, wrenches, out, width):
    """The term of :meth:`PairFriction.apply`."""
    t = carray(integers_at(context), (9, ROW))
    place, radius = vector_in(t, PLACE, integers_at), vector_in(t, RADIUS, floats_at)[0]
    sources, twists = _sources_at(t, positions, wrenches), carray(floats_at(out), (place[0], 6))
    add(sources, radius, place[1], place[2], twists)
    return 0


def _add_blocks_at(context, positions, wrenches, out, width):
    """The term of :meth:`PairFriction.add_jacobian`, with all neighbours within reach."""
    t = carray(integers_at(context), (9, ROW))
    place, radius = vector_in(t, PLACE, integers_at), vector_in(t, RADIUS, floats_at)[0]
    _add_blocks(
        _sources_at(t, positions, wrenches),
        matrix_in(t, CHANGES, floats_at),
        vector_in(t, UNITS, floats_at),
        radius,
        place[1],
        place[2],
        blocks_in(t, WRENCH_BLOCKS, floats_at),
        carray(floats_at(out), (place[0], 2 * width + 1, 6, 6)),
    )
    return 0


class PairFriction:
    """(v, ω) = μ·(F, T): the twists that wrenches on all spheres cause, and their derivatives.

    Parameters
    ----------
    count
        Number of spheres N.
    reach
        Neighbours on either side that a wrench moves; None: all pairs, with every image of a
        periodic chain. This sum converges only if the forces of a period sum to zero, as elastic
        forces do.
    radius, viscosity
        a and η.
    period
        Length along x after which the chain repeats; 0 for an open chain.
    accuracy
        Largest error of the sum over all pairs of a long open chain, relative to the largest twist:
        a tree then takes the place of the direct sum where that is faster. 0 keeps the direct sum.

    Positions are (N, 3), wrenches (F, T) and twists (v, ω) are (N, 6), in the lab. No N × N matrix
    is stored.
    """

    def __init__(
        self,
        count: int,
        reach: int | None,
        radius: float,
        viscosity: float,
        period: float = 0.0,
        accuracy: float = 0.0,
    ) -> None:
        self.count, self.radius, self.period = count, float(radius), float(period)
        self._layout = Layout.of(count, reach, period)
        self.reach = self._layout.reach
        translation = 1.0 / (6.0 * math.pi * viscosity * radius)
        rotation = 1.0 / (8.0 * math.pi * viscosity * radius**2)
        self._units = np.array([1.0, translation, rotation])
        self._sources = np.empty((9, len(self._layout.spheres)))
        self._still = np.zeros(len(self._layout.spheres))
        self._changes = np.empty_like(self._sources)
        self._parallel = self.reach * count * 2 > PARALLEL_PAIRS
        self.tree = friction_tree(self._layout, self.radius, accuracy)

    def _place(self, positions: np.ndarray, wrenches: np.ndarray) -> None:
        layout = self._layout
        _lay_out(
            positions,
            wrenches,
            self._units,
            layout.spheres,
            layout.shifts,
            layout.weights,
            self._sources,
        )
        if self.tree:
            self.tree.move()

    def apply(self, positions: np.ndarray, wrenches: np.ndarray, twists: np.ndarray) -> None:
        """twists += μ·W: the mobility of each sphere and of the pairs within reach."""
        self._place(positions, wrenches)
        if self.tree:
            self.tree.add_twists(self._sources, twists)
            return
        place = self.radius, self._layout.first, self.reach
        sharing.add(_twist_kernel, self._parallel, self._sources, *place, twists)

    def direct_twists(self, spheres: Sequence[int] | np.ndarray) -> np.ndarray:
        """(v, ω) (n, 6) of some spheres by the direct sum, at the last positions and wrenches."""
        rows, add = np.zeros((len(spheres), 6)), _twist_kernel(False)
        for row, sphere in zip(rows, spheres, strict=True):
            place = self.radius, self._layout.first + sphere, self.reach
            add(self._sources, *place, row[None])
        return rows

    def add_product(
        self, poses: np.ndarray, wrench_changes: np.ndarray, twists: np.ndarray
    ) -> None:
        """twists += μ·δW + (∂μ·δr)·W, the change of :meth:`apply` with positions and wrenches.

        ``poses`` (N, 6) is the change (δr, φ) of every pose, of which φ has no effect, and
        ``wrench_changes`` (N, 6) is δW. Both are about the positions and wrenches last passed to
        :meth:`apply` or :meth:`add_jacobian`.
        """
        layout = self._layout
        _lay_out(
            poses,
            wrench_changes,
            self._units,
            layout.spheres,
            self._still,
            layout.weights,
            self._changes,
        )
        if self.tree:
            self.tree.add_product(self._sources, self._changes, twists)
            return
        place = self.radius, self._layout.first, self.reach
        sharing.add(_product_kernel, self._parallel, self._sources, self._changes, *place, twists)

    def add_jacobian(
        self,
        positions: np.ndarray,
        wrenches: np.ndarray,
        wrench_blocks: np.ndarray,
        blocks: np.ndarray,
        near: int = 0,
    ) -> None:
        """blocks[i, w + m] += ∂(v, ω)_i / ∂(u, φ)_{i+m}, with μ cut to ``near`` neighbours.

        ``wrench_blocks`` (N, 2w' + 1, 6, 6) is ∂W_i / ∂(u, φ)_{i+m}. Terms outside the 2w + 1
        blocks of a row are left out. With ``near`` = 0, μ is one-body: a preconditioner with the
        whole stiff local response and without the smooth flow of other spheres.
        """
        self._place(positions, wrenches)
        near = min(near, self.reach, blocks.shape[1] // 2)
        _add_blocks(
            self._sources,
            self._changes,
            self._units,
            self.radius,
            self._layout.first,
            near,
            wrench_blocks,
            blocks,
        )

    @property
    def near(self) -> int | None:
        """Neighbours with exact Jacobian blocks in :meth:`term`; None if they reach farther."""
        return None if self.tree or self._parallel or self.reach > NEAR else self.reach

    def term(self, wrench_blocks: np.ndarray) -> Term:
        """The same for near neighbours by address, with ``wrenches`` in the place of frames.

        ``wrench_blocks`` (N, 2w + 1, 6, 6) is ∂W where blocks are added.
        """
        layout, sums = self._layout, _twist_kernel(False)
        entries = compile_term(_apply_at, add=sums), compile_term(_add_blocks_at)
        arrays = (
            np.zeros_like(self._sources),
            np.zeros_like(self._changes),
            self._units,
            np.ascontiguousarray(layout.spheres, np.int64),
            np.ascontiguousarray(layout.shifts, float),
            np.ascontiguousarray(layout.weights, float),
            wrench_blocks,
            np.array([self.count, layout.first, self.reach]),
            np.array([self.radius]),
        )
        context = table_of(arrays)
        return Term(entries[0].address, entries[1].address, context, (*arrays, *entries))

    def matrix(self, positions: np.ndarray) -> np.ndarray:
        """μ (6N, 6N), one column for each unit wrench: for small systems."""
        columns = np.zeros((6 * self.count, self.count, 6))
        for wrench, twists in zip(np.eye(6 * self.count), columns, strict=True):
            self.apply(positions, wrench.reshape(-1, 6), twists)
        return columns.reshape(6 * self.count, -1).T
