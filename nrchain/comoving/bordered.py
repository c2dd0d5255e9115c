"""(J − σ) x + Q m = b, Qᵀ x = 0: linear systems of a chain modulo its motions as a whole.

J is singular along the motions Q that leave the law of the chain as it is. The border fixes the
gauge: x has no part along Q, and m takes up the part of b along J Q. Q spans a space that J maps to
itself, so that x = (P J P − σ)⁻¹ P b with P = 1 − Q Qᵀ, whatever J does within Q.

With an edge (c, r, κ), one more number p is unknown: (J − σ) x + Q m + c p = b, Qᵀ x = 0 and
r·x + κ p = q. Such systems are regular at folds, where J is not.

Matrices of near neighbours are factorised as sparse matrices, those of all pairs as dense ones.
Beyond that GMRES solves with products of J, preconditioned by the factors of near neighbours.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from nrchain.comoving.relative import Point

Solve = Callable[[np.ndarray], np.ndarray]

ITERATIVE, ENOUGH = 1e-10, 1e-5
"""Relative residual that GMRES tries to reach after preconditioning, and one that is enough.

Stiff links amplify the rounding of products: slow modes are then known to the second."""

KRYLOV = 80
"""Dimension of the space that GMRES builds, and of its restarts."""


class Edge(NamedTuple):
    """c (n,), r (n,) and κ: a further column, row and corner, for a further unknown."""

    column: np.ndarray
    row: np.ndarray
    corner: float


class Bordered:
    """Solves (J − σ) x + Q m = b with Qᵀ x = 0, and its adjoint, at one point.

    With an ``edge``, :meth:`solve_with` solves for one more unknown. With ``by_products``,
    interactions of all pairs are taken by products, as for single solutions, and there is no
    adjoint. Otherwise their matrix is factorised up to :data:`nrchain.comoving.relative.DENSE`
    spheres.
    """

    def __init__(
        self,
        point: Point,
        shift: complex = 0.0,
        *,
        by_products: bool = False,
        edge: Edge | None = None,
    ) -> None:
        self._point, self._shift, self._edge = point, complex(shift), edge
        self._kind = complex if self._shift.imag else float
        if not self._shift.imag:
            self._shift = self._shift.real
        products = by_products and not point.has_blocks
        matrix = None if products else point.matrix
        self.is_direct = matrix is not None
        near = point.near if matrix is None else matrix
        self._direct = _Factors(near, point.neutral, self._shift, edge)

    def solve_with(self, right: np.ndarray, last: float) -> tuple[np.ndarray, float]:
        """x (n,) and p of b = ``right`` and q = ``last``, with an edge."""
        whole = np.append(right, last)
        found = self._direct.solve(whole, "N") if self.is_direct else self._gmres(whole)
        return found[:-1], float(found[-1])

    def solve(self, right: np.ndarray) -> np.ndarray:
        """x (n,) or (n, k), without an edge."""
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

        n = self._point.chain.dimension

        def preconditioned(vector: np.ndarray) -> np.ndarray:
            return self._direct.solve(self._times(vector), "N")

        operator = LinearOperator((len(right),) * 2, matvec=preconditioned, dtype=self._kind)
        begin = self._direct.solve(np.append(self._shape(right[:n]), right[n:]), "N")
        found, left = gmres(operator, begin, rtol=ITERATIVE, atol=0.0, restart=KRYLOV, maxiter=10)
        if left and not np.linalg.norm(preconditioned(found) - begin) <= ENOUGH * np.linalg.norm(
            begin
        ):
            raise FloatingPointError("the linear system of all pairs does not converge")
        return np.append(self._shape(found[:n]), found[n:])

    def _shape(self, vector: np.ndarray) -> np.ndarray:
        """P · vector (n,): without its part along the motions as a whole."""
        basis = self._point.neutral
        return vector - basis @ (basis.T @ vector)

    def _times(self, vector: np.ndarray) -> np.ndarray:
        """P (J − σ) P x + P c p, and r·P x + κ p with an edge, of (x, p)."""
        n = self._point.chain.dimension
        shape = self._shape(vector[:n])
        image = self._point.product(shape) - self._shift * shape
        if self._edge is None:
            return self._shape(image)
        column, row, corner = self._edge
        image = image + column * vector[n]
        return np.append(self._shape(image), row @ shape + corner * vector[n])


class _Factors:
    """LU of [[J − σ, Q, c], [Qᵀ, 0, 0], [rᵀ, 0, κ]]."""

    def __init__(
        self, matrix: Any, basis: np.ndarray, shift: complex, edge: Edge | None = None
    ) -> None:
        n, motions = basis.shape
        self._n, self._border = n, motions
        self._kind = complex if isinstance(shift, complex) else float
        self._sparse = not isinstance(matrix, np.ndarray)
        columns, rows, corner = basis, basis.T, np.zeros((motions, motions))
        if edge is not None:
            columns = np.column_stack([basis, edge.column])
            rows = np.vstack([basis.T, edge.row])
            corner = np.zeros((motions + 1, motions + 1))
            corner[-1, -1] = edge.corner
        if self._sparse:
            self._factors = _sparse_factors(matrix, (columns, rows, corner), shift)
        else:
            from scipy.linalg.lapack import get_lapack_funcs

            whole = np.zeros((n + len(corner),) * 2, self._kind)
            whole[:n, :n] = matrix
            whole[range(n), range(n)] -= shift
            whole[:n, n:], whole[n:, :n], whole[n:, n:] = columns, rows, corner
            (factorise,) = get_lapack_funcs(("getrf",), (whole,))
            factors, pivots, singular = factorise(whole, overwrite_a=True)
            if singular:
                raise FloatingPointError("the matrix of small changes is singular")
            self._factors = factors, pivots

    def solve(self, right: np.ndarray, kind: str) -> np.ndarray:
        """(x, p), or x alone, of the matrix ("N") or of its conjugate transpose ("H")."""
        n, border, further = self._n, self._border, right[self._n :]
        padded = np.concatenate([right[:n], np.zeros(border), further]).astype(self._kind)
        if self._sparse:
            found = self._factors.solve(padded, kind)
        else:
            from scipy.linalg import lu_solve

            trans = 0 if kind == "N" else 2
            found = lu_solve(self._factors, padded, trans=trans, check_finite=False)
        return np.concatenate([found[:n], found[n + border :]]) if len(further) else found[:n]


def _sparse_factors(
    matrix: Any, border: tuple[np.ndarray, np.ndarray, np.ndarray], shift: complex
) -> Any:
    from scipy.sparse import block_array, csc_array, eye_array
    from scipy.sparse.linalg import splu

    shifted = matrix - shift * eye_array(matrix.shape[0], format="csc")
    columns, rows, corner = border
    if len(corner):
        shifted = block_array([[shifted, csc_array(columns)], [csc_array(rows), csc_array(corner)]])
    kind = complex if isinstance(shift, complex) else float
    try:
        # spheres in their order along the chain are a band already
        return splu(shifted.tocsc().astype(kind), permc_spec="NATURAL")
    except RuntimeError as error:
        raise FloatingPointError(f"the matrix of small changes is singular: {error}") from None
