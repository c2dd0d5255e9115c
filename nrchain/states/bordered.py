"""(J − σ) x + Q m = b, Qᵀ x = 0: linear systems of a chain modulo its motions as a whole.

J is singular along the motions Q that leave the law of the chain as it is. The border fixes the
gauge: x has no part along Q, and m takes up the part of b along J Q. Q spans a space that J maps to
itself, so that x = (P J P − σ)⁻¹ P b with P = 1 − Q Qᵀ, whatever J does within Q.

Matrices of near neighbours are factorised as sparse matrices, those of all pairs as dense ones.
Beyond that GMRES solves with products of J, preconditioned by the factors of near neighbours.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nrchain.states.relative import Point

Solve = Callable[[np.ndarray], np.ndarray]

ITERATIVE, ENOUGH = 1e-10, 1e-5
"""Relative residual that GMRES tries to reach after preconditioning, and one that is enough.

Stiff links amplify the rounding of products: slow modes are then known to the second."""

KRYLOV = 80
"""Dimension of the space that GMRES builds, and of its restarts."""


class Bordered:
    """Solves (J − σ) x + Q m = b with Qᵀ x = 0, and its adjoint, at one point.

    With ``by_products``, interactions of all pairs are taken by products, as for single solutions,
    and there is no adjoint. Otherwise their matrix is factorised up to
    :data:`nrchain.states.relative.DENSE` spheres.
    """

    def __init__(self, point: Point, shift: complex = 0.0, *, by_products: bool = False) -> None:
        self._point, self._shift = point, complex(shift)
        self._kind = complex if self._shift.imag else float
        if not self._shift.imag:
            self._shift = self._shift.real
        products = by_products and not point.is_banded
        matrix = None if products else point.matrix
        self.is_direct = matrix is not None
        near = point.near if matrix is None else matrix
        self._direct = _Factors(near, point.neutral, self._shift)

    def solve(self, right: np.ndarray) -> np.ndarray:
        """x (n,) or (n, k)."""
        if right.ndim == 2:
            return np.stack([self.solve(column) for column in right.T], axis=1)
        if self._kind is float and np.iscomplexobj(right):
            return self.solve(right.real.copy()) + 1j * self.solve(right.imag.copy())
        return self._direct.solve(right, "N") if self.is_direct else self._gmres(right)

    def solve_adjoint(self, right: np.ndarray) -> np.ndarray:
        """x of the conjugate transpose."""
        assert self.is_direct
        if right.ndim == 2:
            return np.stack([self.solve_adjoint(column) for column in right.T], axis=1)
        if self._kind is float and np.iscomplexobj(right):
            real, imaginary = (self.solve_adjoint(part.copy()) for part in (right.real, right.imag))
            return real + 1j * imaginary
        return self._direct.solve(right, "H")

    def _gmres(self, right: np.ndarray) -> np.ndarray:
        from scipy.sparse.linalg import LinearOperator, gmres

        basis, n = self._point.neutral, len(right)

        def shape(vector: np.ndarray) -> np.ndarray:
            return vector - basis @ (basis.T @ vector)

        def times(vector: np.ndarray) -> np.ndarray:
            vector = shape(vector)
            return shape(self._point.product(vector) - self._shift * vector)

        def preconditioned(vector: np.ndarray) -> np.ndarray:
            return self._direct.solve(times(vector), "N")

        operator = LinearOperator((n, n), matvec=preconditioned, dtype=self._kind)
        begin = self._direct.solve(shape(right), "N")
        found, left = gmres(operator, begin, rtol=ITERATIVE, atol=0.0, restart=KRYLOV, maxiter=10)
        if left and not np.linalg.norm(preconditioned(found) - begin) <= ENOUGH * np.linalg.norm(
            begin
        ):
            raise FloatingPointError("the linear system of all pairs does not converge")
        return shape(found)


class _Factors:
    """LU of [[J − σ, Q], [Qᵀ, 0]]."""

    def __init__(self, matrix: Any, basis: np.ndarray, shift: complex) -> None:
        self._n, self._border = matrix.shape[0], basis.shape[1]
        self._kind = complex if isinstance(shift, complex) else float
        self._sparse = not isinstance(matrix, np.ndarray)
        if self._sparse:
            self._factors = _sparse_factors(matrix, basis, shift)
        else:
            from scipy.linalg.lapack import get_lapack_funcs

            n = self._n
            whole = np.zeros((n + self._border,) * 2, self._kind)
            whole[:n, :n] = matrix
            whole[range(n), range(n)] -= shift
            whole[:n, n:], whole[n:, :n] = basis, basis.T
            (factorise,) = get_lapack_funcs(("getrf",), (whole,))
            factors, pivots, singular = factorise(whole, overwrite_a=True)
            if singular:
                raise FloatingPointError("the matrix of small changes is singular")
            self._factors = factors, pivots

    def solve(self, right: np.ndarray, kind: str) -> np.ndarray:
        """x of the matrix ("N") or of its conjugate transpose ("H")."""
        padded = np.zeros(self._n + self._border, self._kind)
        padded[: self._n] = right
        if self._sparse:
            return self._factors.solve(padded, kind)[: self._n]
        from scipy.linalg import lu_solve

        trans = 0 if kind == "N" else 2
        return lu_solve(self._factors, padded, trans=trans, check_finite=False)[: self._n]


def _sparse_factors(matrix: Any, basis: np.ndarray, shift: complex) -> Any:
    from scipy.sparse import block_array, csc_array, eye_array
    from scipy.sparse.linalg import splu

    shifted = matrix - shift * eye_array(matrix.shape[0], format="csc")
    if basis.shape[1]:
        edge = csc_array(basis)
        shifted = block_array([[shifted, edge], [edge.T, None]])
    kind = complex if isinstance(shift, complex) else float
    try:
        return splu(shifted.tocsc().astype(kind))
    except RuntimeError as error:
        raise FloatingPointError(f"the matrix of small changes is singular: {error}") from None
