"""Λ y = −y'''' − σ y'': a beam in a viscous fluid, clamped at 0, with a follower force σ at 1.

Lengths are in L, forces in κ/L² and rates in κ/ζL⁴, with the bending modulus κ and the drag ζ per
length. No moment acts on the free end, and no force across it but the drag h/2 of half a link that
the last sphere of a chain adds to the beam (h = 0: none):

    y = y' = 0 at 0,  y'' = 0 and y''' = (h/2) Λ y at 1.

y = Σ c_k exp(m_k s) with m⁴ + σ m² + Λ = 0 leaves a determinant of four rows, which vanishes at the
rates of the beam.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root

BECK = 20.0509536
"""σ at which the two slowest rates merge, that of the undamped column of M. Beck, Z. angew. Math.
Phys. 3, 225 (1952): without inertia −Λ takes the place of the square of the frequency."""


def determinant(rate: complex, force: float, extra: float = 0.0) -> complex:
    """0 at a rate Λ of the beam; analytic in Λ, and real where Λ is."""
    powers = np.roots([1.0, 0.0, force, 0.0, rate]).astype(complex)
    ends = np.exp(powers)
    rows = [
        np.ones(4),
        powers,
        powers**2 * ends,
        (powers**3 - 0.5 * extra * rate) * ends,
    ]
    differences = [powers[j] - powers[i] for i in range(4) for j in range(i)]
    return complex(np.linalg.det(np.array(rows)) / np.prod(differences))


def flutter(extra: float = 0.0) -> tuple[float, float]:
    """(σ, ω) at which a pair of rates ±iω crosses the imaginary axis."""

    def parts(unknown: NDArray[np.float64]) -> list[float]:
        value = determinant(1j * unknown[1], unknown[0], extra)
        return [value.real, value.imag]

    guess = [37.7 / (1.0 + extra), 191.0 / (1.0 + 2.0 * extra)]
    force, frequency = root(parts, guess, tol=1e-13).x
    return float(force), float(frequency)


def merging() -> float:
    """σ at which the two slowest rates, real and negative, merge: D = ∂D/∂Λ = 0."""

    def parts(unknown: NDArray[np.float64]) -> list[float]:
        force, rate = unknown
        step = 1e-4 * abs(rate)
        here = determinant(rate, force).real
        ahead, back = (determinant(rate + sign * step, force).real for sign in (1.0, -1.0))
        return [here, (ahead - back) / (2.0 * step)]

    return float(root(parts, [20.0, -121.0], tol=1e-12).x[0])
