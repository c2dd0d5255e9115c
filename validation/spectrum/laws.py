"""Γψ̇ = −κψ″″ + iMψ‴ + (T(s) − P)ψ″, ψ = u_y + i u_z: a clamped rod with the stresses of its slip.

In the beam limit the chain is a rod of bending stiffness κ = μd and drag Γ = γ_T/d per length. With
nearest neighbours (paper, Appendix C)

    2s:  P = γ_T 7a²V/3d², a prestress that does not change along the rod;
    3a:  M = γ_T 13a³V/18d² · (1 + 3μ/λd²), with what links that shear add (study ``continuum``);
    3t:  f = γ_T 4a³V/5d⁴, a force per length along the tangent.

The ends hold the rod against f: its tension is T(s) = f (L/2 − s). The force f ψ′ of the turned
tangent cancels T′ψ′, and T ψ″ is left, which is not symmetric: the rod can flutter.

In units of L and of ΓL⁴/κ there are three numbers: p = PL²/κ, m = ML/κ and f̂ = fL³/κ. The rates
are eigenvalues of Chebyshev collocation, with the clamps ψ = ψ′ = 0 built in by ψ = (1 − x²) φ
(Trefethen, Spectral Methods in MATLAB, 2000, chapter 14).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

import nrchain

POINTS = 40
"""Chebyshev points: the first rates are exact to 1e-9."""

EULER = 4.0 * math.pi**2
"""p of a rod with clamped ends."""

GREENHILL = 2.0 * brentq(lambda x: math.sin(x) - x * math.cos(x), 4.0, 4.6)
"""m of a twisted shaft with clamped ends: 2x with tan x = x."""

MAGNITUDES = {"2s": 2, "3a": 1, "3t": 3}
"""By which power of 1/(N − 1) a strength falls at fixed p, m or f̂."""


@dataclass(frozen=True)
class Loads:
    """p, m and f̂ of a clamped rod."""

    p: float = 0.0
    m: float = 0.0
    f: float = 0.0


def per_strength(scene: nrchain.Scene, label: str) -> float:
    """p, m or f̂ of V = 1 of a mode."""
    chain, moduli = scene.chain, scene.moduli
    a, d = chain.radius, chain.spacing
    length, stiffness = scene.length, moduli.bend * d
    drag = scene.drag.translation
    if label == "2s":
        return drag * 7 * a**2 / (3 * d**2) * length**2 / stiffness
    if label == "3a":
        sheared = 1 + 3 * moduli.bend / (moduli.shear * d**2)
        return drag * 13 * a**3 / (18 * d**2) * sheared * length / stiffness
    return drag * 4 * a**3 / (5 * d**4) * length**3 / stiffness


def rates(loads: Loads) -> NDArray[np.complex128]:
    """Λ ΓL⁴/κ of the clamped rod, from the largest real part on."""
    x, second, third, fourth = _derivatives(POINTS)
    # s = (x + 1)/2 of unit length: each derivative is doubled, and T = f̂ (1/2 − s) = −f̂ x/2
    tension = np.diag(-0.5 * loads.f * x - loads.p)
    operator = -16.0 * fourth + 8.0j * loads.m * third + 4.0 * tension @ second
    found = np.linalg.eigvals(operator)
    return found[np.argsort(-found.real)].astype(complex)


def critical(loads: Loads, name: str, low: float, high: float) -> tuple[float, float]:
    """The value of ``p``, ``m`` or ``f`` at which the largest growth is zero, and |Im Λ| there."""

    def leading(value: float) -> complex:
        return complex(rates(Loads(**{**vars(loads), name: value}))[0])

    value = float(brentq(lambda v: leading(v).real, low, high, xtol=1e-12 * high))
    return value, abs(leading(value).imag)


def _derivatives(count: int) -> tuple[NDArray[np.float64], ...]:
    """x, D², D³ and D⁴ on inner points for functions (1 − x²) φ with φ = 0 at the ends.

    ψ = (1 − x²) φ has ψ = ψ′ = 0 where φ = 0 at ±1, with
    ψ″ = (1 − x²) φ″ − 4x φ′ − 2φ and so on.
    """
    x = np.cos(np.pi * np.arange(count + 1) / count)
    signs = np.where(np.arange(count + 1) % 2, -1.0, 1.0)
    signs[[0, -1]] *= 2.0
    apart = x[:, None] - x + np.eye(count + 1)
    first = np.outer(signs, 1.0 / signs) / apart
    first -= np.diag(first.sum(axis=1))
    powers = [np.linalg.matrix_power(first, k)[1:-1, 1:-1] for k in range(5)]
    inner = x[1:-1]
    weight, slope = np.diag(1.0 - inner**2), np.diag(inner)
    divide = np.diag(1.0 / (1.0 - inner**2))
    # φ = 0 at the ends: D² φ and so on act on inner values alone
    second = (weight @ powers[2] - 4.0 * slope @ powers[1] - 2.0 * powers[0]) @ divide
    third = (weight @ powers[3] - 6.0 * slope @ powers[2] - 6.0 * powers[1]) @ divide
    fourth = (weight @ powers[4] - 8.0 * slope @ powers[3] - 12.0 * powers[2]) @ divide
    return inner, second, third, fourth
