"""J_ij = T_i⁻¹ D_ij T_j + δ_ij ∂(T_i⁻¹)·ω: the derivative of the twists in a chart.

D is the derivative with displacements and rotations (u, φ) in the lab, T the tangent of the Cayley
map, the identity for displacements.
"""

from __future__ import annotations

import numpy as np

from nrchain._compile import kernel
from nrchain.geometry import lie
from nrchain.motion.chart_poses import relative_rotation


@kernel
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


@kernel
def transform_blocks(blocks, slot_of, maps, turning):
    """blocks ← T_i⁻¹ D_ij T_j + δ_ij ∂(T_i⁻¹)·ω, in place."""
    count, width = blocks.shape[0], blocks.shape[1]
    centre = width // 2
    work = np.empty((6, 3))
    for i in range(count):
        if slot_of[i] < 0:
            continue
        own = blocks[i, centre]
        # ω − Ω changes by −φ × Ω = Ω × φ when the sphere rotates by φ, and Ω with it
        for k in range(3):
            k1, k2 = (k + 1) % 3, (k + 2) % 3
            own[3 + k, 3 + k1] -= turning[i, k2]
            own[3 + k, 3 + k2] += turning[i, k1]
        for m in range(width):
            j = (i + m - centre) % count
            if slot_of[j] < 0:
                continue
            block = blocks[i, m]
            for p in range(6):
                for q in range(3):
                    work[p, q] = 0.0
                    for k in range(3):
                        work[p, q] += block[p, 3 + k] * maps[j, 0, k, q]
                for q in range(3):
                    block[p, 3 + q] = work[p, q]
            for q in range(6):
                for p in range(3):
                    work[p, 0] = maps[i, 2, p, q - 3] if m == centre and q > 2 else 0.0
                    for k in range(3):
                        work[p, 0] += maps[i, 1, p, k] * block[3 + k, q]
                for p in range(3):
                    block[3 + p, q] = work[p, 0]


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
