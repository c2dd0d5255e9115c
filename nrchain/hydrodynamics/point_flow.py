"""u(x) = Σ_j u_j(x − r_j): the flow of the spheres of a chain at points of the fluid.

u_j is the exact flow about sphere j by itself: of its slip
(:meth:`~nrchain.hydrodynamics.slip_mode.SlipMode.exterior_flow`), of the force and torque on it,
and of its resistance to a strain (:mod:`nrchain.hydrodynamics.point_laws`). Flows that one sphere
reflects of another are left out, as they are in the pair laws. A tree takes the place of the direct
sum for many points and spheres.

A periodic chain acts with all its images. A few stand for the distant ones
(:mod:`nrchain.hydrodynamics.images`); how many are summed one by one grows with the distance of a
point from the chain.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from nrchain.errors import SceneError
from nrchain.hydrodynamics import sharing
from nrchain.hydrodynamics.given_slips import GivenSlip
from nrchain.hydrodynamics.images import EXACT, image_offsets
from nrchain.hydrodynamics.pair_law import PairLaw
from nrchain.hydrodynamics.point_laws import FLUID, slip_kernel, strain_kernel, wrench_kernel

BLOCK = 64
"""Points of a block of the direct sum: one thread sums them."""

CHUNK = 1 << 17
"""Most points that are summed at once: it bounds the memory."""

PARALLEL_PAIRS = 100_000
"""Sums over more pairs of a point and a sphere than this run on several threads."""

TREE_SIDE, TREE_PAIRS = 2000, 50_000_000
"""A tree sums from so many spheres and points on, and from so many pairs of both.

