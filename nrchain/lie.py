"""R = cay(θ) = (I − θ^/2)⁻¹ (I + θ^/2): rotations and rigid motions by the Cayley map.

θ^ is the matrix of v ↦ θ × v. A rotation by the angle α about the unit vector k has
θ = 2 tan(α/2) k: the map is rational, needs no series at small angles and is singular only at a
half turn. On SE(3) the same formula with ξ = (ρ, θ) gives the rigid motion

    x ↦ R x + p,   R = cay(θ),   p = (I − θ^/2)⁻¹ ρ.

Tangents are left-trivialised in the lab: a pose (p, R) moves with (ṗ, ω), Ṙ = ω^ R. The paper
(App. D) integrates in these coordinates; see Iserles et al., Acta Numerica 9 (2000), Sec. 8.3.
"""

from __future__ import annotations

import numpy as np

from nrchain._compile import kernel


@kernel
def cross(a, b, out):
    """out = a × b for vectors of three."""
    x = a[1] * b[2] - a[2] * b[1]
    y = a[2] * b[0] - a[0] * b[2]
    z = a[0] * b[1] - a[1] * b[0]
    out[0], out[1], out[2] = x, y, z


@kernel
def cayley(theta, out):
    """out = cay(θ) = I + (θ^ + θ^²/2) / (1 + θ²/4), a rotation (3, 3).

    Orthonormal to rounding for every finite θ.
    """
    x, y, z = theta[0], theta[1], theta[2]
    square = 0.25 * (x * x + y * y + z * z)
    inverse = 1.0 / (1.0 + square)
    half = 0.5 * inverse
    out[0, 0] = 1.0 - half * (y * y + z * z)
    out[1, 1] = 1.0 - half * (z * z + x * x)
    out[2, 2] = 1.0 - half * (x * x + y * y)
    out[0, 1], out[1, 0] = half * x * y - inverse * z, half * x * y + inverse * z
    out[1, 2], out[2, 1] = half * y * z - inverse * x, half * y * z + inverse * x
    out[2, 0], out[0, 2] = half * z * x - inverse * y, half * z * x + inverse * y


@kernel
def inverse_cayley(rotation, out):
    """out = θ with cay(θ) = R: twice the axial vector of R − Rᵀ over 1 + tr R.

    The divisor tends to zero at a half turn, where θ is infinite.
    """
    scale = 2.0 / (1.0 + rotation[0, 0] + rotation[1, 1] + rotation[2, 2])
    out[0] = scale * (rotation[2, 1] - rotation[1, 2])
    out[1] = scale * (rotation[0, 2] - rotation[2, 0])
    out[2] = scale * (rotation[1, 0] - rotation[0, 1])


@kernel
def half_inverse(theta, vector, out):
    """out = (I − θ^/2)⁻¹ v = (v + θ × v/2 + θ (θ·v)/4) / (1 + θ²/4)."""
    square = theta[0] * theta[0] + theta[1] * theta[1] + theta[2] * theta[2]
    dot = theta[0] * vector[0] + theta[1] * vector[1] + theta[2] * vector[2]
    inverse = 1.0 / (1.0 + 0.25 * square)
    x = vector[0] + 0.5 * (theta[1] * vector[2] - theta[2] * vector[1]) + 0.25 * dot * theta[0]
    y = vector[1] + 0.5 * (theta[2] * vector[0] - theta[0] * vector[2]) + 0.25 * dot * theta[1]
    z = vector[2] + 0.5 * (theta[0] * vector[1] - theta[1] * vector[0]) + 0.25 * dot * theta[2]
    out[0], out[1], out[2] = inverse * x, inverse * y, inverse * z


@kernel
def tangent_so3(theta, out):
    """out (3, 3) with ω = out θ̇: (I + θ^/2) / (1 + θ²/4)."""
    x, y, z = theta[0], theta[1], theta[2]
    inverse = 1.0 / (1.0 + 0.25 * (x * x + y * y + z * z))
    half = 0.5 * inverse
    out[0, 0] = out[1, 1] = out[2, 2] = inverse
    out[0, 1], out[1, 0] = -half * z, half * z
    out[1, 2], out[2, 1] = -half * x, half * x
    out[2, 0], out[0, 2] = -half * y, half * y


@kernel
def inverse_tangent_so3(theta, out):
    """out (3, 3) with θ̇ = out ω: I − θ^/2 + θθᵀ/4."""
    x, y, z = theta[0], theta[1], theta[2]
    out[0, 0] = 1.0 + 0.25 * x * x
    out[1, 1] = 1.0 + 0.25 * y * y
    out[2, 2] = 1.0 + 0.25 * z * z
    out[0, 1], out[1, 0] = 0.25 * x * y + 0.5 * z, 0.25 * x * y - 0.5 * z
    out[1, 2], out[2, 1] = 0.25 * y * z + 0.5 * x, 0.25 * y * z - 0.5 * x
    out[2, 0], out[0, 2] = 0.25 * z * x + 0.5 * y, 0.25 * z * x - 0.5 * y


