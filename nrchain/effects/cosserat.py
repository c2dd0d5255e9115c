"""V = Σ_links [stretch + shear + twist + bend]: the elastic chain of the paper's Appendix B.

With the midpoint tangent C¹r and the midpoint frame C⁰e of a link between spheres i and i+1,

    stretch (λ∥d²/2)(C⁰e₁·C¹r − 1)²      twist (μ∥/2)(e₂·e₃′)²
    shear   (λ⊥d²/2)Σ_{a=2,3}(C⁰e_a·C¹r)²   bend  (μ⊥/2)[(e₁·e₂′)² + (e₃·e₁′)²]

where unprimed frames are those of i and primed ones those of i+1. Inner links take C⁰ and C¹
over four spheres (weights −1, 9, 9, −1 over 16 and 1, −27, 27, −1 over 24d), which keeps the
relaxation of long bends exact to fourth order in qd; the first and the last link of an open chain
take two (½, ½ and −1, 1 over d). The paper's boundary terms print no ½ and a sum over a = 1, 2:
both are misprints for the forms above.

The printed twist and bend are transversely isotropic to linear order only: on a chain that spins
they leave a torque about e₁ that wobbles, of order μβ², β the bend of a link. The ``isotropic``
measure has the same linear response without it,

    twist (μ∥/2)[(e₂·e₃′ − e₃·e₂′)/2]²      bend  μ⊥(1 − e₁·e₁′),

since e₂·e₃′ − e₃·e₂′ does not change when both frames turn about their e₁ by one angle.

Force F = −∂V/∂r and torque T = −Σ_a e_a × ∂V/∂e_a, both in the lab frame, so that a displacement
u and a small rotation φ of a sphere change V by −F·u − T·φ.
"""

from __future__ import annotations

import numpy as np

from nrchain._compile import kernel

REACH = 3
"""How many spheres along the chain the elastic forces reach."""

# Weights of spheres i−1, i, i+1, i+2; row 0 for two-body links, row 1 for four-body ones.
_FRAME_WEIGHTS = np.array([[0.0, 0.5, 0.5, 0.0], [-1 / 16, 9 / 16, 9 / 16, -1 / 16]])
_TANGENT_WEIGHTS = np.array([[0.0, -1.0, 1.0, 0.0], [1 / 24, -27 / 24, 27 / 24, -1 / 24]])

# Which frame vectors of i and i+1 the twist term (first row) and the bend terms multiply.
_TURN_PAIRS = np.array([[1, 2], [0, 1], [2, 0]])


@kernel
def _four_body(link, count, periodic):
    """1 where the link has its four spheres, 0 at the ends of an open chain."""
    return 1 if periodic or 0 < link < count - 2 else 0


@kernel
def _link_strain(positions, frames, link, spacing, period, wide, spheres, midframe, tangent):
    """Fill the spheres of a link (−1: none), C⁰e_a as rows and C¹r."""
    count = positions.shape[0]
    midframe[:] = 0.0
    tangent[:] = 0.0
    for m in range(4):
        if _FRAME_WEIGHTS[wide, m] == 0.0:
            spheres[m] = -1
            continue
        sphere = link - 1 + m
        image = sphere // count
        sphere -= image * count
        spheres[m] = sphere
        weight = _TANGENT_WEIGHTS[wide, m] / spacing
        for k in range(3):
            tangent[k] += weight * positions[sphere, k]
            for a in range(3):
                midframe[a, k] += _FRAME_WEIGHTS[wide, m] * frames[sphere, a, k]
        tangent[0] += weight * image * period


@kernel
def _add_cross(first, second, factor, out):
    """out += factor (a × b)."""
    out[0] += factor * (first[1] * second[2] - first[2] * second[1])
    out[1] += factor * (first[2] * second[0] - first[0] * second[2])
    out[2] += factor * (first[0] * second[1] - first[1] * second[0])


@kernel
def _dot(first, second):
    return first[0] * second[0] + first[1] * second[1] + first[2] * second[2]


@kernel
def _turning_energy(e, f, twist, bend, isotropic):
    """Twist and bend energy of a link between frames e and f."""
    if isotropic:
        sine = 0.5 * (_dot(e[1], f[2]) - _dot(e[2], f[1]))
        return 0.5 * twist * sine**2 + bend * (1.0 - _dot(e[0], f[0]))
    bends = _dot(e[0], f[1]) ** 2 + _dot(e[2], f[0]) ** 2
    return 0.5 * twist * _dot(e[1], f[2]) ** 2 + 0.5 * bend * bends


@kernel
def _turning_moment(e, f, twist, bend, isotropic, moment):
    """The torque of a link on its first sphere; the second feels the opposite.

    A product e_a·f_b changes by (e_a × f_b)·(φ − φ′), so that both only see the difference.
    """
    moment[:] = 0.0
    if isotropic:
        sine = 0.5 * (_dot(e[1], f[2]) - _dot(e[2], f[1]))
        _add_cross(e[1], f[2], -0.5 * twist * sine, moment)
        _add_cross(e[2], f[1], 0.5 * twist * sine, moment)
        _add_cross(e[0], f[0], bend, moment)
        return
    for pair in range(3):
        a, b = _TURN_PAIRS[pair]
        modulus = twist if pair == 0 else bend
        _add_cross(e[a], f[b], -modulus * _dot(e[a], f[b]), moment)


