"""J_ij = T_i⁻¹ D_ij T_j + δ_ij ∂(T_i⁻¹)·ω: the derivative of the twists in a chart.

D is the derivative with displacements and rotations (u, φ) in the lab, T the tangent of the Cayley
map, the identity for displacements.
"""

from __future__ import annotations

import numpy as np

from nrchain._compile import kernel
from nrchain.geometry import lie
from nrchain.motion.chart_poses import relative_rotation


@kernel(alone=True)
def set_tangents(y, order, spins, frames, twists, maps):
    """maps[i] = (T, T⁻¹, ∂(T⁻¹)·ω), (3, 3) each, of every sphere with coordinates."""
    omega = np.empty(3)
    for slot in range(order.shape[0]):
        i = order[slot]
        relative_rotation(spins[i], frames[i], twists[i], omega)
        theta = y[6 * slot + 3 : 6 * slot + 6]
        lie.tangent(theta, maps[i, 0])
        lie.inverse_tangent(theta, maps[i, 1])
        lie.rate_derivative(theta, omega, maps[i, 2])


@kernel(alone=True)
def transform_blocks(blocks, slot_of, maps, turning):
    """blocks ← T_i⁻¹ D_ij T_j + δ_ij ∂(T_i⁻¹)·ω, in place."""
    count, width = blocks.shape[0], blocks.shape[1]
    centre = width // 2
    for i in range(count):
        if slot_of[i] < 0:
            continue
        # ω − Ω changes by −φ × Ω = Ω × φ when the sphere rotates by φ, and Ω with it
        for k in range(3):
            k1, k2 = (k + 1) % 3, (k + 2) % 3
            blocks[i, centre, 3 + k, 3 + k1] -= turning[i, k2]
            blocks[i, centre, 3 + k, 3 + k2] += turning[i, k1]
        for m in range(width):
            j = (i + m - centre) % count
            if slot_of[j] < 0:
                continue
            for p in range(6):
                x, y, z = blocks[i, m, p, 3], blocks[i, m, p, 4], blocks[i, m, p, 5]
                for q in range(3):
                    blocks[i, m, p, 3 + q] = (
                        x * maps[j, 0, 0, q] + y * maps[j, 0, 1, q] + z * maps[j, 0, 2, q]
                    )
            for q in range(6):
                x, y, z = blocks[i, m, 3, q], blocks[i, m, 4, q], blocks[i, m, 5, q]
                for p in range(3):
                    blocks[i, m, 3 + p, q] = (
                        maps[i, 1, p, 0] * x + maps[i, 1, p, 1] * y + maps[i, 1, p, 2] * z
                    )
        for p in range(3):
            for q in range(3):
                blocks[i, centre, 3 + p, 3 + q] += maps[i, 2, p, q]


@kernel
def set_symmetric_band(blocks, slot_of, ratio, band):
    """band[k, n] = (A + Aᵀ)[n + k, n]/2 with A = S⁻¹JS, for the blocks of an open chain.

    S multiplies rotations by ``ratio``.
    """
    count, width = blocks.shape[0], blocks.shape[1]
    band[:] = 0.0
    for i in range(count):
        for m in range(width):
            j = i + m - width // 2
            if slot_of[i] < 0 or j < 0 or j >= count or slot_of[j] < 0:
                continue
            for p in range(6):
                for q in range(6):
                    value = blocks[i, m, p, q]
                    if p < 3 <= q:
                        value *= ratio
                    elif q < 3 <= p:
                        value /= ratio
                    row, column = 6 * slot_of[i] + p, 6 * slot_of[j] + q
                    if row == column:
                        band[0, row] += value
                    else:
                        band[abs(row - column), min(row, column)] += 0.5 * value


@kernel
def multiply(blocks, order, slot_of, periodic, vector, out):
    """out = J · vector for blocks near the diagonal that are all of J."""
    count, width = blocks.shape[0], blocks.shape[1]
    centre = width // 2
    out[:] = 0.0
    for slot in range(order.shape[0]):
        i = order[slot]
        for m in range(width):
            j = i + m - centre
            if not periodic and (j < 0 or j >= count):
                continue
            other = slot_of[j % count]
            if other < 0:
                continue
            for p in range(6):
                total = 0.0
                for q in range(6):
                    total += blocks[i, m, p, q] * vector[6 * other + q]
                out[6 * slot + p] += total


@kernel
def to_poses(vector, maps, order, poses):
    """poses[i] = T · (change of y): displacement and rotation in the lab."""
    for slot in range(order.shape[0]):
        i = order[slot]
        for p in range(3):
            poses[i, p], poses[i, 3 + p] = vector[6 * slot + p], 0.0
            for q in range(3):
                poses[i, 3 + p] += maps[i, 0, p, q] * vector[6 * slot + 3 + q]


@kernel
def to_rates(twists, poses, turning, vector, maps, order, out):
    """out = T⁻¹ (v, ω + Ω × φ) + ∂(T⁻¹)·ω · vector, for a change of twists and poses."""
    omega = np.empty(3)
    for slot in range(order.shape[0]):
        i = order[slot]
        for k in range(3):
            k1, k2 = (k + 1) % 3, (k + 2) % 3
            omega[k] = twists[i, 3 + k]
            omega[k] += turning[i, k1] * poses[i, 3 + k2] - turning[i, k2] * poses[i, 3 + k1]
        for p in range(3):
            total = 0.0
            for q in range(3):
                total += maps[i, 1, p, q] * omega[q] + maps[i, 2, p, q] * vector[6 * slot + 3 + q]
            out[6 * slot + p], out[6 * slot + 3 + p] = twists[i, p], total
