"""∂(v, ω)_i/∂(u, φ)_j of a rod: exact, from the second variation of its strains.

With B_kl = ∂(ε, τ)_k/∂(u, φ)_l and the tangent A of the law, the material part of the change of the
wrenches is −Σ_k w_k B_kᵀ A_k B_k for the stress and w_k R_k A_k B_k for the sources. The rest is
the change of the geometry at constant components of stress and sources along the axes of the nodes;
it follows from the wrenches of :mod:`~nrchain.theory.rod.nonlinear.kernels` term by term.
"""

from __future__ import annotations

import numpy as np

from nrchain._compile import inlined, part
from nrchain.theory.rod.nonlinear.kernels import (
    add_element,
    add_points,
    add_sources,
    set_loads,
    set_mobility,
    set_response,
    set_strains,
    set_tangent,
)


@inlined
def _add_cross_matrix(out, row, column, factor, a):
    """out[row : row + 3, column : column + 3] += factor a^."""
    for p in range(3):
        q, r = (p + 1) % 3, (p + 2) % 3
        out[row + p, column + q] -= factor * a[r]
        out[row + p, column + r] += factor * a[q]


@inlined
def _add_double_cross(out, factor, a, b):
    """The rows and columns of φ in out (6, 6) += factor a^ b^ = factor (b aᵀ − a·b)."""
    product = factor * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2])
    for p in range(3):
        out[3 + p, 3 + p] -= product
        for q in range(3):
            out[3 + p, 3 + q] += factor * b[p] * a[q]


@part
def _set_variations(frames, slopes, first, along, variations):
    """B (n, n, 6, 6) of one element."""
    n, count = slopes.shape[0], frames.shape[0]
    turn = np.empty((3, 3))
    variations[:] = 0.0
    for k in range(n):
        e, own = frames[(first + k) % count], variations[k, k]
        for a in range(3):
            for p in range(3):
                q, r = (p + 1) % 3, (p + 2) % 3
                # e_a · (Dx × φ)
                own[a, 3 + p] += e[a, q] * along[k, r] - e[a, r] * along[k, q]
        for m in range(n):
            d, other, to = slopes[k, m], frames[(first + m) % count], variations[k, m]
            for a in range(3):
                for p in range(3):
                    to[a, p] += d * e[a, p]
            if m == k:
                continue
            trace = 0.0
            for a in range(3):
                for b in range(3):
                    total = 0.0
                    for p in range(3):
                        total += e[a, p] * other[b, p]
                    turn[a, b] = -0.5 * d * total
                trace += turn[a, a]
            for a in range(3):
                turn[a, a] -= trace
            for a in range(3):
                for p in range(3):
                    total = 0.0
                    for b in range(3):
                        total += turn[a, b] * e[b, p]
                    to[3 + a, 3 + p] += total
                    own[3 + a, 3 + p] -= total