@kernel
def _add_turned_cross(e, f, factor, own, other):
    """Derivative of factor (e × f): own += factor (e fᵀ − e·f), other −= factor (f eᵀ − e·f)."""
    dot = _dot(e, f)
    for p in range(3):
        for q in range(3):
            own[p, q] += factor * e[p] * f[q]
            other[p, q] -= factor * f[p] * e[q]
        own[p, p] -= factor * dot
        other[p, p] += factor * dot


@kernel
def _turning_blocks(e, f, twist, bend, isotropic, own, other):
    """∂ moment / ∂φ and ∂ moment / ∂φ′ of :func:`_turning_moment`, (3, 3) each."""
    own[:] = 0.0
    other[:] = 0.0
    axis = np.zeros(3)
    if isotropic:
        sine = 0.5 * (_dot(e[1], f[2]) - _dot(e[2], f[1]))
        _add_turned_cross(e[1], f[2], -0.5 * twist * sine, own, other)
        _add_turned_cross(e[2], f[1], 0.5 * twist * sine, own, other)
        _add_turned_cross(e[0], f[0], bend, own, other)
        _add_cross(e[1], f[2], 0.5, axis)
        _add_cross(e[2], f[1], -0.5, axis)
        _add_outer(axis, twist, own, other)
        return
    for pair in range(3):
        a, b = _TURN_PAIRS[pair]
        modulus = twist if pair == 0 else bend
        _add_turned_cross(e[a], f[b], -modulus * _dot(e[a], f[b]), own, other)
        axis[:] = 0.0
        _add_cross(e[a], f[b], 1.0, axis)
        _add_outer(axis, modulus, own, other)


@kernel
def _add_outer(axis, factor, own, other):
    """own −= factor v vᵀ and other += factor v vᵀ."""
    for p in range(3):
        for q in range(3):
            own[p, q] -= factor * axis[p] * axis[q]
            other[p, q] += factor * axis[p] * axis[q]


@kernel
def add_wrenches(
    positions, frames, spacing, period, stretch, shear, twist, bend, wrenches, isotropic=False
):
    """wrenches (N, 6) += (F, T) of the elastic energy; ``period`` > 0 closes the chain along x."""
    count = positions.shape[0]
    periodic = period > 0.0
    spheres = np.empty(4, np.int64)
    midframe, tangent, moment = np.empty((3, 3)), np.empty(3), np.empty(3)
    for link in range(count if periodic else count - 1):
        wide = _four_body(link, count, periodic)
        _link_strain(positions, frames, link, spacing, period, wide, spheres, midframe, tangent)
        for a in range(3):
            modulus = (stretch if a == 0 else shear) * spacing * spacing
            if modulus == 0.0:
                continue
            e = midframe[a]
            strain = e[0] * tangent[0] + e[1] * tangent[1] + e[2] * tangent[2]
            tension = modulus * (strain - 1.0 if a == 0 else strain)
            for m in range(4):
                i = spheres[m]
                if i < 0:
                    continue
                pull = tension * _TANGENT_WEIGHTS[wide, m] / spacing
                turn = tension * _FRAME_WEIGHTS[wide, m]
                f = frames[i, a]
                for k in range(3):
                    k1, k2 = (k + 1) % 3, (k + 2) % 3
                    wrenches[i, k] -= pull * e[k]
                    wrenches[i, 3 + k] -= turn * (f[k1] * tangent[k2] - f[k2] * tangent[k1])
        i, j = link, (link + 1) % count
        _turning_moment(frames[i], frames[j], twist, bend, isotropic, moment)
        for k in range(3):
            wrenches[i, 3 + k] += moment[k]
            wrenches[j, 3 + k] -= moment[k]


@kernel
def energy(positions, frames, spacing, period, stretch, shear, twist, bend, isotropic=False):
    """The energy V of the chain, summed over links."""
    count = positions.shape[0]
    periodic = period > 0.0
    spheres = np.empty(4, np.int64)
    midframe, tangent = np.empty((3, 3)), np.empty(3)
    total = 0.0
    for link in range(count if periodic else count - 1):
        wide = _four_body(link, count, periodic)
        _link_strain(positions, frames, link, spacing, period, wide, spheres, midframe, tangent)
        for a in range(3):
            e = midframe[a]
            strain = e[0] * tangent[0] + e[1] * tangent[1] + e[2] * tangent[2]
            modulus = (stretch if a == 0 else shear) * spacing * spacing
            total += 0.5 * modulus * (strain - 1.0 if a == 0 else strain) ** 2
        f = frames[(link + 1) % count]
        total += _turning_energy(frames[link], f, twist, bend, isotropic)
    return total