Measured on a crooked chain and the points of a plane through it: at an accuracy of 1e-8 the tree is
faster beyond 2e7 pairs where everything acts, and beyond 2e8 pairs for 2s alone.
"""

FARTHEST = 1000.0
"""Largest distance of a point from the axis of a periodic chain, in periods."""

SURFACE = 1e-12
"""A point so far inside a sphere, in radii, is still on its surface."""


class Spheres(NamedTuple):
    """Spheres and how they act: (N, 3) positions, (N, 3, 3) frames and what moves the fluid.

    ``slips`` are their modes, ``wrenches`` (N, 6) the force and torque of each on the fluid, and
    ``strain`` (3, 3) the symmetric gradient that they resist; zeros act as nothing. ``period`` is
    the length along x after which the chain repeats, 0 for an open chain.
    """

    positions: np.ndarray
    frames: np.ndarray
    slips: Sequence[GivenSlip]
    wrenches: np.ndarray
    strain: np.ndarray
    radius: float
    viscosity: float
    period: float = 0.0


def sum_flows(spheres: Spheres, points: np.ndarray, accuracy: float = 0.0) -> np.ndarray:
    """(u, ½ curl u) (M, 6) of the spheres at points (M, 3); NaN inside a sphere.

    ``accuracy`` is the largest error, relative to the largest flow, where a tree sums; 0 sums
    directly.
    """
    twists = np.zeros((len(points), 6))
    if not len(points):
        return twists
    spheres, points = _within_one_period(spheres, points)
    exact = _exact_images(spheres, points)
    for images in np.unique(exact):
        chosen = np.flatnonzero(exact == images)
        flow = _Sum(spheres, int(images), len(chosen), accuracy)
        for part in np.array_split(chosen, math.ceil(len(chosen) / CHUNK)):
            twists[part] = flow.at(points[part])
    twists[_inside(spheres, points)] = np.nan
    return twists


def _within_one_period(spheres: Spheres, points: np.ndarray) -> tuple[Spheres, np.ndarray]:
    """Spheres and points of a periodic chain, moved by whole periods to one interval of x."""
    if not spheres.period:
        return spheres, points
    positions, points = spheres.positions.copy(), points.copy()
    for places in (positions, points):
        places[:, 0] -= spheres.period * np.floor(places[:, 0] / spheres.period)
    order = np.argsort(positions[:, 0], kind="stable")
    moved = spheres._replace(
        positions=positions[order],
        frames=spheres.frames[order],
        wrenches=spheres.wrenches[order],
        slips=[slip._replace(strengths=slip.strengths[order]) for slip in spheres.slips],
    )
    return moved, points


def _exact_images(spheres: Spheres, points: np.ndarray) -> np.ndarray:
    """(M,) how many images on either side are summed one by one for each point.

    The flow of the p-th image is analytic in 1/p up to p = κ, the distance in periods. The
    quadrature of all beyond P has an error below 1e-12 for P + 1 ≥ 3κ. Powers of two times
    :data:`~nrchain.hydrodynamics.images.EXACT` keep the number of layouts small.
    """
    if not spheres.period:
        return np.zeros(len(points), int)
    across = spheres.positions[:, 1:]
    middle = 0.5 * (across.min(axis=0) + across.max(axis=0))
    reach = np.linalg.norm(across - middle, axis=1).max()
    distance = np.linalg.norm(points[:, 1:] - middle, axis=1) + reach
    if distance.max() > FARTHEST * spheres.period:
        allowed = (
            f"must be within {FARTHEST:g} periods of a periodic chain, whose images are summed one"
            " by one out to the distance of a point"
        )
        raise SceneError("points", f"{distance.max():.4g} from the chain", allowed)
    needed = 3.0 * np.hypot(1.0, distance / spheres.period) - 1.0
    doublings = np.ceil(np.log2(np.maximum(needed / EXACT, 1.0)) - 1e-9)
    return EXACT * (2 ** doublings.astype(int))


def _inside(spheres: Spheres, points: np.ndarray) -> np.ndarray:
    """(M,) whether each point is inside a sphere or one of its images."""
    centres = spheres.positions
    if spheres.period:
        shift = np.array([spheres.period, 0.0, 0.0])
        centres = np.concatenate([centres + k * shift for k in (-1, 0, 1)])
    distance, _ = cKDTree(centres).query(points)
    return distance < spheres.radius * (1.0 - SURFACE)


class _Sum:
    """Σ_j over the spheres and their images, for points that need so many of them."""

    def __init__(self, spheres: Spheres, images: int, points: int, accuracy: float) -> None:
        self._radius = spheres.radius
        shifts, weights = np.zeros(1), np.ones(1)
        if spheres.period:
            offsets, shares = image_offsets(images)
            half = len(offsets) // 2
            shifts = spheres.period * np.insert(offsets, half, 0.0)
            weights = np.insert(shares, half, 1.0)
        count, copies = len(spheres.positions), len(shifts)
        self._centres = np.tile(spheres.positions, (copies, 1))
        self._centres[:, 0] += np.repeat(shifts, count)
        self._weights = np.repeat(weights, count)
        self._count = len(self._centres)
        self._law, self._slip_rows = self._slip_sources(spheres, copies)
        self._wrench_rows = self._wrench_sources(spheres, copies)
        self._strain = np.ascontiguousarray(spheres.strain)
        self._parallel = self._count * points > PARALLEL_PAIRS
        self._tree: Any = None
        is_large = min(self._count, points) >= TREE_SIDE and self._count * points >= TREE_PAIRS
        if accuracy > 0.0 and is_large:
            self._tree = self._make_tree(accuracy)

    def _slip_sources(self, spheres: Spheres, copies: int) -> tuple[PairLaw, np.ndarray]:
        """The law of the modes, and their axes and strengths (rows, N): no rows without slip."""
        slips = [slip for slip in spheres.slips if np.any(slip.strengths)]
        law = PairLaw.of([s.label for s in slips], [s.axis.tolist() for s in slips], at_points=True)
        axes = [np.array(axis) @ spheres.frames for axis in law.axes]
        rows = [*(axis.T for axis in axes), *(slip.strengths[None] for slip in slips)]
        if not rows:
            return law, np.empty((0, self._count))
        table = np.tile(np.concatenate(rows), copies)
        table[3 * len(axes) :] *= self._weights
        return law, table

    def _wrench_sources(self, spheres: Spheres, copies: int) -> np.ndarray:
        """f and τ (6, N); no rows without forces and torques."""
        if not spheres.wrenches.any():
            return np.empty((0, self._count))
        a, eta = spheres.radius, spheres.viscosity
        units = np.repeat([6 * math.pi * eta * a, 8 * math.pi * eta * a**2], 3)
        return np.tile((spheres.wrenches / units).T, copies) * self._weights

    def at(self, points: np.ndarray) -> np.ndarray:
        """(u, w) (M, 6) at points (M, 3)."""
        if self._tree is None:
            return self._direct(points)
        from nrchain.hydrodynamics.tree.points import curve_order

        order = curve_order(points)
        twists, sorted_points = np.zeros((len(points), 6)), points[order]
        near = partial(self._add, sorted_points, twists)
        self._tree.add(sorted_points.T, near, twists)
        result = np.empty_like(twists)
        result[order] = twists
        return result

    def _direct(self, points: np.ndarray) -> np.ndarray:
        edges = np.append(np.arange(0, len(points), BLOCK), len(points))
        bounds = np.stack([edges[:-1], edges[1:]], axis=1)
        twists, ranges = np.zeros((len(points), 6)), np.array([[0, self._count]])
        begin = np.zeros(len(bounds) + 1, np.int64)
        # every block has the same range: its own copy of the row
        begin[:] = np.arange(len(begin))
        self._add(points, twists, bounds, begin, np.repeat(ranges, len(bounds), axis=0))
        return twists

    def _add(
        self,
        points: np.ndarray,
        twists: np.ndarray,
        bounds: np.ndarray,
        begin: np.ndarray,
        ranges: np.ndarray,
    ) -> None:
        """twists += the flow of the ranges of spheres that act on each block of points."""
        places = np.concatenate([self._centres, points])
        blocks = self._count, self._radius, bounds, begin, ranges, twists
        if len(self._slip_rows):
            compiled = partial(slip_kernel, self._law.source)
            self._run(compiled, _columns(places, self._slip_rows), *blocks)
        if len(self._wrench_rows):
            self._run(wrench_kernel, _columns(places, self._wrench_rows), *blocks)
        if self._strain.any():
            self._run(strain_kernel, places, self._weights, self._strain, *blocks)

    def _run(self, compiled: Any, *arguments: Any) -> None:
        sharing.add(compiled, self._parallel, *arguments)

    def _make_tree(self, accuracy: float) -> Any:
        """The far field of all that acts; None for a mode whose flow is no sum of multipoles."""
        from nrchain.hydrodynamics.tree.harmonics import coupling
        from nrchain.hydrodynamics.tree.moments import (
            fill_slip,
            fill_wrenches,
            slip_terms,
            strain_multipoles,
        )
        from nrchain.hydrodynamics.tree.points import PointTree

        parts = []
        if len(self._slip_rows):
            terms = slip_terms(self._law)
            if terms is None:
                return None
            own = np.empty((self._count, (terms.degree + 1) ** 2, 4))
            sources = _columns(self._centres, self._slip_rows)
            kinds = len(self._law.axes), terms.rows, terms.factors, terms.degree
            fill_slip(sources, *kinds, tuple(coupling(terms.degree)), own)
            parts.append(own)
        if len(self._wrench_rows):
            own = np.empty((self._count, 4, 4))
            fill_wrenches(_columns(self._centres, self._wrench_rows), FLUID, own)
            parts.append(own)
        if self._strain.any():
            strain = self._radius * self._strain
            # −a⁵ of the fluid in place of −(8/3)a⁵ of a sphere that feels it
            for of_one in (
                strain_multipoles(True, strain),
                3 / 8 * strain_multipoles(False, strain),
            ):
                parts.append(self._weights[:, None, None] * of_one)
        if not parts:
            return None
        total = np.zeros((self._count, max(part.shape[1] for part in parts), 4))
        for part in parts:
            total[:, : part.shape[1]] += part
        return PointTree(self._centres.T, self._radius, total, accuracy, self._parallel)


def _columns(places: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Sources (3 + rows, …): the columns of places (…, 3), and rows for the first of them."""
    table = np.zeros((3 + len(rows), len(places)))
    table[:3], table[3:, : rows.shape[1]] = places.T, rows
    return table
