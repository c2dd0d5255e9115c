"""(v, ω)_k = R_k Γ⁻¹ R_kᵀ (force, torque)_k / W_k: the twists of a rod in the weak form.

Strains at the points of an element are ε = Rᵀ (Dx) − e₁ and τ = axial(skew(Rᵀ (DR))). Their
variation with displacements u and rotations φ of the nodes,

    δε_k = R_kᵀ (Σ_l D_kl u_l + (Dx)_k × φ_k),
    δτ_k = Σ_l D_kl ½(tr Q − Q) R_kᵀ (φ_l − φ_k),     Q = R_kᵀ R_l,

is exact. The stress (F, M) does the virtual work −Σ_k w_k (F·δε + M·δτ)_k, a source (f, m) does
Σ_k w_k (f·u + m·φ)_k. With n = w R F, q_a = ½ w (R M) × e_a this is

    force_l = −Σ_k D_kl n_k,
    torque_k = (Dx)_k × n_k + Σ_a [(De_a)_k × q_ka − e_a × (Dᵀ q_a)_k].

Strains do not change when the rod moves as a rigid body: forces and torques of any stress sum to
zero, with or without an energy. A node that two elements share gets the sum of both.

Frames are rows e_a in the lab, as everywhere. ``law`` (28, 12) has the coefficients of 1, of the
strains x (6) and of their products x_a x_b, b ≤ a (21), in (F, M, f, m).
"""

from __future__ import annotations

import numpy as np

from nrchain._compile import inlined, part


@part
def set_strains(positions, frames, slopes, period, first, along, turning, strains):
    """(Dx) (n, 3), (De_a) (n, 3, 3) and (ε, τ) (n, 6) in the element from node ``first``."""
    n, count = slopes.shape[0], positions.shape[0]
    along[:] = 0.0
    turning[:] = 0.0
    for k in range(n):
        for m in range(n):
            j, d = first + m, slopes[k, m]
            if j >= count:
                j -= count
                along[k, 0] += d * period
            for p in range(3):
                along[k, p] += d * positions[j, p]
                for a in range(3):
                    turning[k, a, p] += d * frames[j, a, p]
        e, t = frames[(first + k) % count], turning[k]
        for a in range(3):
            b, c = (a + 1) % 3, (a + 2) % 3
            strain, twist = 0.0, 0.0
            for p in range(3):
                strain += e[a, p] * along[k, p]
                twist += 0.5 * (e[c, p] * t[b, p] - e[b, p] * t[c, p])
            strains[k, a], strains[k, 3 + a] = strain, twist
        strains[k, 0] -= 1.0


@part
def set_response(law, x, out):
    """out (12,) = (F, M, f, m) at strains x (6,)."""
    out[:] = law[0]
    row = 7
    for a in range(6):
        for r in range(12):
            out[r] += law[1 + a, r] * x[a]
        for b in range(a + 1):
            product = x[a] * x[b]
            for r in range(12):
                out[r] += law[row, r] * product
            row += 1


@part
def set_tangent(law, x, out):
    """out (6, 12) = ∂(F, M, f, m)/∂x, one strain a row."""
    out[:] = law[1:7]
    row = 7
    for a in range(6):
        for b in range(a + 1):
            for r in range(12):
                out[a, r] += law[row, r] * x[b]
                out[b, r] += law[row, r] * x[a]
            row += 1


@inlined
def add_cross(out, row, offset, factor, a, b):
    """out[row, offset : offset + 3] += factor · a × b."""
    out[row, offset] += factor * (a[1] * b[2] - a[2] * b[1])
    out[row, offset + 1] += factor * (a[2] * b[0] - a[0] * b[2])
    out[row, offset + 2] += factor * (a[0] * b[1] - a[1] * b[0])


@part
def set_loads(e, weight, response, loads, levers):
    """loads (4, 3) = w R (F, M, f, m) and levers (3, 3) = q_a, in the lab."""
    for half in range(4):
        for p in range(3):
            total = 0.0
            for a in range(3):
                total += response[3 * half + a] * e[a, p]
            loads[half, p] = weight * total
    levers[:] = 0.0
    for a in range(3):
        add_cross(levers, a, 0, 0.5, loads[1], e[a])


