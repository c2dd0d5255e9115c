"""(I − cJ) x = b for real and complex c: the linear systems of the implicit schemes.

J is the Jacobian of the charted chain. What acts between near neighbours makes it banded; what
reaches further fills it, and it is then built and factorised whole.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from scipy.linalg import lapack, lu_factor, lu_solve
from scipy.sparse import dia_matrix

from nrchain.charts import ChartedChain
from nrchain.errors import SceneError

DENSE_LIMIT = 256
"""Spheres up to which a filled Jacobian is built: 19 MB, and as many columns as 6N."""

Solve = Callable[[np.ndarray], np.ndarray]


class SingularMatrix(Exception):
    """I − cJ has no inverse at this c."""


class Jacobian(Protocol):
    """J at the point last passed to ``update``."""

    def update(self, time: float, y: np.ndarray) -> None:
        """Take J at (time, y)."""

    def matrix(self) -> Any:
        """J as an array, or as a sparse matrix by columns."""

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

    def matrix(self) -> Any:
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


class DenseJacobian:
    """J that couples all spheres, factorised whole."""

    def __init__(self, chain: ChartedChain) -> None:
        self._chain = chain
        self._matrix = np.empty((0, 0))

    def update(self, time: float, y: np.ndarray) -> None:
        self._chain.linearise(time, y)
        self._matrix = self._chain.jacobian()

    def matrix(self) -> np.ndarray:
        return self._matrix

    def shifted_inverse(self, scale: complex) -> Solve:
        shifted = np.eye(len(self._matrix)) - scale * self._matrix
        if not np.isfinite(shifted).all():
            raise SingularMatrix
        factors = lu_factor(shifted, overwrite_a=True, check_finite=False)
        return lambda right: lu_solve(factors, right, check_finite=False)


def jacobian_of(chain: ChartedChain, integrator: str) -> Jacobian:
    """The Jacobian of a chain, banded where all that acts lies in the band.

    Raises :class:`~nrchain.errors.SceneError` when a filled one would be too large.
    """
    if chain.model.is_banded:
        return BandedJacobian(chain)
    if chain.model.count > DENSE_LIMIT:
        raise SceneError(
            "run.integrator",
            integrator,
            f"builds the whole Jacobian where spheres act on others far along the chain, for up "
            f"to {DENSE_LIMIT} spheres; a chain of {chain.model.count} needs 'cvode'",
        )
    return DenseJacobian(chain)
