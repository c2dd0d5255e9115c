"""Σ_j u(x − x_j) at any points: multipoles of intervals of the chain, and intervals of the points.

The chain has its tree (:mod:`nrchain.hydrodynamics.tree.intervals`), and points sorted along a
space-filling curve have one of the same form. Intervals of the chain act on far intervals of the
points by multipoles, and pairs of near leaves sphere by sphere.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nrchain.hydrodynamics import sharing
from nrchain.hydrodynamics.tree.accuracy import far_ratios, highest_degree
from nrchain.hydrodynamics.tree.far_field import LEAF
from nrchain.hydrodynamics.tree.harmonics import coupling
from nrchain.hydrodynamics.tree.intervals import fill_balls, interval_bounds, lists_between
from nrchain.hydrodynamics.tree.passes import (
    POTENTIALS,
    across_kernel,
    flow_kernel,
    gather_kernel,
    lower_kernel,
    raise_kernel,
)

GAP = 1.0
"""Least distance between a sphere and a far point, in radii: the point is outside the sphere."""

MARGIN = 1000.0
"""How much more accurate multipoles are than sums. Their degrees are fitted to sums at spheres, in
which near pairs count most; points may all be far from a chain, where the flow is small."""

DEPTH = 20
"""Bits of each coordinate in the order of points."""

AddNear = Callable[[np.ndarray, np.ndarray, np.ndarray], None]
"""Adds the flow of near spheres: bounds of the blocks of points, begin of their ranges, ranges."""


class PointTree:
    """The far field of spheres, from the multipoles of each about its own centre.

    Parameters
    ----------
    centres
        (3, N), in the order of the chain.
    radius
        a.
    own
        (N, (own degree + 1)², 4) multipoles (:mod:`nrchain.hydrodynamics.tree.moments`).
    accuracy
        Largest error of the sum, relative to its largest value.
    parallel
        Whether sums run on several threads.
    """

    def __init__(
        self, centres: np.ndarray, radius: float, own: np.ndarray, accuracy: float, parallel: bool
    ) -> None:
        own_degree = int(np.sqrt(own.shape[1])) - 1
        self._radius, self._parallel = radius, parallel
        accuracy = accuracy / MARGIN
        self._degree = highest_degree(accuracy, own_degree)
        self._ratios = far_ratios(accuracy, self._degree, own_degree)
        self._table = tuple(coupling(self._degree))
        self._bounds, self._balls, points = self._intervals(centres)
        shape = len(self._bounds), (self._degree + 1) ** 2, POTENTIALS
        self._multipoles = np.zeros(shape)
        tree = self._bounds, self._balls, self._degree, self._table
        self._run(gather_kernel, points, own, 0, *tree, self._multipoles)
        self._run(raise_kernel, *tree[1:], self._multipoles)

    def _intervals(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The bounds and balls of the intervals of points (3, n), and the points in radii."""
        points = np.ascontiguousarray(points) / self._radius
        bounds = interval_bounds(points.shape[1], LEAF * self._degree)
        balls = np.zeros((len(bounds), 4))
        fill_balls(points, bounds, balls)
        return bounds, balls, points

    def add(self, points: np.ndarray, add_near: AddNear, twists: np.ndarray) -> None:
        """twists (M, 6) += (u, w) at points (3, M), in the order of :func:`curve_order`."""
        bounds, own_balls, points = self._intervals(points)
        balls, spheres = np.concatenate([self._balls, own_balls]), len(self._balls)
        lists = lists_between(self._bounds, balls, self._ratios, GAP)
        locals_ = np.empty((len(balls), (self._degree + 1) ** 2, POTENTIALS))
        shifts = self._degree, self._table
        far = lists.far_begin, lists.far
        self._run(across_kernel, balls, *far, *shifts, self._multipoles, locals_)
        at_points = locals_[spheres:]
        self._run(lower_kernel, own_balls, *shifts, at_points)
        tree = bounds, own_balls, *shifts
        self._run(flow_kernel, points, *tree, at_points, self._radius, twists)
        leaves = len(bounds) // 2
        add_near(bounds[leaves:], lists.near_begin[spheres + leaves :], lists.near)

    def _run(self, compiled: Any, *arguments: Any) -> None:
        sharing.add(compiled, self._parallel, *arguments)


def curve_order(points: np.ndarray) -> np.ndarray:
    """The order of points (M, 3) along Morton's curve, on which neighbours are near in space."""
    least, most = points.min(axis=0), points.max(axis=0)
    size = float((most - least).max()) or 1.0
    cells = ((points - least) / size * (2**DEPTH - 1)).astype(np.int64)
    key = np.zeros(len(points), np.int64)
    for bit in range(DEPTH):
        for k in range(3):
            key |= ((cells[:, k] >> bit) & 1) << (3 * bit + k)
    return np.argsort(key, kind="stable")
