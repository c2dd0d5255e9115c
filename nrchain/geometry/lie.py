"""R = cay(θ) = (I − θ^/2)⁻¹ (I + θ^/2): rotations by the Cayley map.

θ^ is the matrix of v ↦ θ × v. A rotation by the angle α about the unit vector k has
θ = 2 tan(α/2) k: the map is rational, needs no series at small angles and is singular only at a
half turn. Tangents are left-trivialised in the lab: Ṙ = ω^ R. See Iserles et al., Acta Numerica 9
(2000), Sec. 8.3.
"""

from __future__ import annotations

import numpy as np

from nrchain._compile import kernel


@kernel(alone=True)
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
def tangent(theta, out):
    """out (3, 3) with ω = out θ̇: (I + θ^/2) / (1 + θ²/4)."""
    x, y, z = theta[0], theta[1], theta[2]
    inverse = 1.0 / (1.0 + 0.25 * (x * x + y * y + z * z))
    half = 0.5 * inverse
    out[0, 0] = out[1, 1] = out[2, 2] = inverse
    out[0, 1], out[1, 0] = -half * z, half * z
    out[1, 2], out[2, 1] = -half * x, half * x
    out[2, 0], out[0, 2] = -half * y, half * y


@kernel
def inverse_tangent(theta, out):
    """out (3, 3) with θ̇ = out ω: I − θ^/2 + θθᵀ/4."""
    x, y, z = theta[0], theta[1], theta[2]
    out[0, 0] = 1.0 + 0.25 * x * x
    out[1, 1] = 1.0 + 0.25 * y * y
    out[2, 2] = 1.0 + 0.25 * z * z
    out[0, 1], out[1, 0] = 0.25 * x * y + 0.5 * z, 0.25 * x * y - 0.5 * z
    out[1, 2], out[2, 1] = 0.25 * y * z + 0.5 * x, 0.25 * y * z - 0.5 * x
    out[2, 0], out[0, 2] = 0.25 * z * x + 0.5 * y, 0.25 * z * x - 0.5 * y


@kernel
def rate(theta, omega, out):
    """out (3) = θ̇ = ω − θ × ω/2 + θ (θ·ω)/4 of a frame with angular velocity ω."""
    dot = theta[0] * omega[0] + theta[1] * omega[1] + theta[2] * omega[2]
    for k in range(3):
        k1, k2 = (k + 1) % 3, (k + 2) % 3
        turn = theta[k1] * omega[k2] - theta[k2] * omega[k1]
        out[k] = omega[k] - 0.5 * turn + 0.25 * theta[k] * dot


@kernel
def rate_derivative(theta, omega, out):
    """out (3, 3) = ∂θ̇/∂θ of :func:`rate` at fixed ω."""
    dot = theta[0] * omega[0] + theta[1] * omega[1] + theta[2] * omega[2]
    for m in range(3):
        m1, m2 = (m + 1) % 3, (m + 2) % 3
        for k in range(3):
            out[k, m] = 0.25 * theta[k] * omega[m]
        out[m, m] += 0.25 * dot
        # −δθ × ω/2 with δθ along axis m
        out[m1, m] += 0.5 * omega[m2]
        out[m2, m] -= 0.5 * omega[m1]


@kernel(alone=True)
def orthonormalise(frames):
    """Each frame F ← F + (I − F Fᵀ) F/2, twice: the nearest rotation."""
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
