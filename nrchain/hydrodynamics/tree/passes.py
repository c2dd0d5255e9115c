"""u = φ − x_j ∇φ_j + ∇ψ and w = ½ ∇ × u = ∇ × φ: flows of multipoles, gathered and handed down.

Every flow of a sphere in Stokes flow is one of four harmonic potentials φ_x, φ_y, φ_z and ψ
(Papkovich and Neuber), with x counted from a centre. Each potential is a sum of multipoles
Σ_a M_a S_a about that centre. The multipoles of spheres are shifted to the centres of their leaves,
then to the centres of larger intervals, across to far intervals as local expansions Σ_a L_a R_a,
and down to the leaves, where the flow is evaluated. When the centre moves by d, ψ changes by −d·φ.

Sources: Greengard & Rokhlin, J. Comput. Phys. 73 (1987) 325; Tornberg & Greengard, J. Comput. Phys.
227 (2008) 1613, for Stokes flow by four potentials.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import prange

from nrchain._compile import kernel
from nrchain.hydrodynamics.sharing import compile_sum
from nrchain.hydrodynamics.tree.harmonics import LANES, UNITS, fill_irregular, fill_regular
from nrchain.hydrodynamics.tree.intervals import GROUP

POTENTIALS = 4
"""φ_x, φ_y, φ_z and ψ."""


@kernel(alone=True)
def _fill_moments(source, d, moments):
    """moments (4n,) = the rows of ``source`` (n, 4), with ψ about a centre that lies −d away."""
    for b in range(source.shape[0]):
        m0, m1, m2 = source[b, 0], source[b, 1], source[b, 2]
        moments[4 * b], moments[4 * b + 1], moments[4 * b + 2] = m0, m1, m2
        moments[4 * b + 3] = source[b, 3] + d[0] * m0 + d[1] * m1 + d[2] * m2


@cache
def gather_kernel(parallel: bool):
    """Compile the multipoles of leaves, from those of their spheres (N, rows, 4).

    Σ_j R_a(x_j) M_b(j) is summed over the spheres of a leaf before the table G is used.
    """

    def gather(points, own, lowest, bounds, balls, degree, G, multipoles):
        first, second, first_weight, second_weight = G
        leaves, rows, count = bounds.shape[0] // 2, own.shape[1], (degree + 1) ** 2
        for leaf in prange(leaves):
            i = leaves + leaf
            regular, d, moments = np.empty(count), np.empty(3), np.empty(4 * rows)
            products = np.zeros((count, 4 * rows))
            for j in range(bounds[i, 0], bounds[i, 1]):
                for k in range(3):
                    d[k] = points[k, j] - balls[i, k]
                fill_regular(d[0], d[1], d[2], degree, regular)
                _fill_moments(own[j], d, moments)
                for ell in range(degree + 1 - lowest):
                    width = 4 * min(rows, (degree + 1 - ell) ** 2)
                    for a in range(ell * ell, (ell + 1) * (ell + 1)):
                        r = regular[a]
                        for column in range(width):
                            products[a, column] += r * moments[column]
            multipoles[i] = 0.0
            for b in range(lowest * lowest, rows):
                room = degree + 1 - int(np.sqrt(b))
                for a in range(room * room):
                    c, e = first[b, a], second[b, a]
                    v, w = first_weight[b, a], second_weight[b, a]
                    for k in range(4):
                        multipoles[i, c, k] += v * products[a, 4 * b + k]
                        multipoles[i, e, k] += w * products[a, 4 * b + k]

    return compile_sum(gather, parallel)


@cache
def raise_kernel(parallel: bool):
    """Compile the multipoles of larger intervals, from those of their halves, level by level."""

    def raise_multipoles(balls, degree, G, multipoles):
        first, second, first_weight, second_weight = G
        count, width = (degree + 1) ** 2, balls.shape[0] // 4
        while width:
            for place in prange(width):
                i = width + place
                regular, d, moments = np.empty(count), np.empty(3), np.empty(4 * count)
                multipoles[i] = 0.0
                for half in range(2 * i, 2 * i + 2):
                    for k in range(3):
                        d[k] = balls[half, k] - balls[i, k]
                    fill_regular(d[0], d[1], d[2], degree, regular)
                    _fill_moments(multipoles[half], d, moments)
                    for b in range(count):
                        room = degree + 1 - int(np.sqrt(b))
                        for a in range(room * room):
                            c, e = first[b, a], second[b, a]
                            v, w = first_weight[b, a] * regular[a], second_weight[b, a] * regular[a]
                            for k in range(4):
                                multipoles[i, c, k] += v * moments[4 * b + k]
                                multipoles[i, e, k] += w * moments[4 * b + k]
            width //= 2

    return compile_sum(raise_multipoles, parallel)


@kernel(alone=True)
def _fill_batch(balls, rows, multipoles, count, points, batch):
    """The displacements (3, LANES) and multipoles (n, 4, LANES) of a batch of far pairs."""
    for lane in range(LANES):
        if lane >= rows.shape[0]:
            points[:3, lane] = points[:3, 0]
            batch[:count, :, lane] = 0.0
            continue
        i, j, _ = rows[lane]
        x, y, z = balls[i, 0] - balls[j, 0], balls[i, 1] - balls[j, 1], balls[i, 2] - balls[j, 2]
        points[0, lane], points[1, lane], points[2, lane] = x, y, z
        for b in range(count):
            m0, m1, m2 = multipoles[j, b, 0], multipoles[j, b, 1], multipoles[j, b, 2]
            batch[b, 0, lane], batch[b, 1, lane], batch[b, 2, lane] = m0, m1, m2
            batch[b, 3, lane] = multipoles[j, b, 3] - x * m0 - y * m1 - z * m2


@kernel(alone=True)
def _add_batch(G, irregular, batch, degree, rows, total, locals_):
    """L_a of each target += (−1)^l_a Σ_b G_cab S_c M_b of its source, LANES pairs side by side."""
    first, second, first_weight, second_weight = G
    count = (degree + 1) * (degree + 1)
    for a in range(count):
        total[:] = 0.0
        for b in range(count):
            c, v = first[a, b], first_weight[a, b]
            d, w = second[a, b], second_weight[a, b]
            for lane in range(total.shape[1]):
                k = v * irregular[c, lane] + w * irregular[d, lane]
                total[0, lane] += k * batch[b, 0, lane]
                total[1, lane] += k * batch[b, 1, lane]
                total[2, lane] += k * batch[b, 2, lane]
                total[3, lane] += k * batch[b, 3, lane]
        sign = -1.0 if int(np.sqrt(a)) % 2 else 1.0
        for lane in range(rows.shape[0]):
            for k in range(POTENTIALS):
                locals_[rows[lane, 0], a, k] += sign * total[k, lane]


@cache
def across_kernel(parallel: bool):
    """Compile the local expansions of intervals, from the multipoles of far ones."""

    def across(balls, far_begin, far, degree, G, multipoles, locals_):
        for group in prange(far_begin.shape[0] - 1):
            locals_[GROUP * group : GROUP * (group + 1)] = 0.0
            begin, end = far_begin[group], far_begin[group + 1]
            if begin == end:
                continue
            irregular = np.empty(((2 * degree + 1) ** 2, LANES))
            batch = np.empty(((degree + 1) ** 2, POTENTIALS, LANES))
            total, points = np.empty((POTENTIALS, LANES)), np.empty((4, LANES))
            for at in range(begin, end, LANES):
                rows = far[at : min(at + LANES, end)]
                highest = rows[-1, 2]
                _fill_batch(balls, rows, multipoles, (highest + 1) ** 2, points, batch)
                fill_irregular(points, 2 * highest, irregular)
                _add_batch(G, irregular, batch, highest, rows, total, locals_)

    return compile_sum(across, parallel)


@cache
def lower_kernel(parallel: bool):
    """Compile the addition, to the local expansion of each half, of that of its whole interval."""

    def lower_locals(balls, degree, G, locals_):
        first, second, first_weight, second_weight = G
        count, width = (degree + 1) ** 2, 2
        while width < balls.shape[0]:
            for place in prange(width):
                i = width + place
                whole = i // 2
                regular, d, value = np.empty(count), np.empty(3), np.empty(POTENTIALS)
                for k in range(3):
                    d[k] = balls[i, k] - balls[whole, k]
                fill_regular(d[0], d[1], d[2], degree, regular)
                for b in range(count):
                    value[:] = 0.0
                    room = degree + 1 - int(np.sqrt(b))
                    for a in range(room * room):
                        c, e = first[b, a], second[b, a]
                        v, w = first_weight[b, a] * regular[a], second_weight[b, a] * regular[a]
                        for k in range(POTENTIALS):
                            value[k] += v * locals_[whole, c, k] + w * locals_[whole, e, k]
                    for k in range(3):
                        locals_[i, b, k] += value[k]
                        locals_[i, b, 3] -= d[k] * value[k]
                    locals_[i, b, 3] += value[3]
            width *= 2

    return compile_sum(lower_locals, parallel)


@kernel(alone=True)
def _slopes(G, degree, field, out):
    """out[k] = the local expansions of ∂_k of the columns of ``field`` (n, columns)."""
    first, second, first_weight, second_weight = G
    out[:] = 0.0
    for k in range(3):
        a, slope = UNITS[k]
        for b in range(degree * degree):
            c1, c2 = first[a, b], second[a, b]
            w1, w2 = slope * first_weight[a, b], slope * second_weight[a, b]
            for column in range(field.shape[1]):
                out[k, b, column] = w1 * field[c1, column] + w2 * field[c2, column]


@kernel(alone=True)
def _flow_of(G, degree, local, slopes, field):
    """Columns of ``field`` (n, 12): φ_i + ∂_i ψ, then ∂_i φ_j at 3 + 3i + j."""
    _slopes(G, degree, local, slopes)
    for b in range(field.shape[0]):
        for i in range(3):
            field[b, i] = local[b, i] + slopes[i, b, 3]
            for j in range(3):
                field[b, 3 + 3 * i + j] = slopes[i, b, j]


@cache
def flow_kernel(parallel: bool):
    """Compile twists (N, 6) += (u, w) of the local expansions of leaves, at their spheres."""

    def add_flow(points, bounds, balls, degree, G, locals_, radius, twists):
        leaves = bounds.shape[0] // 2
        for leaf in prange(leaves):
            i, count = leaves + leaf, (degree + 1) ** 2
            slopes, field = np.empty((3, count, 4)), np.empty((count, 12))
            regular, value = np.empty(count), np.empty(12)
            _flow_of(G, degree, locals_[i], slopes, field)
            for j in range(bounds[i, 0], bounds[i, 1]):
                x, y, z = (
                    points[0, j] - balls[i, 0],
                    points[1, j] - balls[i, 1],
                    points[2, j] - balls[i, 2],
                )
                fill_regular(x, y, z, degree, regular)
                value[:] = 0.0
                for b in range(count):
                    for column in range(12):
                        value[column] += regular[b] * field[b, column]
                for k in range(3):
                    own = 3 + 3 * k
                    along = x * value[own] + y * value[own + 1] + z * value[own + 2]
                    twists[j, k] += value[k] - along
                    p, q = (k + 1) % 3, (k + 2) % 3
                    curl = value[3 + 3 * p + q] - value[3 + 3 * q + p]
                    twists[j, 3 + k] += curl / radius

    return compile_sum(add_flow, parallel)


@cache
def gradient_kernel(parallel: bool):
    """Compile gradients (N, 6, 3) = ∂(u, a w)/∂x of the local expansions, at the spheres."""

    def fill_gradients(points, bounds, balls, degree, G, locals_, gradients):
        leaves = bounds.shape[0] // 2
        for leaf in prange(leaves):
            i, count = leaves + leaf, (degree + 1) ** 2
            slopes, field = np.empty((3, count, 4)), np.empty((count, 12))
            second, regular, value = np.empty((3, count, 12)), np.empty(count), np.empty((3, 12))
            d = np.empty(3)
            _flow_of(G, degree, locals_[i], slopes, field)
            _slopes(G, degree, field, second)
            for j in range(bounds[i, 0], bounds[i, 1]):
                for k in range(3):
                    d[k] = points[k, j] - balls[i, k]
                fill_regular(d[0], d[1], d[2], degree, regular)
                value[:] = 0.0
                own = np.zeros(12)
                for b in range(count):
                    for column in range(12):
                        own[column] += regular[b] * field[b, column]
                        for k in range(3):
                            value[k, column] += regular[b] * second[k, b, column]
                for ell in range(3):
                    for k in range(3):
                        change = value[ell, k] - own[3 + 3 * k + ell]
                        for m in range(3):
                            change -= d[m] * value[ell, 3 + 3 * k + m]
                        gradients[j, k, ell] = change
                        p, q = (k + 1) % 3, (k + 2) % 3
                        gradients[j, 3 + k, ell] = (
                            value[ell, 3 + 3 * p + q] - value[ell, 3 + 3 * q + p]
                        )

    return compile_sum(fill_gradients, parallel)


@kernel(alone=True)
def add_moved(gradients, moves, radius, twists):
    """twists (N, 6) += the change of the flow at each sphere as it moves by ``moves`` (3, N)."""
    for j in range(twists.shape[0]):
        for k in range(3):
            for ell in range(3):
                twists[j, k] += gradients[j, k, ell] * moves[ell, j]
                twists[j, 3 + k] += gradients[j, 3 + k, ell] * moves[ell, j] / radius
