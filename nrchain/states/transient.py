"""ω(J) and max_t ‖exp(J t)‖: how far a stable chain amplifies small changes of its shape.

The norm is that of :mod:`nrchain.comoving.relative`: √(Σ |u_i|² + (4a²/3) |φ_i|²) over changes of
shape, in which passive chains with one-body friction decay from the start. ω(J), the numerical
abscissa, is the largest growth rate of the norm at t = 0. Where modes are not orthogonal, small
changes may grow for a while although every mode decays.

The exponential is computed in Schur form, J = U T Uᴴ with decaying rates last. At time t the rates
that have decayed by exp(−40) are split off with the solution of a Sylvester equation, and the rest
is a small exponential:

    exp(T t) = [E, −E R; 0, 0],   E = exp(T₁₁ t),   T₁₁ R − R T₂₂ = −T₁₂.
"""

from __future__ import annotations

import copy
import math
from typing import NamedTuple

import numpy as np

from nrchain.comoving.dense import parts, shape_matrix
from nrchain.comoving.relative import Point

SPHERES = 500
"""Spheres of the longest chain whose exponential is computed."""

LARGEST_PART = 1500
"""Largest matrix whose exponential is computed; it takes a minute."""

DECAYED = 40.0
"""Rates with Re Λ t below minus this have no effect on the norm."""

FACTOR = 1.4
"""Between times at which the norm is sampled first."""

FIRST, SETTLED = 1e-2, 10.0
"""The first of these times, over 1/ω, and the last, over the decay time of the slowest mode."""


class Transient(NamedTuple):
    """The largest ‖exp(J t)‖ and its time; infinite if the chain is unstable."""

    growth: float
    time: float


def numerical_abscissa(matrix: np.ndarray) -> float:
    """The largest eigenvalue of the symmetric part."""
    from scipy.linalg import eigvalsh

    found = []
    for part in parts(matrix):
        own = matrix[np.ix_(part, part)]
        last = len(part) - 1
        found.append(eigvalsh(0.5 * (own + own.T), subset_by_index=[last, last])[0])
    return float(max(found))


def transient_growth(point: Point, leading: float, abscissa: float) -> Transient | None:
    """The largest transient growth of a chain whose leading rate and ω are given.

    None for more than :data:`SPHERES`, or if parts of the matrix are larger than
    :data:`LARGEST_PART`.
    """
    if leading >= 0.0:
        return Transient(math.inf, math.inf)
    if abscissa <= 0.0:
        return Transient(1.0, 0.0)
    if point.chain.model.count > SPHERES:
        return None
    matrix = shape_matrix(point)
    pieces = parts(matrix)
    if max(map(len, pieces)) > LARGEST_PART:
        return None
    norms = [_Norm(matrix[np.ix_(part, part)]) for part in pieces if len(part) > 1]
    return max((_largest(norm, abscissa) for norm in norms), default=Transient(1.0, 0.0))


class _Norm:
    """t ↦ ‖exp(J t)‖ of one matrix."""

    def __init__(self, matrix: np.ndarray) -> None:
        from scipy.linalg import schur

        self._form = schur(matrix, output="complex", check_finite=False)[0]
        self._kept = len(matrix)
        self._tail = np.zeros((self._kept, 0), complex)
        self.slowest = float(np.diag(self._form).real.max())

    def __call__(self, time: float) -> float:
        """‖exp(J t)‖₂; times do not decrease by more than the factor between samples."""
        from scipy.linalg import expm

        self._shorten(time / FACTOR**2)
        grown = expm(self._form * time)
        if self._tail.shape[1]:
            grown = np.hstack([grown, -grown @ self._tail])
        gram = grown @ grown.conj().T
        return math.sqrt(max(float(np.linalg.eigvalsh(gram)[-1]), 0.0))

    def copy(self) -> _Norm:
        """The norm as it is now, for times from that of the last call over the factor on."""
        return copy.copy(self)

    def _shorten(self, time: float) -> None:
        """Split off the rates that have decayed at this time."""
        from scipy.linalg import schur, solve_sylvester

        limit = -DECAYED / time
        rates = np.diag(self._form).real
        keep = int(np.count_nonzero(rates > limit))
        if keep > 0.9 * len(rates):
            return
        form, turn, keep = schur(self._form, output="complex", sort=lambda rate: rate.real > limit)
        slow, fast = form[:keep, :keep], form[keep:, keep:]
        if self._tail.shape[1]:
            tail = turn.conj().T @ self._tail
            slow_tail = tail[:keep]
            rest = solve_sylvester(slow, -fast, -form[:keep, keep:])
            # [E, −E R] [1, −tail] with the fast rows gone
            self._tail = np.hstack([rest, slow_tail - rest @ tail[keep:]])
        else:
            self._tail = solve_sylvester(slow, -fast, -form[:keep, keep:])
        self._form = slow


def _largest(norm: _Norm, abscissa: float) -> Transient:
    """The largest norm of one part: sampled to the decay of the slowest mode, then refined."""
    from scipy.optimize import minimize_scalar

    if norm.slowest >= 0.0:
        return Transient(math.inf, math.inf)
    time, best, at, kept = FIRST / abscissa, 1.0, 0.0, norm
    while time < SETTLED / -norm.slowest:
        value = norm(time)
        if value > best:
            best, at, kept = value, time, norm.copy()
        time *= FACTOR
    if at == 0.0:
        return Transient(1.0, 0.0)
    bounds = math.log(at / FACTOR), math.log(at * FACTOR)
    found = minimize_scalar(
        lambda x: -kept(math.exp(x)), bounds=bounds, method="bounded", options={"xatol": 1e-4}
    )
    return Transient(max(best, -float(found.fun)), math.exp(found.x))
