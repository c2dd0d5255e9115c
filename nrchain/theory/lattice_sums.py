"""Σ_m cos(mθ)/m^s and Σ_m sin(mθ)/m^s, up to m = k or to infinity.

The infinite sums are the real and the imaginary part of the polylogarithm Li_s(e^{iθ}). For whole
s ≥ 1 and 0 < θ ≤ π, with ζ the zeta function and H_n = 1 + 1/2 + … + 1/n,

    Li_s(e^{iθ}) = Σ_{n ≠ s−1} ζ(s−n) (iθ)^n / n! + (iθ)^{s−1}/(s−1)! (H_{s−1} − ln θ + iπ/2).

Beyond n = s each term is smaller than the one before by a factor of at least four: sixty terms
reach double precision, at small θ without cancellation. Phases are reduced to (−π, π].
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nrchain.errors import SceneError

Reach = int | Literal["all"]
"""Number of neighbours on either side in a sum."""

TERMS = 60
"""Terms of the series beyond n = s; half of them vanish. π/2π to this power is below 1e-18."""

MOST_TERMS = 1_000_000
"""Largest number of neighbours that are summed term by term."""

STRIDE = 16.0
"""Pairs are evaluated at d, 16 d, 256 d, …, where the powers of the distance differ strongly."""

_CHUNK = 1 << 16


def cosine_sum(power: int, phases: ArrayLike, reach: Reach = "all") -> NDArray[np.float64]:
    """C_s(θ) = Σ_m cos(mθ)/m^s, in the shape of ``phases``; infinite for s = 1 at θ = 0."""
    theta = _reduce(phases)
    if reach != "all":
        return _direct(power, theta, reach, np.cos)
    if power == 1:
        with np.errstate(divide="ignore"):
            return -np.log(2.0 * np.sin(np.abs(theta) / 2.0))
    return power_sum(power) - cosine_defect(power, theta)


def cosine_defect(power: int, phases: ArrayLike, reach: Reach = "all") -> NDArray[np.float64]:
    """Σ_m (1 − cos mθ)/m^s for s ≥ 2, accurate relative to itself at small θ."""
    theta = _reduce(phases)
    if reach != "all":
        return _direct(power, theta, reach, lambda x: 2.0 * np.sin(x / 2.0) ** 2)
    coefficients = _coefficients(power)[2::2].copy()
    coefficients[::2] *= -1.0
    t = np.abs(theta)
    series = t**2 * np.polynomial.polynomial.polyval(t**2, coefficients)
    return -series - _logarithmic(power, t)[0]


def sine_sum(power: int, phases: ArrayLike, reach: Reach = "all") -> NDArray[np.float64]:
    """S_s(θ) = Σ_m sin(mθ)/m^s, in the shape of ``phases``; accurate relative to itself."""
    theta = _reduce(phases)
    if reach != "all":
        return _direct(power, theta, reach, np.sin)
    coefficients = _coefficients(power)[1::2].copy()
    coefficients[1::2] *= -1.0
    t = np.abs(theta)
    series = t * np.polynomial.polynomial.polyval(t**2, coefficients)
    return np.sign(theta) * (series + _logarithmic(power, t)[1])


def power_sum(power: int, reach: Reach = "all") -> float:
    """Σ_m 1/m^s: ζ(s), infinite for s ≤ 1, or its first terms."""
    if reach != "all":
        return float(_direct(power, np.zeros(()), reach, np.cos))
    from scipy.special import zeta

    return float(zeta(power)) if power > 1 else math.inf


def take_apart(samples: NDArray[np.float64], powers: list[int]) -> dict[int, NDArray[np.float64]]:
    """The coefficients c_s of Σ_s c_s m^−s, from its values at m = 1, 16, 256, …"""
    if not powers:
        return {}
    count = len(powers)
    strides = STRIDE ** np.arange(count)
    scale = strides ** powers[0]
    vandermonde = strides[:, None] ** (powers[0] - np.array(powers, float))
    flat = (samples[:count].reshape(count, -1).T * scale).T
    shares = np.linalg.solve(vandermonde, flat)
    return {p: c.reshape(samples.shape[1:]) for p, c in zip(powers, shares, strict=True)}


def _reduce(phases: ArrayLike) -> NDArray[np.float64]:
    """θ in [−π, π], and 0 exactly for whole turns of small phases."""
    theta = np.asarray(phases, float)
    return np.where(
        np.abs(theta) <= math.pi, theta, np.remainder(theta + math.pi, math.tau) - math.pi
    )


def _direct(
    power: int, theta: NDArray[np.float64], reach: int, term: Callable[[np.ndarray], np.ndarray]
) -> NDArray[np.float64]:
    """Σ_{m ≤ reach} term(mθ)/m^s, smallest terms first."""
    if reach > MOST_TERMS:
        allowed = f"must be at most {MOST_TERMS}; use 'all' for the sum over all neighbours"
        raise SceneError("neighbours", reach, allowed)
    total = np.zeros(theta.shape)
    step = max(1, _CHUNK // max(1, theta.size))
    for last in range(reach, 0, -step):
        m = np.arange(last, max(last - step, 0), -1.0)
        total += (term(theta[..., None] * m) * m**-power).sum(axis=-1)
    return total


@lru_cache(maxsize=32)
def _coefficients(power: int) -> NDArray[np.float64]:
    """ζ(s−n)/n! for n = 0, 1, …, without the term n = s−1, which the logarithm replaces."""
    from scipy.special import zeta

    row = np.zeros(power + TERMS)
    for n in range(power - 1):
        row[n] = zeta(power - n) / math.factorial(n)
    row[power] = -0.5 / math.factorial(power)
    for half in range(1, TERMS // 2 + 1):
        # ζ(1−2h) = 2 (−1)^h (2h−1)! ζ(2h) / (2π)^{2h}; ζ of even negative numbers vanishes
        n = power - 1 + 2 * half
        ratio = math.factorial(2 * half - 1) / math.factorial(n)
        row[n] = 2.0 * (-1.0) ** half * ratio * zeta(2 * half) / math.tau ** (2 * half)
    return row


def _logarithmic(
    power: int, t: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Real and imaginary part of (it)^{s−1}/(s−1)! (H_{s−1} − ln t + iπ/2), for t ≥ 0."""
    harmonic = sum(1.0 / n for n in range(1, power))
    size = t ** (power - 1) / math.factorial(power - 1)
    logarithm = size * (harmonic - np.log(np.where(t > 0.0, t, 1.0)))
    quarter = np.where(t > 0.0, size * (math.pi / 2.0), 0.0)
    real, imaginary = ((logarithm, quarter), (-quarter, logarithm))[(power - 1) % 2]
    sign = (-1.0) ** ((power - 1) // 2)
    return sign * real, sign * imaginary