@kernel
def rate(theta, shift, velocity, omega, out):
    """out (6) = (ρ̇, θ̇) of a pose with p = ``shift`` that moves with (ṗ, ω).

    θ̇ = ω − θ × ω/2 + θ (θ·ω)/4 and, from p = (I − θ^/2)⁻¹ ρ, ρ̇ = ṗ − θ × ṗ/2 − θ̇ × p/2.
    """
    dot = theta[0] * omega[0] + theta[1] * omega[1] + theta[2] * omega[2]
    for k in range(3):
        k1, k2 = (k + 1) % 3, (k + 2) % 3
        turn = theta[k1] * omega[k2] - theta[k2] * omega[k1]
        out[3 + k] = omega[k] - 0.5 * turn + 0.25 * theta[k] * dot
    for k in range(3):
        k1, k2 = (k + 1) % 3, (k + 2) % 3
        turn = theta[k1] * velocity[k2] - theta[k2] * velocity[k1]
        lever = out[3 + k1] * shift[k2] - out[3 + k2] * shift[k1]
        out[k] = velocity[k] - 0.5 * turn - 0.5 * lever


@kernel
def tangent(theta, shift, out):
    """out (6, 6) with (ṗ, ω) = out (ρ̇, θ̇), at p = ``shift``."""
    out[:] = 0.0
    tangent_so3(theta, out[3:, 3:])
    column = np.empty(3)
    for k in range(3):
        column[:] = 0.0
        column[k] = 1.0
        half_inverse(theta, column, out[:3, k])
    for k in range(3):
        k1, k2 = (k + 1) % 3, (k + 2) % 3
        column[k] = 0.0
        column[k1], column[k2] = -0.5 * shift[k2], 0.5 * shift[k1]
        half_inverse(theta, column, out[:3, 3 + k])


@kernel
def inverse_tangent(theta, shift, out):
    """out (6, 6) with (ρ̇, θ̇) = out (ṗ, ω), at p = ``shift``: the linear map of :func:`rate`."""
    out[:] = 0.0
    inverse_tangent_so3(theta, out[3:, 3:])
    for k in range(3):
        k1, k2 = (k + 1) % 3, (k + 2) % 3
        out[k, k] = 1.0
        out[k, k1], out[k, k2] = 0.5 * theta[k2], -0.5 * theta[k1]
        for m in range(3):
            lever = out[3 + k1, 3 + m] * shift[k2] - out[3 + k2, 3 + m] * shift[k1]
            out[k, 3 + m] = -0.5 * lever


@kernel
def rate_derivative(theta, shift, velocity, omega, angular_rate, pose_tangent, out):
    """out (6, 6) = ∂(ρ̇, θ̇)/∂(ρ, θ) of :func:`rate` at fixed (ṗ, ω).

    ``angular_rate`` is θ̇ and ``pose_tangent`` the matrix of :func:`tangent`, whose upper rows
    say how p moves with the coordinates.
    """
    out[:] = 0.0
    dot = theta[0] * omega[0] + theta[1] * omega[1] + theta[2] * omega[2]
    for m in range(3):
        for k in range(3):
            out[3 + k, 3 + m] = 0.25 * theta[k] * omega[m]
        out[3 + m, 3 + m] += 0.25 * dot
        # −δθ × ω/2 with δθ along axis m
        m1, m2 = (m + 1) % 3, (m + 2) % 3
        out[3 + m1, 3 + m] += 0.5 * omega[m2]
        out[3 + m2, 3 + m] -= 0.5 * omega[m1]
        out[m1, 3 + m] += 0.5 * velocity[m2]
        out[m2, 3 + m] -= 0.5 * velocity[m1]
    for k in range(3):
        k1, k2 = (k + 1) % 3, (k + 2) % 3
        for m in range(6):
            lever = out[3 + k1, m] * shift[k2] - out[3 + k2, m] * shift[k1]
            lever += angular_rate[k1] * pose_tangent[k2, m] - angular_rate[k2] * pose_tangent[k1, m]
            out[k, m] -= 0.5 * lever


@kernel
def orthonormalise(frames):
    """Each frame F ← F + (I − F Fᵀ) F/2, twice: the nearest rotation of frames off by rounding."""
    excess = np.empty((3, 3))
    for frame in frames:
        for _ in range(2):
            for a in range(3):
                for b in range(3):
                    dot = frame[a, 0] * frame[b, 0] + frame[a, 1] * frame[b, 1]
                    dot += frame[a, 2] * frame[b, 2]
                    excess[a, b] = 0.5 * ((1.0 if a == b else 0.0) - dot)
            for k in range(3):
                x, y, z = frame[0, k], frame[1, k], frame[2, k]
                for a in range(3):
                    frame[a, k] += excess[a, 0] * x + excess[a, 1] * y + excess[a, 2] * z


@kernel
def rotation_between(a, b, out):
    """out (3, 3): the rotation by the smallest angle that takes the unit vector a to b.

    cay(θ) with θ = 2 a × b / (1 + a·b); singular only for opposite vectors.
    """
    theta = np.empty(3)
    cross(a, b, theta)
    theta *= 2.0 / (1.0 + a[0] * b[0] + a[1] * b[1] + a[2] * b[2])
    cayley(theta, out)
