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


def gmres_solution(
    product: Solve, precondition: Solve, units: np.ndarray, scale: complex, right: np.ndarray
) -> np.ndarray:
    """(I − scale · J)⁻¹ right by GMRES, from products of J with real vectors.

    Residuals are measured after preconditioning, as errors of the solution, in ``units`` of the
    coordinates, of which only ratios have an effect.
    """

    def times(vector: np.ndarray) -> np.ndarray:
        if np.iscomplexobj(vector):
            return product(vector.real.copy()) + 1j * product(vector.imag.copy())
        return product(vector)

    def multiply(scaled: np.ndarray) -> np.ndarray:
        change = units * scaled.ravel()
        return precondition(change - scale * times(change)) / units

    operator = LinearOperator((len(units), len(units)), matvec=multiply, dtype=type(scale))
    target = precondition(right) / units
    found, _ = gmres(operator, target, rtol=RESIDUAL, restart=KRYLOV_DIMENSION, maxiter=1)
    return units * found


class KrylovJacobian:
    """J of all pairs: its exact products, and the factors of its blocks near the diagonal.

    ``units`` (dimension,) are those of the coordinates.
    """

    def __init__(self, chain: ChartedChain, units: np.ndarray) -> None:
        self._chain, self._near, self._units = chain, BandedJacobian(chain), units

    def update(self, time: float, y: np.ndarray) -> None:
        self._near.update(time, y)

    def shifted_inverse(self, scale: complex) -> Solve:
        precondition, units = self._near.shifted_inverse(scale), self._units
        return lambda right: gmres_solution(self._product, precondition, units, scale, right)

    def _product(self, vector: np.ndarray) -> np.ndarray:
        """J · vector, for a real vector."""
        out = np.empty_like(vector)
        self._chain.product(vector, out)
        return out


def jacobian_of(chain: ChartedChain, units: np.ndarray) -> BandedJacobian | KrylovJacobian:
    """The banded or matrix-free Jacobian of a chain, with the units of y."""
    return BandedJacobian(chain) if chain.model.is_banded else KrylovJacobian(chain, units)
