"""(I − cJ) x = b for real and complex c: the linear systems of the implicit schemes.

J is the Jacobian of a chain in its coordinates. Interactions of near neighbours make it banded, and
its band is factorised. Interactions of all pairs make it dense: only products with J are computed,
and GMRES solves the systems with the factors of the band as preconditioner. Memory grows linearly
with N in both cases.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from scipy.linalg import lapack
from scipy.sparse import csc_matrix, dia_matrix
from scipy.sparse.linalg import LinearOperator, gmres

from nrchain.motion.charts import ChartedChain

RESIDUAL = 1e-3
"""Relative residual of GMRES, after preconditioning. Newton's iteration with a Jacobian of a few
steps before has a similar error."""

KRYLOV_DIMENSION = 40
"""Upper bound on the iterations of one linear solve."""

Solve = Callable[[np.ndarray], np.ndarray]


class SingularMatrix(Exception):
    """I − cJ has no inverse at this c."""


class Jacobian(Protocol):
    """J at the point last passed to ``update``."""

    def update(self, time: float, y: np.ndarray) -> None:
        """Take J at (time, y)."""

    def shifted_inverse(self, scale: complex) -> Solve:
        """b ↦ (I − scale · J)⁻¹ b, valid until the next call with a scale of the same type."""


class BandedJacobian:
    """J of near neighbours, factorised in its band."""

    def __init__(self, chain: ChartedChain) -> None:
        self._chain = chain
        shape = 3 * chain.bandwidth + 1, chain.dimension
        self._shape, self._bands = shape, dict[type, np.ndarray]()

    def update(self, time: float, y: np.ndarray) -> None:
        self._chain.linearise(time, y)

    def _band(self, shift: complex, scale: complex) -> np.ndarray:
        kind = type(scale)
        if kind not in self._bands:
            self._bands[kind] = np.empty(self._shape, kind, order="F")
        self._chain.fill_band(self._bands[kind], kind(shift), scale)
        return self._bands[kind]

    def matrix(self) -> csc_matrix:
        """J as a sparse matrix by columns."""
        width = self._chain.bandwidth
        diagonals = np.arange(width, -width - 1, -1)
        band = self._band(0.0, 1.0)[width:]
        return dia_matrix((band, diagonals), shape=2 * (self._chain.dimension,)).tocsc()

    def shifted_inverse(self, scale: complex) -> Solve:
        width = self._chain.bandwidth
        band = self._band(1.0, -scale)
        factorise, substitute = lapack.get_lapack_funcs(("gbtrf", "gbtrs"), (band,))
        factors, pivots, info = factorise(band, width, width, overwrite_ab=True)
        if info > 0:
            raise SingularMatrix
        return lambda right: substitute(factors, width, width, right, pivots)[0]


class KrylovJacobian:
    """J of all pairs: its exact products, and the factors of its band.

    Residuals are measured after preconditioning, as errors of the solution, in ``units``
    (dimension,) of the coordinates, of which only ratios have an effect.
    """

    def __init__(self, chain: ChartedChain, units: np.ndarray) -> None:
        self._chain, self._near, self._units = chain, BandedJacobian(chain), units

    def update(self, time: float, y: np.ndarray) -> None:
        self._near.update(time, y)

    def shifted_inverse(self, scale: complex) -> Solve:
        precondition, kind = self._near.shifted_inverse(scale), type(scale)
        size, units = len(self._units), self._units

        def multiply(scaled: np.ndarray) -> np.ndarray:
            change = units * scaled.ravel()
            return precondition(change - scale * self._product(change)) / units

        operator = LinearOperator((size, size), matvec=multiply, dtype=kind)

        def solve(right: np.ndarray) -> np.ndarray:
            target = precondition(right) / units
            found, _ = gmres(operator, target, rtol=RESIDUAL, restart=KRYLOV_DIMENSION, maxiter=1)
            return units * found

        return solve

    def _product(self, vector: np.ndarray) -> np.ndarray:
        """J · vector, for real and complex vectors."""
        if np.iscomplexobj(vector):
            return self._product(vector.real.copy()) + 1j * self._product(vector.imag.copy())
        out = np.empty_like(vector)
        self._chain.product(vector, out)
        return out


def jacobian_of(chain: ChartedChain, units: np.ndarray) -> BandedJacobian | KrylovJacobian:
    """The banded or matrix-free Jacobian of a chain, with the units of y."""
    return BandedJacobian(chain) if chain.model.is_banded else KrylovJacobian(chain, units)
