"""(P J P − σ)⁻¹: the eigenvalues of a long chain nearest to shifts σ on the axes.

The search starts at σ = 0, where the slow modes are, and goes out along the positive real axis to
the numerical abscissa ω(J), which no real part exceeds, and along the imaginary axis to the largest
frequency that the antisymmetric part of J allows. Every shift finds the eigenvalues in a disc about
it; the next shift is where its disc meets the last one.
"""

from __future__ import annotations

import numpy as np

from nrchain.states.bordered import Bordered
from nrchain.states.dense import in_order
from nrchain.states.relative import Point

NEAREST = 12
"""Eigenvalues that are computed about each shift."""

SHIFTS = 12
"""Most shifts on each axis."""

SAME = 1e-6
"""Relative difference of eigenvalues that two shifts find, below which they are one."""


def leading_rates(point: Point, number: int, abscissa: float) -> np.ndarray:
    """The eigenvalues found, from the largest real part on; at least ``number`` of them."""
    nearest = max(NEAREST, number)
    found, radius = _nearest(point, 0.0, nearest)
    frequency = _largest_frequency(point)
    for direction, end in ((1.0 + 0.0j, abscissa), (1j, frequency)):
        covered = radius
        for _ in range(SHIFTS):
            if covered >= end or not np.isfinite(covered):
                break
            shift = min(2.0 * covered, end)
            more, reached = _nearest(point, shift * direction, nearest)
            while shift - reached > covered * (1.0 + SAME) and shift > 1.05 * covered:
                # the discs leave a gap: begin the next one nearer
                shift = 0.5 * (shift + covered)
                more, reached = _nearest(point, shift * direction, nearest)
            found = _union(found, more)
            covered = max(shift + reached, 1.05 * covered)
    return in_order(np.concatenate([found, found[found.imag > 0.0].conj()]))


def numerical_abscissa(point: Point) -> float:
    """ω: the largest eigenvalue of the symmetric part of P J P of a long chain.

    It is the one nearest to any shift above it; the shift is raised until all found are below it.
    """
    from scipy.sparse.linalg import LinearOperator, eigsh

    near, basis, n = point.near, point.neutral, point.chain.dimension
    symmetric = _Symmetric(point, (near + near.T) * 0.5)
    shift = (
        float(np.abs(point.chain.model.twists(*point.poses)).max()) / point.chain.scene.chain.radius
    )
    shift = max(shift, 1e-6)
    for _ in range(40):
        solver = Bordered(symmetric, shift)  # type: ignore[arg-type]
        inverse = LinearOperator((n, n), matvec=solver.solve, dtype=float)
        begin = np.cos(np.arange(n) + 1.0)
        begin -= basis @ (basis.T @ begin)
        values = shift + 1.0 / eigsh(inverse, 4, v0=begin, return_eigenvectors=False, tol=1e-10)
        if values.max() < shift:
            return float(values.max())
        shift = 4.0 * float(values.max())
    return float(values.max())


class _Symmetric:
    """The symmetric part of J in place of J."""

    def __init__(self, point: Point, near: object) -> None:
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


def _nearest(point: Point, shift: complex, number: int) -> tuple[np.ndarray, float]:
    """The eigenvalues nearest to a shift, with Im ≥ 0, and the radius of the disc they fill."""
    from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs

    n, basis = point.chain.dimension, point.neutral
    real = complex(shift).imag == 0.0
    kind = float if real else complex
    solver = Bordered(point, shift)
    inverse = LinearOperator((n, n), matvec=solver.solve, dtype=kind)
    begin = np.cos(np.arange(n) + 1.0)
    begin = (begin - basis @ (basis.T @ begin)).astype(kind)
    try:
        values = eigs(inverse, number, v0=begin, return_eigenvectors=False, tol=1e-8)
    except ArpackNoConvergence as short:
        values = short.eigenvalues
    if not len(values):
        raise FloatingPointError(f"no eigenvalues are found near {shift:.3g}")
    distances = 1.0 / values
    rates = shift + distances
    if real:
        rates = np.where(np.abs(rates.imag) < 1e-12 * np.abs(rates), rates.real, rates)
    return rates[rates.imag >= 0.0], float(np.abs(distances).max())


def _union(known: np.ndarray, more: np.ndarray) -> np.ndarray:
    """Both, without the eigenvalues of ``more`` that are known as often."""
    left = list(known)
    out = list(known)
    for rate in more:
        near = [k for k, other in enumerate(left) if abs(other - rate) <= SAME * abs(rate)]
        if near:
            left.pop(near[0])
        else:
            out.append(rate)
    return np.array(out)