@part
def add_element(frames, slopes, first, along, turning, loads, levers, wrenches):
    """wrenches (N, 6) += those of the stress of one element, from its loads and levers."""
    n, count = slopes.shape[0], frames.shape[0]
    pulled = np.empty((3, 3))
    for k in range(n):
        i = (first + k) % count
        pulled[:] = 0.0
        for m in range(n):
            d = slopes[m, k]
            for p in range(3):
                wrenches[i, p] -= d * loads[m, 0, p]
                for a in range(3):
                    pulled[a, p] += d * levers[m, a, p]
        add_cross(wrenches, i, 3, 1.0, along[k], loads[k, 0])
        for a in range(3):
            add_cross(wrenches, i, 3, 1.0, turning[k, a], levers[k, a])
            add_cross(wrenches, i, 3, -1.0, frames[i, a], pulled[a])


@part
def add_sources(frames, first, loads, wrenches):
    """wrenches (N, 6) += the sources of one element, from its loads (n, 4, 3)."""
    for k in range(loads.shape[0]):
        i = (first + k) % frames.shape[0]
        for p in range(3):
            wrenches[i, p] += loads[k, 2, p]
            wrenches[i, 3 + p] += loads[k, 3, p]


@part
def add_points(frames, points, wrenches):
    """wrenches += the wrenches ``points`` (N, 6) on the nodes, given along their own axes."""
    for i in range(frames.shape[0]):
        for a in range(3):
            for p in range(3):
                wrenches[i, p] += points[i, a] * frames[i, a, p]
                wrenches[i, 3 + p] += points[i, 3 + a] * frames[i, a, p]


@part
def move(e, mobility, wrench, twist):
    """twist (6,) += R Γ⁻¹ Rᵀ wrench/W of a node with axes e."""
    own = np.zeros(6)
    for a in range(3):
        for p in range(3):
            own[a] += e[a, p] * wrench[p]
            own[3 + a] += e[a, p] * wrench[3 + p]
    for a in range(6):
        total = 0.0
        for b in range(6):
            total += mobility[a, b] * own[b]
        half = 3 * (a // 3)
        for p in range(3):
            twist[half + p] += total * e[a - half, p]


@part
def set_mobility(e, mobility, out):
    """out (6, 6) = R Γ⁻¹ Rᵀ/W of a node in the lab, for a mobility along its own axes."""
    half = np.empty((6, 6))
    for a in range(6):
        for g in range(0, 6, 3):
            for q in range(3):
                total = 0.0
                for b in range(3):
                    total += mobility[a, g + b] * e[b, q]
                half[a, g + q] = total
    for h in range(0, 6, 3):
        for p in range(3):
            for q in range(6):
                total = 0.0
                for a in range(3):
                    total += e[a, p] * half[h + a, q]
                out[h + p, q] = total


@part
def set_mean_motion(frames, lengths, twists):
    """twists (N, 6) = the mean velocity and the mean spin about e₁, over the drag of the nodes."""
    total, spin = 0.0, 0.0
    velocity = np.zeros(3)
    for i in range(frames.shape[0]):
        total += lengths[i]
        for p in range(3):
            velocity[p] += lengths[i] * twists[i, p]
            spin += lengths[i] * twists[i, 3 + p] * frames[i, 0, p]
    for i in range(frames.shape[0]):
        for p in range(3):
            twists[i, p] = velocity[p] / total
            twists[i, 3 + p] = spin / total * frames[i, 0, p]


@part
def add_twists(
    positions, frames, slopes, weights, law, mobility, points, elements, period, stressed, twists
):
    """twists (N, 6) += (v, ω) of the sources, and of the stress if it is ``stressed``."""
    n, count = slopes.shape[0], positions.shape[0]
    along, turning, strains = np.empty((n, 3)), np.empty((n, 3, 3)), np.empty((n, 6))
    loads, levers, response = np.empty((n, 4, 3)), np.empty((n, 3, 3)), np.empty(12)
    wrenches = np.zeros((count, 6))
    for element in range(elements):
        first = element * (n - 1)
        set_strains(positions, frames, slopes, period, first, along, turning, strains)
        for k in range(n):
            set_response(law, strains[k], response)
            i = (first + k) % count
            set_loads(frames[i], weights[k], response, loads[k], levers[k])
        if stressed:
            add_element(frames, slopes, first, along, turning, loads, levers, wrenches)
        add_sources(frames, first, loads, wrenches)
    add_points(frames, points, wrenches)
    for i in range(count):
        move(frames[i], mobility[i], wrenches[i], twists[i])
