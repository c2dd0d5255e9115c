"""u = ¾s (f + n n·f) + ¼s³ (f − 3n n·f) + s² τ × n: the flow of spheres at points of the fluid.

This is the exact flow about one sphere of radius a that moves under a force and a torque, with
s = a/r, n the unit vector from its centre, f = F/6πηa and τ = T/8πηa²: a Stokeslet with the factor
(1 + a²∇²/6), and a rotlet. Half its curl is a w = ¾s² f × n − ½s³ (τ − 3n n·τ). Two spheres feel
this flow with Faxén's factor (1 + a²∇²/6), which makes it the mobility of Rotne, Prager and
Yamakawa (:mod:`nrchain.hydrodynamics.rotne_prager`).

Kernels take points as further columns of the sources, after the last sphere. One iteration writes
the rows of a block of points.

Source: S. Kim and S. J. Karrila, *Microhydrodynamics*, chapter 3.
"""

from __future__ import annotations

from functools import cache, lru_cache
from typing import Any

import numpy as np
from numba import prange

from nrchain._compile import kernel
from nrchain.hydrodynamics import pair_law
from nrchain.hydrodynamics.disturbance_law import add_finite_size, add_stresslet, between
from nrchain.hydrodynamics.rotne_prager import apply_pair
from nrchain.hydrodynamics.sharing import compile_sum

FLUID = 0.25
"""The factor of f·x/ρ³ in ψ for the flow of a force at a point of the fluid."""


@kernel(alone=True)
def sum_wrench_flows(sources, radius, me, first, last):
    """Σ_j (u, a w) at column ``me``, over 0 ≤ first ≤ j < last; rows of ``sources``: r, f and τ."""
    v0 = v1 = v2 = w0 = w1 = w2 = 0.0
    for j in range(np.uint64(first), np.uint64(last)):
        x0, x1 = sources[0, me] - sources[0, j], sources[1, me] - sources[1, j]
        x2 = sources[2, me] - sources[2, j]
        inverse = 1.0 / np.sqrt(x0 * x0 + x1 * x1 + x2 * x2)
        n, s = (x0 * inverse, x1 * inverse, x2 * inverse), radius * inverse
        s2 = s * s
        s3 = s2 * s
        f = (sources[3, j], sources[4, j], sources[5, j])
        t = (sources[6, j], sources[7, j], sources[8, j])
        v = apply_pair(0.75 * s + 0.25 * s3, 0.75 * s - 0.75 * s3, s2, n, f, t)
        w = apply_pair(-0.5 * s3, 1.5 * s3, 0.75 * s2, n, t, f)
        v0, v1, v2 = v0 + v[0], v1 + v[1], v2 + v[2]
        w0, w1, w2 = w0 + w[0], w1 + w[1], w2 + w[2]
    return v0, v1, v2, w0, w1, w2


@lru_cache(maxsize=64)
def slip_kernel(law: str, parallel: bool) -> Any:
    """Compile twists (M, 6) += (u, w) of the slip of the ranges of spheres near each block."""

    def add_slip_flow(sources, count, radius, bounds, begin, ranges, twists):
        for block in prange(bounds.shape[0]):
            for m in range(bounds[block, 0], bounds[block, 1]):
                for at in range(begin[block], begin[block + 1]):
                    first, last = ranges[at]
                    flow = pair_law.sum_twists(law, sources, radius, count + m, first, last)
                    for k in range(3):
                        twists[m, k] += flow[k]
                        twists[m, 3 + k] += flow[3 + k] / radius

    return compile_sum(add_slip_flow, parallel, law)


@cache
def wrench_kernel(parallel: bool) -> Any:
    """Compile twists (M, 6) += (u, w) of the forces and torques near each block."""

    def add_wrench_flow(sources, count, radius, bounds, begin, ranges, twists):
        for block in prange(bounds.shape[0]):
            for m in range(bounds[block, 0], bounds[block, 1]):
                for at in range(begin[block], begin[block + 1]):
                    first, last = ranges[at]
                    flow = sum_wrench_flows(sources, radius, count + m, first, last)
                    for k in range(3):
                        twists[m, k] += flow[k]
                        twists[m, 3 + k] += flow[3 + k] / radius

    return compile_sum(add_wrench_flow, parallel)


@cache
def strain_kernel(parallel: bool) -> Any:
    """Compile twists (M, 6) += (u, w) of rigid spheres in a strain, near each block.

    u = −(5a³/2)(1 + a²∇²/10) x (x·E·x)/r⁵ is the exact flow about one sphere
    (:mod:`nrchain.hydrodynamics.disturbance_law`).
    """

    def add_strain_flow(centres, weights, strain, count, radius, bounds, begin, ranges, twists):
        leading, finite_size = -2.5 * radius**3, -1.0 * radius**5
        for block in prange(bounds.shape[0]):
            for m in range(bounds[block, 0], bounds[block, 1]):
                for at in range(begin[block], begin[block + 1]):
                    for j in range(ranges[at, 0], ranges[at, 1]):
                        x = between(centres, count + m, j)
                        add_stresslet(x, strain, leading * weights[j], twists[m])
                        add_finite_size(x, strain, finite_size * weights[j], twists[m])

    return compile_sum(add_strain_flow, parallel)
