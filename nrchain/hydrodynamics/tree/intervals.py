"""Halves of halves of the index of a chain, and which of them are far apart: (r + r′)/D < ρ_p.

The intervals form a binary tree: number 1 is the whole chain, the halves of interval i are 2i and
2i + 1, and at the last level are the leaves. An interval has the ball of its spheres, with centre c
and radius r. Two intervals whose balls are far apart in space act on each other by multipoles, of
the lowest degree p that is accurate enough at their distance D. Two leaves that are not far apart
act by their pairs. Every pair of spheres is in exactly one such pair of intervals, whatever way the
chain folds.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nrchain._compile import kernel

GAP = 2.0
"""Least distance between the spheres of far intervals, in radii: they do not overlap."""


GROUP = 16
"""Intervals whose far sources are taken together, so that lanes are full."""


class Lists(NamedTuple):
    """Which intervals are far from each other, and which spheres are near each leaf.

    ``far`` has rows (target, source, degree). Those of :data:`GROUP` successive targets are
    ``far_begin[g]`` to ``far_begin[g + 1]``, the lowest degree first. ``near`` has the first sphere
    and the end of contiguous ranges; those of interval i are ``near_begin[i]`` to
    ``near_begin[i + 1]``.
    """

    far_begin: np.ndarray
    far: np.ndarray
    near_begin: np.ndarray
    near: np.ndarray


def interval_bounds(count: int, leaf: int) -> np.ndarray:
    """First sphere and end of each interval, (2 leaves, 2); row 0 is not used.

    Leaves have at most ``leaf`` spheres, and more than half as many.
    """
    levels = 0
    while count > leaf << levels:
        levels += 1
    bounds = np.zeros((2 << levels, 2), np.int64)
    for level in range(levels + 1):
        edges = (np.arange((1 << level) + 1) * count) >> level
        bounds[1 << level : 2 << level] = np.stack([edges[:-1], edges[1:]], axis=1)
    return bounds


@kernel
def fill_balls(points, bounds, balls):
    """balls[i] = (c, r): the centre of the bounding box of interval i, and the farthest sphere."""
    for i in range(1, bounds.shape[0]):
        first, last = bounds[i]
        for k in range(3):
            least = most = points[k, first]
            for j in range(first + 1, last):
                least, most = min(least, points[k, j]), max(most, points[k, j])
            balls[i, k] = 0.5 * (least + most)
        square = nothing = 0.0
        for j in range(first, last):
            x, y = points[0, j] - balls[i, 0], points[1, j] - balls[i, 1]
            z = points[2, j] - balls[i, 2]
            s = x * x + y * y + z * z
            square = max(square, s)
            # the radius is no number if a position is none: such an interval is near all
            nothing += 0.0 * s
        balls[i, 3] = np.sqrt(square) + nothing


@kernel
def _degree(balls, i, j, ratios, gap):
    """The lowest degree at which intervals i and j are far apart; 0 if they are near."""
    x, y, z = balls[i, 0] - balls[j, 0], balls[i, 1] - balls[j, 1], balls[i, 2] - balls[j, 2]
    distance, size = np.sqrt(x * x + y * y + z * z), balls[i, 3] + balls[j, 3]
    if not distance - size > gap:
        return 0
    for degree in range(1, ratios.shape[0]):
        if size < ratios[degree] * distance:
            return degree
    return 0


@kernel
def _pairs(balls, ratios, gap):
    """Rows (i, j, degree) of far pairs and, with degree 0, of near leaves; each pair once."""
    leaves = balls.shape[0] // 2
    found, size = np.empty((64 * leaves, 3), np.int32), 0
    stack, top = np.empty((4096, 2), np.int32), 1
    stack[0] = 1
    while top:
        top -= 1
        i, j = stack[top]
        degree = 0 if i == j else _degree(balls, i, j, ratios, gap)
        if degree or (i >= leaves and j >= leaves):
            if size == found.shape[0]:
                grown = np.empty((2 * size, 3), np.int32)
                grown[:size] = found
                found = grown
            found[size, 0], found[size, 1], found[size, 2] = i, j, degree
            size += 1
        elif i == j:
            for a, b in ((2 * i, 2 * i), (2 * i, 2 * i + 1), (2 * i + 1, 2 * i + 1)):
                stack[top, 0], stack[top, 1] = a, b
                top += 1
        else:
            if j >= leaves or (i < leaves and balls[i, 3] > balls[j, 3]):
                i, j = j, i
            for half in range(2):
                stack[top, 0], stack[top, 1] = i, 2 * j + half
                top += 1
    return found[:size]


@kernel
def _sorted_by(rows, keys, most):
    """The rows in the order of their keys 0 … most, and where each key begins; stable."""
    begin = np.zeros(most + 2, np.int64)
    for key in keys:
        begin[key + 1] += 1
    begin = np.cumsum(begin)
    place, found = begin.copy(), np.empty_like(rows)
    for at in range(rows.shape[0]):
        found[place[keys[at]]] = rows[at]
        place[keys[at]] += 1
    return begin, found


@kernel
def _both_ways(pairs):
    """The rows (i, j, degree) and (j, i, degree), each interval with itself once."""
    rows, size = np.empty((2 * pairs.shape[0], 3), np.int32), 0
    for i, j, degree in pairs:
        rows[size, 0], rows[size, 1], rows[size, 2] = i, j, degree
        size += 1
        if i != j:
            rows[size, 0], rows[size, 1], rows[size, 2] = j, i, degree
            size += 1
    return rows[:size]


@kernel
def _ranges(begin, rows, bounds):
    """Near leaves, sorted by target and source, as contiguous ranges of spheres."""
    starts, ranges, size = np.zeros_like(begin), np.empty((rows.shape[0], 2), np.int64), 0
    for i in range(begin.shape[0] - 1):
        starts[i] = size
        for at in range(begin[i], begin[i + 1]):
            first, last = bounds[rows[at, 1]]
            if size > starts[i] and ranges[size - 1, 1] == first:
                ranges[size - 1, 1] = last
            else:
                ranges[size, 0], ranges[size, 1] = first, last
                size += 1
    starts[-1] = size
    return starts, ranges[:size]


@kernel
def _pairs_between(spheres, balls, ratios, gap):
    """Rows (i, j, degree) as of :func:`_pairs`: i among the points, j among the spheres.

    The balls of the ``spheres`` intervals of a chain come first, then those of the points.
    """
    sphere_leaves, point_leaves = spheres // 2, spheres + (balls.shape[0] - spheres) // 2
    found, size = np.empty((64 * sphere_leaves, 3), np.int32), 0
    stack, top = np.empty((4096, 2), np.int32), 1
    stack[0, 0], stack[0, 1] = spheres + 1, 1
    while top:
        top -= 1
        i, j = stack[top]
        degree = _degree(balls, i, j, ratios, gap)
        if degree or (i >= point_leaves and j >= sphere_leaves):
            if size == found.shape[0]:
                grown = np.empty((2 * size, 3), np.int32)
                grown[:size] = found
                found = grown
            found[size, 0], found[size, 1], found[size, 2] = i, j, degree
            size += 1
            continue
        halve_points = j >= sphere_leaves or (i < point_leaves and balls[i, 3] > balls[j, 3])
        for half in range(2):
            if halve_points:
                stack[top, 0], stack[top, 1] = spheres + 2 * (i - spheres) + half, j
            else:
                stack[top, 0], stack[top, 1] = i, 2 * j + half
            top += 1
    return found[:size]


@kernel
def _lists_between(bounds, balls, ratios, gap):
    return _listed(_pairs_between(bounds.shape[0], balls, ratios, gap), bounds, balls, ratios)


@kernel
def _lists(bounds, balls, ratios, gap):
    return _listed(_both_ways(_pairs(balls, ratios, gap)), bounds, balls, ratios)


@kernel
def _listed(rows, bounds, balls, ratios):
    """The lists of rows (target, source, degree)."""
    nodes = balls.shape[0]
    far, near = rows[rows[:, 2] > 0], rows[rows[:, 2] == 0]
    _, far = _sorted_by(far, far[:, 2], ratios.shape[0])
    far_begin, far = _sorted_by(far, far[:, 0] // GROUP, (nodes - 1) // GROUP)
    _, near = _sorted_by(near, near[:, 1], nodes - 1)
    near_begin, near = _sorted_by(near, near[:, 0], nodes - 1)
    near_begin, near = _ranges(near_begin, near, bounds)
    return far_begin, far, near_begin, near


def interval_lists(bounds: np.ndarray, balls: np.ndarray, ratios: np.ndarray, gap: float) -> Lists:
    """Which intervals act on each by multipoles, and which spheres on each leaf by their pairs.

    ``ratios[p]`` is the largest (r + r′)/D at which multipoles of degree p are accurate enough,
    increasing with p. Centres closer than their radii and ``gap`` are near whatever the ratios.
    """
    return Lists(*_lists(bounds, balls, ratios, gap))


def lists_between(bounds: np.ndarray, balls: np.ndarray, ratios: np.ndarray, gap: float) -> Lists:
    """Which intervals of a chain act on intervals of points, as :func:`interval_lists` says it.

    ``bounds`` are those of the chain. ``balls`` has those of the chain first and those of the
    points after them, and their places number the intervals of both.
    """
    return Lists(*_lists_between(bounds, balls, ratios, gap))
