"""v_i = Σ_j u(r_i − r_j, e_j), ω_i = Σ_j w(r_i − r_j, e_j): slip flows summed over pairs.

The sum runs over up to ``reach`` neighbours on either side, or over all spheres. The images of a
periodic chain are first laid out beside it (:mod:`nrchain.hydrodynamics.images`), so that the
neighbours of a sphere are contiguous in the arrays. One iteration writes each row of the result:
it does not depend on the number of threads.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache, partial
from typing import Any, Self

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
from nrchain.hydrodynamics.images import Layout
from nrchain.hydrodynamics.pair_law import PairLaw, set_derivative, sum_changes, sum_twists
from nrchain.hydrodynamics.sharing import PARALLEL_PAIRS, compile_sum
from nrchain.hydrodynamics.tree.choice import slip_tree

NEAR = 8
"""Largest reach for which exact Jacobian blocks are kept. Beyond it products sum over pairs."""


@lru_cache(maxsize=64)
def twist_kernel(law: str, parallel: bool):
    """Compile the sum of a law: see :meth:`SlipFlow.add_twists`."""

    def add_twists(sources, radius, first_slot, reach, twists):
        for i in prange(twists.shape[0]):
            me = first_slot + i
            first, last = max(0, me - reach), min(sources.shape[1], me + reach + 1)
            before = sum_twists(law, sources, radius, me, first, me)
            after = sum_twists(law, sources, radius, me, me + 1, last)
            for k in range(3):
                twists[i, k] += before[k] + after[k]
                twists[i, 3 + k] += (before[3 + k] + after[3 + k]) / radius

    return compile_sum(add_twists, parallel, law)


@lru_cache(maxsize=64)
def product_kernel(law: str, parallel: bool):
    """Compile the derivative of the sum along a change of poses: :meth:`SlipFlow.add_product`."""

    def add_product(sources, changes, radius, first_slot, reach, twists):
        for i in prange(twists.shape[0]):
            me = first_slot + i
            first, last = max(0, me - reach), min(sources.shape[1], me + reach + 1)
            before = sum_changes(law, sources, changes, radius, me, first, me)
            after = sum_changes(law, sources, changes, radius, me, me + 1, last)
            for k in range(3):
                twists[i, k] += before[k] + after[k]
                twists[i, 3 + k] += (before[3 + k] + after[3 + k]) / radius

    return compile_sum(add_product, parallel, law)


@lru_cache(maxsize=64)
def block_kernel(law: str):
    """Compile the Jacobian blocks of near pairs: see :meth:`SlipFlow.add_jacobian`."""

    def add_blocks(sources, radius, first_slot, reach, blocks):
        count, centre = blocks.shape[0], blocks.shape[1] // 2
        change = np.empty((6, 6))
        for i in range(count):
            me = first_slot + i
            for j in range(max(0, me - reach), min(sources.shape[1], me + reach + 1)):
                if j == me:
                    continue
                m = centre + j - me
                set_derivative(law, sources, radius, me, j, change)
                for row in range(6):
                    for k in range(3):
                        blocks[i, centre, row, k] += change[row, k]
                        blocks[i, m, row, k] -= change[row, k]
                        blocks[i, m, row, 3 + k] += change[row, 3 + k]

    return compile_sum(add_blocks, False, law)


@kernel
def _lay_out(positions, frames, body_axes, spheres, shifts, sources):
    """Fill the rows x, y, z and lab axes of ``sources``, slot by slot of a layout."""
    for slot in range(spheres.shape[0]):
        sphere = spheres[slot]
        for k in range(3):
            sources[k, slot] = positions[sphere, k]
            for axis in range(body_axes.shape[0]):
                sources[3 + 3 * axis + k, slot] = (
                    body_axes[axis, 0] * frames[sphere, 0, k]
                    + body_axes[axis, 1] * frames[sphere, 1, k]
                    + body_axes[axis, 2] * frames[sphere, 2, k]
                )
        sources[0, slot] += shifts[slot]


@kernel
def _lay_out_changes(poses, spheres, sources, changes):
    """Fill their changes with ``poses``: displacements, and φ × e for each axis."""
    for slot in range(spheres.shape[0]):
        sphere = spheres[slot]
        for k in range(3):
            changes[k, slot] = poses[sphere, k]
            k1, k2 = (k + 1) % 3, (k + 2) % 3
            for axis in range(3, changes.shape[0], 3):
                changes[axis + k, slot] = (
                    poses[sphere, 3 + k1] * sources[axis + k2, slot]
                    - poses[sphere, 3 + k2] * sources[axis + k1, slot]
                )


@part
def _sources_at(table, positions, frames):
    """Lay out the sources of a term at these poses; return them."""
    n, sources = vector_in(table, 4, integers_at)[0], matrix_in(table, 0, floats_at)
    _lay_out(
        carray(floats_at(positions), (n, 3)),
        carray(floats_at(frames), (n, 3, 3)),
        matrix_in(table, 1, floats_at),
        vector_in(table, 2, integers_at),
        vector_in(table, 3, floats_at),
        sources,
    )
    return sources


add: Any = None
"""The kernel of a term: :func:`compile_term` puts that of a law in its place."""


def _add_twists(context, positions, frames, out, width):
    """The term of :meth:`SlipFlow.add_twists`."""
    table = carray(integers_at(context), (6, ROW))
    sources, place = _sources_at(table, positions, frames), vector_in(table, 4, integers_at)
    radius = vector_in(table, 5, floats_at)[0]
    add(sources, radius, place[1], place[2], carray(floats_at(out), (place[0], 6)))
    return 0


def _add_blocks(context, positions, frames, out, width):
    """The term of :meth:`SlipFlow.add_jacobian`."""
    table = carray(integers_at(context), (6, ROW))
    sources, place = _sources_at(table, positions, frames), vector_in(table, 4, integers_at)
    radius = vector_in(table, 5, floats_at)[0]
    blocks = carray(floats_at(out), (place[0], 2 * width + 1, 6, 6))
    add(sources, radius, place[1], min(place[2], width), blocks)
    return 0


class SlipFlow:
    """(v, ω)_i = Σ_j (u, w)(r_i − r_j, e_j): the twists that slip induces, and their derivatives.

    Parameters
    ----------
    labels, strengths, axes
        For each mode its label, its strengths (N,) and its body axis.
    count
        Number of spheres N.
    reach
        Neighbours on either side whose flow counts; None: all pairs, with every image of a
        periodic chain.
    period
        Length along x after which the chain repeats; 0 for an open chain.
    finite_size
        Whether flows include the finite size of both spheres.
    accuracy
        Largest error of the sum over all pairs of a long open chain, relative to its largest value:
        a tree then takes the place of the direct sum where that is faster. 0 keeps the direct sum.

    Positions are (N, 3) and frames (N, 3, 3), in the lab. Modes of zero strength are left out of
    the compiled sum.
    """

    def __init__(
        self,
        labels: Sequence[str],
        strengths: Sequence[np.ndarray],
        axes: Sequence[Sequence[float]],
        *,
        count: int,
        reach: int | None,
        radius: float,
        period: float = 0.0,
        finite_size: bool = False,
        accuracy: float = 0.0,
    ) -> None:
        active = [m for m, strength in enumerate(strengths) if np.any(strength)]
        self.labels = tuple(labels[m] for m in active)
        self.law = PairLaw.of(self.labels, [axes[m] for m in active], finite_size)
        self.count, self.radius, self.period = count, float(radius), float(period)
        self._layout = Layout.of(count, reach, period)
        self.reach = self._layout.reach
        self._body_axes = np.array(self.law.axes, float).reshape(-1, 3)
        geometry, slots = 3 + self._body_axes.size, len(self._layout.spheres)
        self._sources = np.zeros((geometry + len(active), slots))
        self._changes = np.zeros((geometry, slots))
        for row, m in zip(self._sources[geometry:], active, strict=True):
            row[:] = self._layout.weights * np.asarray(strengths[m], float)[self._layout.spheres]
        self._parallel = 2 * self.reach * count > PARALLEL_PAIRS
        self.tree = slip_tree(self.law, self._layout, self.radius, accuracy)

    def __bool__(self) -> bool:
        return bool(self.labels)

    @property
    def strengths(self) -> np.ndarray:
        """Strengths (modes, N) of the modes that are not zero."""
        first = self._layout.first
        return self._sources[len(self._changes) :, first : first + self.count]

    def only(self, label: str) -> Self:
        """Set the strengths of all other modes to zero, in place; the kernel stays the same."""
        for row, own in zip(self._sources[len(self._changes) :], self.labels, strict=True):
            if own != label:
                row[:] = 0.0
        return self

    @property
    def near(self) -> int:
        """Neighbours with exact Jacobian blocks; 0 if only :meth:`add_product` is exact."""
        return self.reach if self.reach <= NEAR else 0

    def _place(self, positions: np.ndarray, frames: np.ndarray) -> None:
        layout = self._layout
        _lay_out(positions, frames, self._body_axes, layout.spheres, layout.shifts, self._sources)
        if self.tree:
            self.tree.move()

    def add_twists(self, positions: np.ndarray, frames: np.ndarray, twists: np.ndarray) -> None:
        """twists (N, 6) += (Σ_j u, Σ_j w) at the given poses."""
        if not self:
            return
        self._place(positions, frames)
        if self.tree:
            self.tree.add_twists(self._sources, twists)
            return
        compiled = partial(twist_kernel, self.law.source)
        place = self.radius, self._layout.first, self.reach
        sharing.add(compiled, self._parallel, self._sources, *place, twists)

    def direct_twists(self, spheres: Sequence[int] | np.ndarray) -> np.ndarray:
        """(Σ_j u, Σ_j w) (n, 6) of some spheres by the direct sum, at the last poses."""
        rows, add = np.zeros((len(spheres), 6)), twist_kernel(self.law.source, False)
        for row, sphere in zip(rows, spheres, strict=True):
            place = self.radius, self._layout.first + sphere, self.reach
            add(self._sources, *place, row[None])
        return rows

    def term(self) -> Term | None:
        """The flows as a term by address, with sources of its own.

        None for sums on several threads, or by a tree.
        """
        if self._parallel or self.tree:
            return None
        source, layout = self.law.source, self._layout
        entries = (
            compile_term(_add_twists, add=twist_kernel(source, False)),
            compile_term(_add_blocks, add=block_kernel(source)),
        )
        arrays = (
            self._sources.copy(),
            self._body_axes,
            np.ascontiguousarray(layout.spheres, np.int64),
            np.ascontiguousarray(layout.shifts, float),
            np.array([self.count, layout.first, self.reach]),
            np.array([self.radius]),
        )
        context = table_of(arrays)
        return Term(entries[0].address, entries[1].address, context, (*arrays, *entries))

    def add_jacobian(self, positions: np.ndarray, frames: np.ndarray, blocks: np.ndarray) -> None:
        """blocks[i, w + m] += ∂(v, ω)_i / ∂(u, φ)_{i+m}, summed over up to w neighbours.

        The diagonal block of a sphere is the sum over the same pairs.
        """
        if not self:
            return
        self._place(positions, frames)
        reach = min(self.reach, blocks.shape[1] // 2)
        add = block_kernel(self.law.source)
        add(self._sources, self.radius, self._layout.first, reach, blocks)

    def add_product(self, poses: np.ndarray, twists: np.ndarray) -> None:
        """twists += the change of :meth:`add_twists` with the poses.

        ``poses`` (N, 6) is the change (u, φ) of every pose: displacement and rotation in the lab,
        about the poses last passed to :meth:`add_twists` or :meth:`add_jacobian`.
        """
        if not self:
            return
        _lay_out_changes(poses, self._layout.spheres, self._sources, self._changes)
        if self.tree:
            self.tree.add_product(self._sources, self._changes, twists)
            return
        compiled = partial(product_kernel, self.law.source)
        place = self.radius, self._layout.first, self.reach
        sharing.add(compiled, self._parallel, self._sources, self._changes, *place, twists)
