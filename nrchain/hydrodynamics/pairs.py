"""v_i = Σ_j u(r_i − r_j, e_j), ω_i = Σ_j w(r_i − r_j, e_j): slip flows summed over pairs.

The sum runs over the spheres within ``reach`` places along the chain, all of them for a reach of
N − 1 or more. A periodic chain is laid out with its images on either side first, so that every
sphere finds its neighbours in one contiguous stretch of the same arrays. Each row of the result
is written by one iteration alone: it does not depend on the number of threads.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numba import prange

from nrchain._compile import kernel
from nrchain.hydrodynamics.pair_law import PairLaw, pair_derivative, pair_twist

PARALLEL_PAIRS = 20_000
"""Sums over more pairs than this are shared between threads: below, starting them costs more."""

NEAR = 8
"""Furthest neighbours whose exact blocks are kept; beyond, products go through the pairs."""


@lru_cache(maxsize=64)
def twist_kernel(law: str, parallel: bool):
    """Compile the sum of a law: see :meth:`SlipFlow.add_twists`."""

    @kernel(parallel=parallel)
    def add_twists(positions, axes, strengths, images, reach, radius, twists):
        count = twists.shape[0]
        x, y, z = positions[0], positions[1], positions[2]
        for i in prange(count):
            me = i + images
            u0 = u1 = u2 = w0 = w1 = w2 = 0.0
            for side in range(2):
                first = max(0, me - reach) if side == 0 else me + 1
                last = me if side == 0 else min(positions.shape[1], me + reach + 1)
                for j in range(first, last):
                    d0, d1, d2 = x[me] - x[j], y[me] - y[j], z[me] - z[j]
                    inverse = 1.0 / np.sqrt(d0 * d0 + d1 * d1 + d2 * d2)
                    a0, a1, a2, b0, b1, b2 = pair_twist(
                        law,
                        d0 * inverse,
                        d1 * inverse,
                        d2 * inverse,
                        radius * inverse,
                        axes,
                        strengths,
                        j,
                    )
                    u0 += a0
                    u1 += a1
                    u2 += a2
                    w0 += b0
                    w1 += b1
                    w2 += b2
            twists[i, 0] += u0
            twists[i, 1] += u1
            twists[i, 2] += u2
            twists[i, 3] += w0 / radius
            twists[i, 4] += w1 / radius
            twists[i, 5] += w2 / radius

    return add_twists


@lru_cache(maxsize=64)
def product_kernel(law: str, parallel: bool):
    """Compile the derivative of the sum along a change of pose: see :meth:`SlipFlow.add_product`."""

    @kernel(parallel=parallel)
    def add_product(
        positions, axes, strengths, shifts, turns, images, inner, reach, radius, twists
    ):
        count = twists.shape[0]
        x, y, z = positions[0], positions[1], positions[2]
        for i in prange(count):
            me = i + images
            u0 = u1 = u2 = w0 = w1 = w2 = 0.0
            for side in range(2):
                first = max(0, me - reach) if side == 0 else me + inner + 1
                last = me - inner if side == 0 else min(positions.shape[1], me + reach + 1)
                for j in range(first, last):
                    d0, d1, d2 = x[me] - x[j], y[me] - y[j], z[me] - z[j]
                    inverse = 1.0 / np.sqrt(d0 * d0 + d1 * d1 + d2 * d2)
                    a0, a1, a2, b0, b1, b2 = pair_derivative(
                        law,
                        d0 * inverse,
                        d1 * inverse,
                        d2 * inverse,
                        radius * inverse,
                        (shifts[0, me] - shifts[0, j]) * inverse,
                        (shifts[1, me] - shifts[1, j]) * inverse,
                        (shifts[2, me] - shifts[2, j]) * inverse,
                        turns[0, j],
                        turns[1, j],
                        turns[2, j],
                        axes,
                        strengths,
                        j,
                    )
                    u0 += a0
                    u1 += a1
                    u2 += a2
                    w0 += b0
                    w1 += b1
                    w2 += b2
            twists[i, 0] += u0
            twists[i, 1] += u1
            twists[i, 2] += u2
            twists[i, 3] += w0 / radius
            twists[i, 4] += w1 / radius
            twists[i, 5] += w2 / radius

    return add_product


@lru_cache(maxsize=64)
def block_kernel(law: str):
    """Compile the Jacobian blocks of near pairs: see :meth:`SlipFlow.add_jacobian`."""

    @kernel
    def add_blocks(positions, axes, strengths, images, reach, radius, blocks):
        count, centre = blocks.shape[0], blocks.shape[1] // 2
        unit = np.zeros(6)
        for i in range(count):
            me = i + images
            first, last = max(0, me - reach), min(positions.shape[1], me + reach + 1)
            for j in range(first, last):
                if j == me:
                    continue
                d0 = positions[0, me] - positions[0, j]
                d1 = positions[1, me] - positions[1, j]
                d2 = positions[2, me] - positions[2, j]
                inverse = 1.0 / np.sqrt(d0 * d0 + d1 * d1 + d2 * d2)
                for column in range(6):
                    unit[:] = 0.0
                    # moving sphere j moves the separation the other way
                    unit[column] = -inverse if column < 3 else 1.0
                    change = pair_derivative(
                        law,
                        d0 * inverse,
                        d1 * inverse,
                        d2 * inverse,
                        radius * inverse,
                        unit[0],
                        unit[1],
                        unit[2],
                        unit[3],
                        unit[4],
                        unit[5],
                        axes,
                        strengths,
                        j,
                    )
                    for row in range(6):
                        value = change[row] if row < 3 else change[row] / radius
                        blocks[i, centre + j - me, row, column] += value
                        if column < 3:
                            blocks[i, centre, row, column] -= value

    return add_blocks


@kernel
def _lay_out(positions, frames, body_axes, period, images, laid_positions, laid_axes):
    """Component-major positions and lab axes, with ``images`` periodic copies on either side."""
    count = positions.shape[0]
    for slot in range(laid_positions.shape[1]):
        image = (slot - images) // count
        sphere = slot - images - image * count
        for k in range(3):
            laid_positions[k, slot] = positions[sphere, k]
            for group in range(body_axes.shape[0]):
                laid_axes[group, k, slot] = (
                    body_axes[group, 0] * frames[sphere, 0, k]
                    + body_axes[group, 1] * frames[sphere, 1, k]
                    + body_axes[group, 2] * frames[sphere, 2, k]
                )
        laid_positions[0, slot] += image * period


@kernel
def _lay_out_poses(poses, images, shifts, turns):
    """Component-major changes of pose, with their periodic copies."""
    count = poses.shape[0]
    for slot in range(shifts.shape[1]):
        sphere = (slot - images) % count
        for k in range(3):
            shifts[k, slot] = poses[sphere, k]
            turns[k, slot] = poses[sphere, 3 + k]


class SlipFlow:
    """The twists that the slip of all spheres induces, and their derivatives.

    Parameters
    ----------
    labels, strengths, axes
        One entry a mode: its label, its strengths (N,) and its body axis.
    reach
        How many places along the chain a flow is felt; N − 1 or more on an open chain: all pairs.
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
        reach: int,
        radius: float,
        period: float = 0.0,
        finite_size: bool = False,
    ) -> None:
        active = [m for m, strength in enumerate(strengths) if np.any(strength)]
        self.labels = tuple(labels[m] for m in active)
        self.law = PairLaw.of(self.labels, [axes[m] for m in active], finite_size)
        self.count, self.radius, self.period = count, float(radius), float(period)
        self.reach = reach if period else min(reach, count - 1)
        self._images = self.reach if period else 0
        slots = count + 2 * self._images
        order = np.arange(-self._images, count + self._images) % count
        self._strengths = np.array([np.asarray(strengths[m], float)[order] for m in active])
        self._body_axes = np.array(self.law.axes, float).reshape(-1, 3)
        self._positions = np.empty((3, slots))
        self._axes = np.empty((len(self._body_axes), 3, slots))
        self._shifts, self._turns = np.empty((3, slots)), np.empty((3, slots))
        self._parallel = self.reach * count * 2 > PARALLEL_PAIRS

    def __bool__(self) -> bool:
        return bool(self.labels)

    @property
    def strengths(self) -> np.ndarray:
        """Strengths (modes, N) of the modes that act."""
        return self._strengths[:, self._images : self._images + self.count]

    @property
    def near(self) -> int:
        """Neighbours whose exact Jacobian blocks are kept."""
        return self.reach if self.reach <= NEAR else 0

    def _place(self, positions: np.ndarray, frames: np.ndarray) -> None:
        _lay_out(
            positions,
            frames,
            self._body_axes,
            self.period,
            self._images,
            self._positions,
            self._axes,
        )

    def add_twists(self, positions: np.ndarray, frames: np.ndarray, twists: np.ndarray) -> None:
        """twists (N, 6) += (Σ_j u, Σ_j w) at the given poses."""
        self._place(positions, frames)
        twist_kernel(self.law.source, self._parallel)(
            self._positions,
            self._axes,
            self._strengths,
            self._images,
            self.reach,
            self.radius,
            twists,
        )

    def add_jacobian(self, positions: np.ndarray, frames: np.ndarray, blocks: np.ndarray) -> None:
        """blocks[i, w + m] += ∂(v, ω)_i / ∂(u, φ)_{i+m} of the pairs within w places.

        The block of a sphere with itself holds what those pairs contribute, no more.
        """
        self._place(positions, frames)
        block_kernel(self.law.source)(
            self._positions,
            self._axes,
            self._strengths,
            self._images,
            min(self.reach, blocks.shape[1] // 2),
            self.radius,
            blocks,
        )

    def add_product(self, poses: np.ndarray, inner: int, twists: np.ndarray) -> None:
        """twists += the change of the flow of pairs more than ``inner`` places apart.

        ``poses`` (N, 6) is the change (u, φ) of every pose, about the poses last passed to
        :meth:`add_twists` or :meth:`add_jacobian`.
        """
        _lay_out_poses(poses, self._images, self._shifts, self._turns)
        product_kernel(self.law.source, self._parallel)(
            self._positions,
            self._axes,
            self._strengths,
            self._shifts,
            self._turns,
            self._images,
            inner,
            self.reach,
            self.radius,
            twists,
        )