@part
def _add_material(frames, weights, tangents, variations, first, stiffness):
    """stiffness (n, n, 6, 6) += the change of wrenches with stress and sources."""
    n, count = weights.shape[0], frames.shape[0]
    change = np.empty((12, 6))
    for k in range(n):
        e = frames[(first + k) % count]
        for j in range(n):
            change[:] = 0.0
            for b in range(6):
                # for j ≠ k, ε changes with u and τ with φ alone
                low, high = (0, 6) if j == k else (3 * (b // 3), 3 * (b // 3) + 3)
                for q in range(low, high):
                    value = weights[k] * variations[k, j, b, q]
                    for r in range(12):
                        change[r, q] += tangents[k, b, r] * value
            for m in range(n):
                for r in range(6):
                    low, high = (0, 6) if m == k else (3 * (r // 3), 3 * (r // 3) + 3)
                    for p in range(low, high):
                        value = variations[k, m, r, p]
                        for q in range(6):
                            stiffness[m, j, p, q] -= value * change[r, q]
            for h in range(0, 6, 3):
                for p in range(3):
                    for a in range(3):
                        for q in range(6):
                            stiffness[k, j, h + p, q] += e[a, p] * change[6 + h + a, q]


@part
def _add_geometric(frames, slopes, first, along, turning, loads, levers, stiffness):
    """stiffness += the change of wrenches at constant components of stress and sources."""
    n, count = slopes.shape[0], frames.shape[0]
    pulled = np.empty((3, 3))
    for k in range(n):
        own, e = stiffness[k, k], frames[(first + k) % count]
        _add_cross_matrix(own, 0, 3, -1.0, loads[k, 2])
        _add_cross_matrix(own, 3, 3, -1.0, loads[k, 3])
        n_k = loads[k, 0]
        pulled[:] = 0.0
        for m in range(n):
            other = frames[(first + m) % count]
            _add_cross_matrix(stiffness[m, k], 0, 3, slopes[k, m], n_k)
            _add_cross_matrix(stiffness[k, m], 3, 0, -slopes[k, m], n_k)
            for a in range(3):
                _add_double_cross(stiffness[k, m], slopes[k, m], levers[k, a], other[a])
                _add_double_cross(stiffness[k, m], slopes[m, k], e[a], levers[m, a])
                for p in range(3):
                    pulled[a, p] += slopes[m, k] * levers[m, a, p]
        _add_double_cross(own, -1.0, along[k], n_k)
        for a in range(3):
            _add_double_cross(own, -1.0, turning[k, a], levers[k, a])
            _add_double_cross(own, -1.0, pulled[a], e[a])


@part
def _add_rotated(own, wrench, block):
    """block (6, 6) += the change of R Γ⁻¹ Rᵀ (force, torque) when the node alone rotates."""
    twist = np.zeros(6)
    turned = np.zeros((6, 3))
    for p in range(6):
        for q in range(6):
            twist[p] += own[p, q] * wrench[q]
    for h in range(0, 6, 3):
        for p in range(3):
            q, r = (p + 1) % 3, (p + 2) % 3
            block[h + p, 3 + q] += twist[h + r]
            block[h + p, 3 + r] -= twist[h + q]
            turned[h + p, q] += wrench[h + r]
            turned[h + p, r] -= wrench[h + q]
    for p in range(6):
        for q in range(3):
            for r in range(6):
                block[p, 3 + q] -= own[p, r] * turned[r, q]


@part
def add_blocks(positions, frames, slopes, weights, law, mobility, points, elements, period, blocks):
    """blocks (N, 2w + 1, 6, 6)[i, w + m] += ∂(v, ω)_i/∂(u, φ)_{i+m}."""
    n, count, centre = slopes.shape[0], positions.shape[0], blocks.shape[1] // 2
    along, turning, strains = np.empty((n, 3)), np.empty((n, 3, 3)), np.empty((n, 6))
    loads, levers, response = np.empty((n, 4, 3)), np.empty((n, 3, 3)), np.empty(12)
    tangents, variations = np.empty((n, 6, 12)), np.empty((n, n, 6, 6))
    stiffness, wrenches, own = np.empty((n, n, 6, 6)), np.zeros((count, 6)), np.empty((6, 6))
    for element in range(elements):
        first = element * (n - 1)
        set_strains(positions, frames, slopes, period, first, along, turning, strains)
        for k in range(n):
            set_response(law, strains[k], response)
            set_tangent(law, strains[k], tangents[k])
            set_loads(frames[(first + k) % count], weights[k], response, loads[k], levers[k])
        add_element(frames, slopes, first, along, turning, loads, levers, wrenches)
        add_sources(frames, first, loads, wrenches)
        _set_variations(frames, slopes, first, along, variations)
        stiffness[:] = 0.0
        _add_material(frames, weights, tangents, variations, first, stiffness)
        _add_geometric(frames, slopes, first, along, turning, loads, levers, stiffness)
        for k in range(n):
            i = (first + k) % count
            set_mobility(frames[i], mobility[i], own)
            for m in range(n):
                to = blocks[i, centre + m - k]
                for p in range(6):
                    for r in range(6):
                        for q in range(6):
                            to[p, q] += own[p, r] * stiffness[k, m, r, q]
    _add_point_wrenches(frames, mobility, points, wrenches, blocks)
    for i in range(count):
        set_mobility(frames[i], mobility[i], own)
        _add_rotated(own, wrenches[i], blocks[i, centre])


@part
def _add_point_wrenches(frames, mobility, points, wrenches, blocks):
    """Add wrenches on nodes along their own axes, and what they change in a rotation."""
    count, centre = frames.shape[0], blocks.shape[1] // 2
    alone, own, turned = np.zeros((count, 6)), np.empty((6, 6)), np.zeros((6, 6))
    add_points(frames, points, alone)
    for i in range(count):
        turned[:] = 0.0
        _add_cross_matrix(turned, 0, 3, -1.0, alone[i, :3])
        _add_cross_matrix(turned, 3, 3, -1.0, alone[i, 3:])
        set_mobility(frames[i], mobility[i], own)
        for p in range(6):
            wrenches[i, p] += alone[i, p]
            for r in range(6):
                for q in range(6):
                    blocks[i, centre, p, q] += own[p, r] * turned[r, q]
