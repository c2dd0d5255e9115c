"""(v, ω)_i = Σ_j (u, w)(r_i − r_j): the disturbance of a background flow, summed over pairs.

The flow u of one sphere is that of :mod:`nrchain.hydrodynamics.disturbance_law`.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, partial
from typing import Any, Literal

import numpy as np
from numba import prange

from nrchain._addresses import (
    ROW,
    Term,
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
from nrchain.hydrodynamics.disturbance_law import (
    add_finite_size,
    add_finite_size_change,
    add_stresslet,
    add_stresslet_change,
    between,
)
from nrchain.hydrodynamics.images import Layout
from nrchain.hydrodynamics.pairs import NEAR
from nrchain.hydrodynamics.sharing import PARALLEL_PAIRS, compile_sum
from nrchain.hydrodynamics.tree.choice import disturbance_tree

Part = Literal["stresslet", "finite size"]

_SIZES = {"stresslet": (5 / 2, 3), "finite size": (8 / 3, 5)}
"""The prefactor of each part: a number, and the power of a."""


@cache
def _twist_kernel(leading: bool, parallel: bool) -> Any:
    """Compile the sum over pairs of one part: see :meth:`Disturbance.add_twists`."""

    def add_disturbance(points, weights, strain, size, first, reach, twists):
        for i in prange(twists.shape[0]):
            me = first + i
            for j in range(max(0, me - reach), min(points.shape[0], me + reach + 1)):
                if j == me:
                    continue
                x, factor = between(points, me, j), -size * weights[j]
                if leading:
                    add_stresslet(x, strain, factor, twists[i])
                else:
                    add_finite_size(x, strain, factor, twists[i])

    return compile_sum(add_disturbance, parallel, str(leading))


@cache
def _product_kernel(leading: bool, parallel: bool) -> Any:
    """Compile the derivative of the sum: see :meth:`Disturbance.add_product`."""

    def add_disturbance_product(points, moves, weights, strain, size, first, reach, out):
        for i in prange(out.shape[0]):
            me = first + i
            for j in range(max(0, me - reach), min(points.shape[0], me + reach + 1)):
                if j == me:
                    continue
                x, dx = between(points, me, j), between(moves, me, j)
                factor = -size * weights[j]
                if leading:
                    add_stresslet_change(x, dx, strain, factor, out[i])
                else:
                    add_finite_size_change(x, dx, strain, factor, out[i])

    return compile_sum(add_disturbance_product, parallel, str(leading))


@kernel
def _add_blocks(points, weights, strain, size, leading, first, reach, blocks):
    centre = blocks.shape[1] // 2
    column = np.empty(6)
    for i in range(blocks.shape[0]):
        me = first + i
        for j in range(max(0, me - reach), min(points.shape[0], me + reach + 1)):
            if j == me:
                continue
            x, factor = between(points, me, j), -size * weights[j]
            for k in range(3):
                dx = (1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0)
                column[:] = 0.0
                if leading:
                    add_stresslet_change(x, dx, strain, factor, column)
                else:
                    add_finite_size_change(x, dx, strain, factor, column)
                for row in range(6):
                    blocks[i, centre, row, k] += column[row]
                    blocks[i, centre + j - me, row, k] -= column[row]


# Places of arrays in the table of a term: the points of a layout, its spheres, shifts and weights;
# E; the prefactor; N, the first slot, the reach, and whether it is the leading order.
POINTS, SPHERES, SHIFTS, WEIGHTS, STRAIN, SIZE, PLACE = range(7)


@part
def _points_at(t, positions):
    """The points of a layout for positions (N, 3) at this address."""
    points, spheres = matrix_in(t, POINTS, floats_at), vector_in(t, SPHERES, integers_at)
    r = carray(floats_at(positions), (vector_in(t, PLACE, integers_at)[0], 3))
    shifts = vector_in(t, SHIFTS, floats_at)
    for slot in range(spheres.shape[0]):
        for k in range(3):
            points[slot, k] = r[spheres[slot], k]
        points[slot, 0] += shifts[slot]
    return points


add: Any = None
"""The kernel of a term: :func:`compile_term` puts that of a part in its place."""


def _add_twists_at(context, positions, frames, out, width):
    """The term of :meth:`Disturbance.add_twists`."""
    t = carray(integers_at(context), (7, ROW))
    place, weights = vector_in(t, PLACE, integers_at), vector_in(t, WEIGHTS, floats_at)
    strain, size = matrix_in(t, STRAIN, floats_at), vector_in(t, SIZE, floats_at)[0]
    twists = carray(floats_at(out), (place[0], 6))
    add(_points_at(t, positions), weights, strain, size, place[1], place[2], twists)
    return 0


def _add_blocks_at(context, positions, frames, out, width):
    """The term of :meth:`Disturbance.add_blocks`."""
    t = carray(integers_at(context), (7, ROW))
    place, weights = vector_in(t, PLACE, integers_at), vector_in(t, WEIGHTS, floats_at)
    strain, size = matrix_in(t, STRAIN, floats_at), vector_in(t, SIZE, floats_at)[0]
    blocks = carray(floats_at(out), (place[0], 2 * width + 1, 6, 6))
    points = _points_at(t, positions)
    _add_blocks(points, weights, strain, size, place[3] != 0, place[1], place[2], blocks)
    return 0


class Disturbance:
    """(v, ω)_i = Σ_j (u, w)(r_i − r_j): how rigid spheres disturb a flow, and the derivative.

    Parameters
    ----------
    part
        The stresslet or the finite size.
    gradient
        G (3, 3) of the flow G·r; only its symmetric part E has an effect.
    count, radius
        N and a.
    reach
        Neighbours on either side whose flow counts; None: all pairs, with every image of a
        periodic chain. This sum converges: the p-th image contributes as 1/p².
    period
        Length along x after which the chain repeats; 0 for an open chain.
    accuracy
        Largest error of the sum over all pairs of a long open chain, relative to its largest value:
        a tree then takes the place of the direct sum where that is faster. 0 keeps the direct sum.
    """

    def __init__(
        self,
        part: Part,
        gradient: np.ndarray,
        *,
        count: int,
        radius: float,
        reach: int | None,
        period: float = 0.0,
        accuracy: float = 0.0,
    ) -> None:
        factor, power = _SIZES[part]
        self._leading = part == "stresslet"
        self._strain = 0.5 * (gradient + gradient.T)
        self._count, self._size = count, factor * float(radius) ** power
        self._layout = Layout.of(count, reach, period)
        self.reach = self._layout.reach
        self._parallel = 2 * self.reach * count > PARALLEL_PAIRS
        law = self._leading, self._strain, self._size
        # evaluations at other positions leave the point of linearisation as it is
        self.tree, self._linearised_tree = (
            disturbance_tree(law, self._layout, float(radius), accuracy) for _ in range(2)
        )

    @property
    def near(self) -> int | None:
        """Neighbours with exact Jacobian blocks; None if only :meth:`add_product` is exact."""
        return self.reach if self.reach <= NEAR else None

    def _points(self, positions: np.ndarray) -> np.ndarray:
        points = positions[self._layout.spheres]
        points[:, 0] += self._layout.shifts
        return points

    def _law(self) -> tuple[Any, ...]:
        layout = self._layout
        return layout.weights, self._strain, self._size, layout.first, layout.reach

    def add_twists(self, positions: np.ndarray, twists: np.ndarray) -> None:
        """twists (N, 6) += (Σ_j u, Σ_j w) at positions (N, 3)."""
        if self.tree:
            self.tree.move()
            self.tree.add_twists(positions.T, twists)
            return
        compiled, points = partial(_twist_kernel, self._leading), self._points(positions)
        sharing.add(compiled, self._parallel, points, *self._law(), twists)

    def direct_twists(
        self, positions: np.ndarray, spheres: Sequence[int] | np.ndarray
    ) -> np.ndarray:
        """(Σ_j u, Σ_j w) (n, 6) of some spheres by the direct sum, at positions (N, 3)."""
        rows, points = np.zeros((len(spheres), 6)), self._points(positions)
        weights, strain, size, first, reach = self._law()
        add = _twist_kernel(self._leading, False)
        for row, sphere in zip(rows, spheres, strict=True):
            add(points, weights, strain, size, first + sphere, reach, row[None])
        return rows

    def term(self) -> Term | None:
        """The disturbance by near neighbours as a term by address; None for a longer reach."""
        if self.near is None or self._parallel:
            return None
        layout, sums = self._layout, _twist_kernel(self._leading, False)
        entries = compile_term(_add_twists_at, add=sums), compile_term(_add_blocks_at)
        arrays = (
            np.zeros((len(layout.spheres), 3)),
            np.ascontiguousarray(layout.spheres, np.int64),
            np.ascontiguousarray(layout.shifts, float),
            np.ascontiguousarray(layout.weights, float),
            np.ascontiguousarray(self._strain),
            np.array([self._size]),
            np.array([self._count, layout.first, self.reach, self._leading]),
        )
        context = table_of(arrays)
        return Term(entries[0].address, entries[1].address, context, (*arrays, *entries))

    def linearise(self, positions: np.ndarray) -> None:
        """Take the derivative at positions (N, 3)."""
        self._there = self._points(positions)
        if self._linearised_tree:
            self._linearised_tree.move()

    def add_blocks(self, blocks: np.ndarray) -> None:
        """blocks (N, 2w + 1, 6, 6)[i, w + m] += ∂(v, ω)_i / ∂(u, φ)_{i+m}.

        Adds nothing if the blocks cannot hold the whole derivative: the flow is smooth.
        """
        if self.near is not None and self.near <= blocks.shape[1] // 2:
            weights, strain, size, first, reach = self._law()
            _add_blocks(self._there, weights, strain, size, self._leading, first, reach, blocks)

    def add_product(self, poses: np.ndarray, out: np.ndarray) -> None:
        """out (N, 6) += the change of the twists with a change ``poses`` (N, 6) of the poses."""
        if self._linearised_tree:
            self._linearised_tree.add_product(self._there.T, poses[:, :3].T, out)
            return
        moves = poses[self._layout.spheres, :3]
        compiled = partial(_product_kernel, self._leading)
        sharing.add(compiled, self._parallel, self._there, moves, *self._law(), out)
