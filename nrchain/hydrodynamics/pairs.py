"""v_i = Σ_j u(r_i − r_j, e_j), ω_i = Σ_j w(r_i − r_j, e_j): slip flows summed over pairs.

The sum runs over the spheres within ``reach`` places along the chain, or over all. A periodic chain
is laid out with its images on either side first (:mod:`nrchain.hydrodynamics.images`), so that
every sphere finds its neighbours in one contiguous stretch of the same arrays. Each row of the
result is written by one iteration alone: it does not depend on the number of threads.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from typing import Any, Self

import numpy as np
from numba import prange

from nrchain._compile import kernel, rename
from nrchain.hydrodynamics import sharing
from nrchain.hydrodynamics.images import Layout
from nrchain.hydrodynamics.pair_law import PairLaw, sum_changes, sum_twists

PARALLEL_PAIRS = 20_000
"""Sums over more pairs than this are shared between threads: below, starting them costs more."""

NEAR = 8
"""Furthest neighbours whose exact blocks are kept; beyond, products go through the pairs."""


def compile_sum(function: Callable[..., Any], parallel: bool, law: str = "") -> Any:
    """The compiled ``function`` of a law, with its rows shared between threads or not."""
    return kernel(rename(function, law, parallel), parallel=parallel)


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
    """Compile its derivative along a change of pose: see :meth:`SlipFlow.add_product`."""

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

    def add_blocks(sources, changes, radius, first_slot, reach, blocks):
        count, centre = blocks.shape[0], blocks.shape[1] // 2
        changes[:] = 0.0
        for i in range(count):
            me = first_slot + i
            for j in range(max(0, me - reach), min(sources.shape[1], me + reach + 1)):
                if j == me:
                    continue
                for column in range(6):
                    _set_unit_change(sources, changes, j, column, 1.0)
                    twist = sum_changes(law, sources, changes, radius, me, j, j + 1)
                    _set_unit_change(sources, changes, j, column, 0.0)
                    for row in range(6):
                        value = twist[row] if row < 3 else twist[row] / radius
                        blocks[i, centre + j - me, row, column] += value
                        if column < 3:
                            blocks[i, centre, row, column] -= value

    return compile_sum(add_blocks, False, law)


@kernel
def _set_unit_change(sources, changes, j, column, size):
    """Displace sphere j by ``size`` along x, y or z, or turn its axes about it: t × e."""
    if column < 3:
        changes[column, j] = size
        return
    k1, k2 = (column - 2) % 3, (column - 1) % 3
    for axis in range(3, changes.shape[0], 3):
        changes[axis + k1, j] = -size * sources[axis + k2, j]
        changes[axis + k2, j] = size * sources[axis + k1, j]


@kernel
def _lay_out(positions, frames, body_axes, spheres, shifts, sources):
    """The rows x, y, z and lab axes of ``sources``, slot by slot of a layout."""
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
    """The changes of those rows with ``poses``: displacements, and t × e for each axis."""
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


class SlipFlow:
    """The twists that the slip of all spheres induces, and their derivatives.

    Parameters
    ----------
    labels, strengths, axes
        One entry a mode: its label, its strengths (N,) and its body axis.
    reach
        How many places along the chain a flow is felt; None: all pairs, with every image of a
        periodic chain.
    period
        Length along x after which the chain repeats; 0 for an open chain.

    Modes whose strength vanishes on every sphere are dropped, and cost nothing.
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

    def __bool__(self) -> bool:
        return bool(self.labels)

    @property
    def strengths(self) -> np.ndarray:
        """Strengths (modes, N) of the modes that act."""
        first = self._layout.first
        return self._sources[len(self._changes) :, first : first + self.count]

    def only(self, label: str) -> Self:
        """Silence all modes but one, in place; the kernel stays the same."""
        for row, own in zip(self._sources[len(self._changes) :], self.labels, strict=True):
            if own != label:
                row[:] = 0.0
        return self

    @property
    def near(self) -> int:
        """Neighbours whose exact Jacobian blocks are kept."""
        return self.reach if self.reach <= NEAR else 0

    def _place(self, positions: np.ndarray, frames: np.ndarray) -> None:
        layout = self._layout
        _lay_out(positions, frames, self._body_axes, layout.spheres, layout.shifts, self._sources)

    def add_twists(self, positions: np.ndarray, frames: np.ndarray, twists: np.ndarray) -> None:
        """twists (N, 6) += (Σ_j u, Σ_j w) at the given poses."""
        if not self:
            return
        self._place(positions, frames)
        compiled = partial(twist_kernel, self.law.source)
        place = self.radius, self._layout.first, self.reach
        sharing.add(compiled, self._parallel, self._sources, *place, twists)

    def add_jacobian(self, positions: np.ndarray, frames: np.ndarray, blocks: np.ndarray) -> None:
        """blocks[i, w + m] += ∂(v, ω)_i / ∂(u, φ)_{i+m} of the pairs within w places.

        The block of a sphere with itself holds what those pairs contribute, no more.
        """
        if not self:
            return
        self._place(positions, frames)
        reach = min(self.reach, blocks.shape[1] // 2)
        add = block_kernel(self.law.source)
        add(self._sources, self._changes, self.radius, self._layout.first, reach, blocks)

    def add_product(self, poses: np.ndarray, twists: np.ndarray) -> None:
        """twists += the change of :meth:`add_twists` with the poses.

        ``poses`` (N, 6) is the change (u, φ) of every pose, about the poses last passed to
        :meth:`add_twists` or :meth:`add_jacobian`.
        """
        if not self:
            return
        _lay_out_changes(poses, self._layout.spheres, self._sources, self._changes)
        compiled = partial(product_kernel, self.law.source)
        place = self.radius, self._layout.first, self.reach
        sharing.add(compiled, self._parallel, self._sources, self._changes, *place, twists)
