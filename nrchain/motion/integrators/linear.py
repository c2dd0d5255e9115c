"""(I − cJ) x = b for real and complex c: the linear systems of the implicit schemes.

J is the Jacobian of a chain in its coordinates. Interactions of near neighbours make it banded, and
its blocks are eliminated. Interactions of all pairs make it dense: only products with J are
computed, and GMRES solves the systems with the factors of the blocks near the diagonal as
preconditioner. Memory grows linearly with N in both cases.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from scipy.sparse import csc_matrix
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
    """J of near neighbours, eliminated by blocks."""

    def __init__(self, chain: ChartedChain) -> None:
        self._chain = chain

    def update(self, time: float, y: np.ndarray) -> None:
        self._chain.linearise(time, y)

    def matrix(self) -> csc_matrix:
        """J as a sparse matrix by columns."""
        return self._chain.near_jacobian()

    def shifted_inverse(self, scale: complex) -> Solve:
        kind = complex if isinstance(scale, complex) else float
        try:
            self._chain.factorise(scale)
        except FloatingPointError as error:
            raise SingularMatrix from error

        def solve(right: np.ndarray) -> np.ndarray:
            out = np.empty(self._chain.dimension, kind)
            self._chain.solve(right, out)
            return out

        return solve


class KrylovJacobian:
    """J of all pairs: its exact products, and the factors of its blocks near the diagonal.

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
