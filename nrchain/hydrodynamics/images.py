"""Σ_{p>P} g(p) = Σ_q W_q g(p_q): a few images stand for all distant ones of a periodic chain.

At the chain, the flow of its p-th image is a smooth function of 1/p. Its expansion begins at
(1/p)²: lower orders cancel between the images on both sides, or because the forces of an image
cancel. The sum over all images beyond P is therefore a Gaussian quadrature in s = 1/p for the
measure Σ_{p>P} p⁻² δ(s − 1/p): Q images at fractional distances p_q, with strengths multiplied by
W_q, give every power p⁻² … p^−(2Q+1) exactly. The flow is analytic in s up to s = 1, because it is
needed within one chain length only. With P = 2 and Q = 6 the error is of order 1e-12 of the sum
beyond P.

Quadrature from moments: Gautschi, *Orthogonal Polynomials*, Sec. 2.1.7 (the Chebyshev algorithm, in
the precision it needs).
"""

from __future__ import annotations

import decimal
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cache

import numpy as np

EXACT = 2
"""P: images on either side that are summed one by one."""

POINTS = 6
"""Q: images on either side that stand for all others."""

_DIGITS = 100


@dataclass(frozen=True)
class Layout:
    """Spheres and their images, in the order of the sums over pairs.

    Slot s holds sphere ``spheres[s]``, displaced by ``shifts[s]`` along x, with its strength
    multiplied by ``weights[s]``; sphere i itself is in slot ``first + i``. A sphere feels the
    slots within ``reach`` of its own.
    """

    spheres: np.ndarray
    shifts: np.ndarray
    weights: np.ndarray
    first: int
    reach: int

    @classmethod
    def of(cls, count: int, reach: int | None, period: float) -> Layout:
        """Lay out ``count`` spheres for a reach in neighbours (None: all) and a period.

        A period of 0 is an open chain. A finite reach continues a periodic chain by that many
        spheres on either side. For all pairs its images continue it, with a few for the distant
        ones (see :func:`image_offsets`).
        """
        chain = np.arange(count)
        if not period:
            places = count - 1 if reach is None else min(reach, count - 1)
            return cls(chain, np.zeros(count), np.ones(count), 0, places)
        if reach is not None:
            slots = np.arange(-reach, count + reach)
            shifts = period * (slots // count)
            return cls(slots % count, shifts, np.ones(len(slots)), reach, reach)
        offsets, weights = image_offsets()
        half = len(offsets) // 2
        offsets, weights = (np.insert(v, half, own) for v, own in ((offsets, 0.0), (weights, 1.0)))
        return cls(
            np.tile(chain, len(offsets)),
            np.repeat(period * offsets, count),
            np.repeat(weights, count),
            half * count,
            count * len(offsets),
        )


@cache
def image_offsets(exact: int = EXACT, points: int = POINTS) -> tuple[np.ndarray, np.ndarray]:
    """Offsets, in periods, and weights of the images on both sides, without the chain itself.

    Both have shape (2 (exact + points),), sorted by offset.
    """
    distances, weights = _quadrature(exact, points)
    distances = np.concatenate([np.arange(1.0, exact + 1), distances])
    weights = np.concatenate([np.ones(exact), weights])
    order = np.argsort(distances)
    distances, weights = distances[order], weights[order]
    return (
        np.concatenate([-distances[::-1], distances]),
        np.concatenate([weights[::-1], weights]),
    )


def _quadrature(beyond: int, points: int) -> tuple[np.ndarray, np.ndarray]:
    """Distances p_q and weights W_q of the Gaussian quadrature for Σ_{p>P}."""
    from scipy.linalg import eigh_tridiagonal

    with decimal.localcontext() as context:
        context.prec = _DIGITS
        moments = [_hurwitz(2 + j, beyond + 1) for j in range(2 * points)]
        diagonal, squares = _chebyshev(moments)
        total = float(moments[0])
        alpha = np.array([float(x) for x in diagonal])
        beta = np.array([float(x.sqrt()) for x in squares[1:]])
    nodes, vectors = eigh_tridiagonal(alpha, beta)
    return 1.0 / nodes, total * vectors[0] ** 2 / nodes**2


def _hurwitz(power: int, start: int) -> Decimal:
    """Σ_{p≥start} p^−power by Euler's and Maclaurin's formula from p = 60 on, to 50 digits."""
    switch = max(60, start)
    total = sum((Decimal(p) ** -power for p in range(start, switch)), Decimal(0))
    x = Decimal(switch)
    total += x ** (1 - power) / (power - 1) + x**-power / 2
    rising, factorial = Decimal(1), Decimal(1)
    for k in range(1, 25):
        first = 2 * k - 2
        rising *= (power + first - 1 if k > 1 else 1) * Decimal(power + first)
        factorial *= (2 * k - 1) * (2 * k)
        bernoulli = _bernoulli(2 * k)
        coefficient = Decimal(bernoulli.numerator) / Decimal(bernoulli.denominator) / factorial
        total += coefficient * rising * x ** -(power + 2 * k - 1)
    return total


@cache
def _bernoulli(n: int) -> Fraction:
    """The Bernoulli number B_n, by the triangle of Akiyama and Tanigawa."""
    row = [Fraction(1, k + 1) for k in range(n + 1)]
    for k in range(1, n + 1):
        row = [(j + 1) * (row[j] - row[j + 1]) for j in range(n + 1 - k)]
    return row[0]


def _chebyshev(moments: list[Decimal]) -> tuple[list[Decimal], list[Decimal]]:
    """Recurrence coefficients of the orthogonal polynomials that have these moments."""
    size = len(moments) // 2
    before = [Decimal(0)] * len(moments)
    now = list(moments)
    alpha, beta = [moments[1] / moments[0]], [moments[0]]
    for k in range(1, size):
        new = [Decimal(0)] * len(moments)
        for j in range(k, len(moments) - k):
            new[j] = now[j + 1] - alpha[-1] * now[j] - beta[-1] * before[j]
        alpha.append(new[k + 1] / new[k] - now[k] / now[k - 1])
        beta.append(new[k] / now[k - 1])
        before, now = now, new
    return alpha, beta
