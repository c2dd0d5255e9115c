"""(P J P − σ)⁻¹: the eigenvalues of a long chain nearest to shifts σ on the axes.

The search starts at σ = 0, where the slow modes are, and goes out along the positive real axis to
the numerical abscissa ω(J), which no real part exceeds, and along the imaginary axis to the largest
frequency that the antisymmetric part of J allows. Every shift finds the eigenvalues in a disc about
it; the next shift is where its disc meets the last one.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nrchain.comoving.bordered import Bordered
from nrchain.comoving.dense import in_order
from nrchain.comoving.relative import Point

NEAREST = 12
"""Eigenvalues that are computed about each shift."""

SHIFTS, RESTARTS, ACCURACY = (20, 3), (30, 4), (1e-9, 1e-5)
"""Most shifts, most restarts of the iteration about each, and the relative accuracy of 1/(Λ − σ) at
which it ends: with factors, and with products of all pairs."""

EDGE = 1e-4
"""The discs are smaller than the distance of the last eigenvalue by this fraction."""

APPROACH = 0.1
"""By this factor a shift comes nearer to the largest eigenvalue."""


def leading_rates(point: Point, number: int, abscissa: float) -> np.ndarray:
    """The eigenvalues found, from the largest real part on; at least ``number`` of them."""
    search = _Search(point, max(NEAREST, number))
    most = SHIFTS[point.matrix is None]
    covered = search.look(0.0)
    for direction, end in ((1.0 + 0.0j, abscissa), (1j, _largest_frequency(point))):
        reached = covered
        while reached < end and search.shifts < most:
            shift = min(2.0 * reached, end)
            radius = search.look(shift * direction)
            if not radius:
                break
            while radius and shift - radius > reached and search.shifts < most:
                # the discs leave a gap: the next one lies nearer
                shift = 0.5 * (shift + reached)
                radius = search.look(shift * direction)
            reached = max(shift + radius, 1.05 * reached)
    if not search.found:
        raise FloatingPointError("no eigenvalues are found near zero")
    found = np.array(search.found)
    return in_order(np.concatenate([found, found[found.imag > 0.0].conj()]))


class _Search:
    """The eigenvalues with Im ≥ 0 in the discs that were searched so far."""

    def __init__(self, point: Point, nearest: int) -> None:
        self._point, self._nearest = point, nearest
        self._discs: list[tuple[complex, float]] = []
        self.found: list[complex] = []
        self.shifts = 0

    def look(self, shift: complex) -> float:
        """Search the disc of the eigenvalues nearest to a shift; returns its radius."""
        self.shifts += 1
        rates = _nearest(self._point, shift, self._nearest)
        if not len(rates):
            # far from all eigenvalues none is nearest
            return 0.0
        distances = np.abs(rates - shift)
        # the farthest may have a partner that was not found
        radius = (1.0 - EDGE) * float(distances.max())
        if distances.min() >= radius:
            radius = (1.0 + EDGE) * float(distances.max())
        for rate in rates[(distances < radius) & (rates.imag >= 0.0)]:
            if all(abs(rate - center) >= size for center, size in self._discs):
                self.found.append(complex(rate))
        self._discs += [(complex(shift), radius), (complex(shift).conjugate(), radius)]
        return radius


def numerical_abscissa(point: Point) -> float:
    """ω: the largest eigenvalue of the symmetric part of P J P of a long chain.

    A shift above all eigenvalues comes down to a tenth of its distance from the largest, until it
    is near. With interactions of all pairs, those of near neighbours alone.
    """
    near = point.near
    symmetric = _Symmetric(point, (near + near.T) * 0.5)
    shift = float(abs(symmetric.near).sum(axis=0).max()) + 1e-300
    least = shift * 1e-12
    while True:
        largest = _largest_below(symmetric, shift, 1e-2)
        if shift - largest <= max(0.1 * abs(largest), least):
            return _largest_below(symmetric, shift, 1e-9)
        shift = largest + APPROACH * (shift - largest)


def _largest_below(symmetric: _Symmetric, shift: float, tolerance: float) -> float:
    """The eigenvalue nearest to a shift above all, to a part of its distance."""
    from scipy.sparse.linalg import LinearOperator, eigsh

    n, basis = symmetric.near.shape[0], symmetric.neutral
    solver = Bordered(symmetric, shift)  # type: ignore[arg-type]
    inverse = LinearOperator((n, n), matvec=solver.solve, dtype=float)
    begin = np.cos(np.arange(n) + 1.0)
    begin -= basis @ (basis.T @ begin)
    found = eigsh(inverse, 1, which="SA", v0=begin, return_eigenvectors=False, tol=tolerance)
    return float(shift + 1.0 / found[0])


class _Symmetric:
    """The symmetric part of J in place of J."""

    def __init__(self, point: Point, near: Any) -> None:
        self.near, self.neutral, self.chain = near, point.neutral, point.chain
        self.matrix = near


def _largest_frequency(point: Point) -> float:
    """The largest eigenvalue of (J − Jᵀ)/2i, near neighbours alone."""
    from scipy.sparse.linalg import LinearOperator, eigsh

    near, n = point.near, point.chain.dimension
    turning = (near - near.T) * 0.5
    if not abs(turning).max():
        return 0.0
    operator = LinearOperator((n, n), matvec=lambda v: -1j * (turning @ v), dtype=complex)
    begin = np.cos(np.arange(n) + 1.0).astype(complex)
    values = eigsh(operator, 1, which="LA", v0=begin, tol=1e-2, return_eigenvectors=False)
    return float(values.max())


def _nearest(point: Point, shift: complex, number: int) -> np.ndarray:
    """The eigenvalues nearest to a shift."""
    from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs

    n, basis = point.chain.dimension, point.neutral
    kind = complex if complex(shift).imag else float
    solver = Bordered(point, shift)
    inverse = LinearOperator((n, n), matvec=solver.solve, dtype=kind)
    begin = np.cos(np.arange(n) + 1.0)
    begin = (begin - basis @ (basis.T @ begin)).astype(kind)
    by_products = not solver.is_direct
    number = min(number, n - basis.shape[1] - 2)
    try:
        values = eigs(
            inverse,
            number,
            v0=begin,
            ncv=min((2 if by_products else 4) * number + 6, n - basis.shape[1]),
            return_eigenvectors=False,
            tol=ACCURACY[by_products],
            maxiter=RESTARTS[by_products],
        )
    except ArpackNoConvergence as short:
        values = short.eigenvalues
    rates = np.asarray(shift + 1.0 / values, complex)
    if kind is float:
        rates = np.where(np.abs(rates.imag) < 1e-12 * np.abs(rates), rates.real, rates)
    return rates