@kernel
def _add_rank_one(blocks, centre, spheres, gradient, factor):
    """blocks −= factor g gᵀ over the spheres of a link; ``gradient`` is (4, 6)."""
    for m in range(4):
        if spheres[m] < 0:
            continue
        for n in range(4):
            if spheres[n] < 0:
                continue
            block = blocks[spheres[m], centre + n - m]
            for p in range(6):
                for q in range(6):
                    block[p, q] -= factor * gradient[m, p] * gradient[n, q]


@kernel
def _add_skew(block, row, column, factor, v):
    """block[row:row+3, column:column+3] += factor v^, the matrix of w ↦ v × w."""
    for k in range(3):
        k1, k2 = (k + 1) % 3, (k + 2) % 3
        block[row + k, column + k1] -= factor * v[k2]
        block[row + k, column + k2] += factor * v[k1]


@kernel
def _add_dyadic(block, factor, e, t):
    """block[3:, 3:] += factor (e tᵀ − (e·t) I)."""
    dot = e[0] * t[0] + e[1] * t[1] + e[2] * t[2]
    for p in range(3):
        for q in range(3):
            block[3 + p, 3 + q] += factor * e[p] * t[q]
        block[3 + p, 3 + p] -= factor * dot


@kernel
def _add_strain_block(blocks, centre, frames, a, spheres, wide, spacing, e, tangent, tension):
    """blocks −= tension ∂²(C⁰e_a·C¹r): the part of the derivative that the stress carries."""
    for m in range(4):
        i = spheres[m]
        if i < 0:
            continue
        frame_m = _FRAME_WEIGHTS[wide, m]
        tangent_m = _TANGENT_WEIGHTS[wide, m] / spacing
        for n in range(4):
            if spheres[n] < 0:
                continue
            block = blocks[i, centre + n - m]
            frame_n = _FRAME_WEIGHTS[wide, n]
            tangent_n = _TANGENT_WEIGHTS[wide, n] / spacing
            _add_skew(block, 0, 3, tension * tangent_m * frame_n, frames[spheres[n], a])
            _add_skew(block, 3, 0, -tension * frame_m * tangent_n, frames[i, a])
        _add_dyadic(blocks[i, centre], -tension * frame_m, frames[i, a], tangent)


@kernel
def add_jacobian(
    positions, frames, spacing, period, stretch, shear, twist, bend, blocks, isotropic=False
):
    """blocks[i, w + m] += ∂(F, T)_i / ∂(u, φ)_{i+m}, for −3 ≤ m ≤ 3 and 2w + 1 = blocks.shape[1].

    u displaces and φ turns a sphere by a small rotation in the lab: e_a → e_a + φ × e_a.
    """
    count = positions.shape[0]
    centre = blocks.shape[1] // 2
    periodic = period > 0.0
    spheres = np.empty(4, np.int64)
    midframe, tangent = np.empty((3, 3)), np.empty(3)
    gradient = np.empty((4, 6))
    own, other = np.empty((3, 3)), np.empty((3, 3))
    for link in range(count if periodic else count - 1):
        wide = _four_body(link, count, periodic)
        _link_strain(positions, frames, link, spacing, period, wide, spheres, midframe, tangent)
        for a in range(3):
            modulus = (stretch if a == 0 else shear) * spacing * spacing
            if modulus == 0.0:
                continue
            e = midframe[a]
            strain = e[0] * tangent[0] + e[1] * tangent[1] + e[2] * tangent[2]
            for m in range(4):
                if spheres[m] < 0:
                    continue
                f = frames[spheres[m], a]
                for k in range(3):
                    k1, k2 = (k + 1) % 3, (k + 2) % 3
                    gradient[m, k] = _TANGENT_WEIGHTS[wide, m] / spacing * e[k]
                    lever = f[k1] * tangent[k2] - f[k2] * tangent[k1]
                    gradient[m, 3 + k] = _FRAME_WEIGHTS[wide, m] * lever
            _add_rank_one(blocks, centre, spheres, gradient, modulus)
            tension = modulus * (strain - 1.0 if a == 0 else strain)
            _add_strain_block(
                blocks, centre, frames, a, spheres, wide, spacing, e, tangent, tension
            )
        i, j = link, (link + 1) % count
        _turning_blocks(frames[i], frames[j], twist, bend, isotropic, own, other)
        for p in range(3):
            for q in range(3):
                blocks[i, centre, 3 + p, 3 + q] += own[p, q]
                blocks[i, centre + 1, 3 + p, 3 + q] += other[p, q]
                blocks[j, centre - 1, 3 + p, 3 + q] -= own[p, q]
                blocks[j, centre, 3 + p, 3 + q] -= other[p, q]


@kernel
def add_block_product(blocks, poses, periodic, wrenches):
    """wrenches[i] += Σ_m blocks[i, w + m] · poses[i + m]: the change of (F, T) with the poses."""
    count, centre = blocks.shape[0], blocks.shape[1] // 2
    for i in range(count):
        for m in range(blocks.shape[1]):
            j = i + m - centre
            if not periodic and (j < 0 or j >= count):
                continue
            for p in range(6):
                for q in range(6):
                    wrenches[i, p] += blocks[i, m, p, q] * poses[j % count, q]
