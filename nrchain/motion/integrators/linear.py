"""(I − cJ) x = b for real and complex c: the linear systems of the implicit schemes.

J is the Jacobian of the charted chain. What acts between near neighbours makes it banded, and it
is factorised in its band. What reaches further fills it: it is then only ever multiplied by, and
the systems are solved by GMRES with the factors of the band as preconditioner. Memory grows
linearly with N in either case.
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
"""What GMRES leaves of a preconditioned right-hand side. Newton's iteration, which asks for the
solutions, leaves about as much with a Jacobian that is a few steps old."""

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
        """b ↦ (I − scale · J)⁻¹ b, good until the next call with a scale of the same kind."""


class BandedJacobian:
    """J that couples near neighbours only, factorised in its band."""

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
    """J that couples all spheres: its exact products, and the factors of its band.

    Residuals are measured after preconditioning, where they are errors of the solution, and in
    ``units`` (dimension,) of the coordinates, of which only the ratios matter.
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
        """J · vector; of a complex vector, part by part."""
        if np.iscomplexobj(vector):
            return self._product(vector.real.copy()) + 1j * self._product(vector.imag.copy())
        out = np.empty_like(vector)
        self._chain.product(vector, out)
        return out


def jacobian_of(chain: ChartedChain, units: np.ndarray) -> BandedJacobian | KrylovJacobian:
    """The Jacobian of a chain by what acts between its spheres, with the units of y."""
    return BandedJacobian(chain) if chain.model.is_banded else KrylovJacobian(chain, units)
