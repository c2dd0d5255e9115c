"""r = r⁰ + u, R = cay(θ) R⁰: poses about a base, and how u and θ change with both.

If the pose changes by (u, φ) in the lab and the base by (u⁰, φ⁰),

    dθ = T⁻¹(θ) φ − T⁻¹(−θ) φ⁰,   T⁻¹(θ) = 1 − θ^/2 + θθᵀ/4,

with T⁻¹ as in :mod:`nrchain.geometry.lie`, for stacks of vectors (…, 3) here.
"""

from __future__ import annotations

import numpy as np

from nrchain.effects.base import cross_matrix


def chart(
    positions: np.ndarray, frames: np.ndarray, base: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """(u, θ) (…, N, 6) of poses (…, N, 3) and (…, N, 3, 3) about a base."""
    between = np.einsum("...nai,nak->...nik", frames, base[1])
    trace = np.einsum("...ii->...", between)
    axial = [between[..., 2, 1] - between[..., 1, 2], between[..., 0, 2] - between[..., 2, 0]]
    axial.append(between[..., 1, 0] - between[..., 0, 1])
    theta = np.stack(axial, axis=-1) * (2.0 / (1.0 + trace))[..., None]
    return np.concatenate([positions - base[0], theta], axis=-1)


def inverse_tangents(theta: np.ndarray) -> np.ndarray:
    """T⁻¹(θ) (k, 3, 3) of θ (k, 3)."""
    square = 0.25 * theta[:, :, None] * theta[:, None, :]
    return np.eye(3) - 0.5 * cross_matrix(theta) + square


def rate_derivatives(theta: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """∂(T⁻¹(θ) ω)/∂θ (k, 3, 3) at fixed ω (k, 3)."""
    dot = np.einsum("kp,kp->k", theta, omega)
    outer = theta[:, :, None] * omega[:, None, :] + dot[:, None, None] * np.eye(3)
    return 0.5 * cross_matrix(omega) + 0.25 * outer
