"""Sums over the near pairs of a tree: each sphere with the ranges that act on its leaf."""

from __future__ import annotations

from functools import cache, lru_cache

from numba import prange

from nrchain._compile import kernel
from nrchain.hydrodynamics import pair_law, rotne_prager
from nrchain.hydrodynamics.disturbance_law import (
    add_finite_size,
    add_finite_size_change,
    add_stresslet,
    add_stresslet_change,
    between,
)
from nrchain.hydrodynamics.sharing import compile_sum


@kernel
def _within(place, first, last):
    """The place, or the end of first … last that is nearest."""
    return min(max(first, place), last)


@lru_cache(maxsize=64)
def slip_kernel(law: str, parallel: bool):
    """Compile twists (N, 6) += the slip flows of near spheres."""

    def add_near_slip(sources, radius, bounds, begin, ranges, twists):
        leaves = bounds.shape[0] // 2
        for leaf in prange(leaves):
            i = leaves + leaf
            for me in range(bounds[i, 0], bounds[i, 1]):
                for at in range(begin[i], begin[i + 1]):
                    first, last = ranges[at]
                    end, start = _within(me, first, last), _within(me + 1, first, last)
                    before = pair_law.sum_twists(law, sources, radius, me, first, end)
                    after = pair_law.sum_twists(law, sources, radius, me, start, last)
                    for k in range(3):
                        twists[me, k] += before[k] + after[k]
                        twists[me, 3 + k] += (before[3 + k] + after[3 + k]) / radius

    return compile_sum(add_near_slip, parallel, law)


@lru_cache(maxsize=64)
def slip_product_kernel(law: str, parallel: bool):
    """Compile the change of the slip flows of near spheres."""

    def add_near_slip_product(sources, changes, radius, bounds, begin, ranges, twists):
        leaves = bounds.shape[0] // 2
        for leaf in prange(leaves):
            i = leaves + leaf
            for me in range(bounds[i, 0], bounds[i, 1]):
                for at in range(begin[i], begin[i + 1]):
                    first, last = ranges[at]
                    end, start = _within(me, first, last), _within(me + 1, first, last)
                    before = pair_law.sum_changes(law, sources, changes, radius, me, first, end)
                    after = pair_law.sum_changes(law, sources, changes, radius, me, start, last)
                    for k in range(3):
                        twists[me, k] += before[k] + after[k]
                        twists[me, 3 + k] += (before[3 + k] + after[3 + k]) / radius

    return compile_sum(add_near_slip_product, parallel, law)


@cache
def friction_kernel(parallel: bool):
    """Compile twists (N, 6) += μ·W of each sphere by itself and with near ones."""

    def add_near_friction(sources, radius, bounds, begin, ranges, twists):
        leaves = bounds.shape[0] // 2
        for leaf in prange(leaves):
            i = leaves + leaf
            for me in range(bounds[i, 0], bounds[i, 1]):
                for k in range(3):
                    twists[me, k] += sources[3 + k, me]
                    twists[me, 3 + k] += sources[6 + k, me] / radius
                for at in range(begin[i], begin[i + 1]):
                    first, last = ranges[at]
                    end, start = _within(me, first, last), _within(me + 1, first, last)
                    before = rotne_prager.sum_twists(sources, radius, me, first, end)
                    after = rotne_prager.sum_twists(sources, radius, me, start, last)
                    for k in range(3):
                        twists[me, k] += before[k] + after[k]
                        twists[me, 3 + k] += (before[3 + k] + after[3 + k]) / radius

    return compile_sum(add_near_friction, parallel)


@cache
def friction_product_kernel(parallel: bool):
    """Compile the change of μ·W of each sphere by itself and with near ones."""

    def add_near_friction_product(sources, changes, radius, bounds, begin, ranges, twists):
        leaves = bounds.shape[0] // 2
        for leaf in prange(leaves):
            i = leaves + leaf
            for me in range(bounds[i, 0], bounds[i, 1]):
                for k in range(3):
                    twists[me, k] += changes[3 + k, me]
                    twists[me, 3 + k] += changes[6 + k, me] / radius
                for at in range(begin[i], begin[i + 1]):
                    first, last = ranges[at]
                    end, start = _within(me, first, last), _within(me + 1, first, last)
                    before = rotne_prager.sum_changes(sources, changes, radius, me, first, end)
                    after = rotne_prager.sum_changes(sources, changes, radius, me, start, last)
                    for k in range(3):
                        twists[me, k] += before[k] + after[k]
                        twists[me, 3 + k] += (before[3 + k] + after[3 + k]) / radius

    return compile_sum(add_near_friction_product, parallel)


@cache
def disturbance_kernel(leading: bool, parallel: bool):
    """Compile twists (N, 6) += the disturbance of a strain by near spheres."""

    def add_near_disturbance(points, strain, size, bounds, begin, ranges, twists):
        leaves = bounds.shape[0] // 2
        for leaf in prange(leaves):
            i = leaves + leaf
            for me in range(bounds[i, 0], bounds[i, 1]):
                for at in range(begin[i], begin[i + 1]):
                    for j in range(ranges[at, 0], ranges[at, 1]):
                        if j == me:
                            continue
                        x = between(points, me, j)
                        if leading:
                            add_stresslet(x, strain, -size, twists[me])
                        else:
                            add_finite_size(x, strain, -size, twists[me])

    return compile_sum(add_near_disturbance, parallel, str(leading))


@cache
def disturbance_product_kernel(leading: bool, parallel: bool):
    """Compile the change of the disturbance by near spheres."""

    def add_near_disturbance_product(points, moves, strain, size, bounds, begin, ranges, twists):
        leaves = bounds.shape[0] // 2
        for leaf in prange(leaves):
            i = leaves + leaf
            for me in range(bounds[i, 0], bounds[i, 1]):
                for at in range(begin[i], begin[i + 1]):
                    for j in range(ranges[at, 0], ranges[at, 1]):
                        if j == me:
                            continue
                        x, dx = between(points, me, j), between(moves, me, j)
                        if leading:
                            add_stresslet_change(x, dx, strain, -size, twists[me])
                        else:
                            add_finite_size_change(x, dx, strain, -size, twists[me])

    return compile_sum(add_near_disturbance_product, parallel, str(leading))
