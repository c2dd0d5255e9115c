"""y_j = h Σ_i a_ji f(y_i): one step of Radau IIA over an interval, and its derivative.

y_j = (u, θ) of stage j about the first pose of the interval, f = (G_u, T⁻¹(θ) G_φ) with the twists
G in axes that go along. The poses change by η_j in the lab at the stages and by δ at the start;
h and the motion of the axes change as well. To first order

    Σ_i [δ_ji S_j − h a_ji (C_i S_i + S_i D_i)] η_i = [K_j − h Σ_i a_ji C_i K_i] δ
        + Σ_i a_ji (dh f_i + h S_i dG_i) − (defect)_j,

S = T⁻¹(θ), K = T⁻¹(−θ) and C = ∂(T⁻¹ G_φ)/∂θ on rotations, S = K = 1 and C = 0 on displacements,
and D = ∂G/∂(u, φ). The last stage is the first pose of the next interval.
"""

from __future__ import annotations

import numpy as np

from nrchain.comoving.relative import RelativeChain
from nrchain.motion.integrators.radau_tableau import RUNGE_KUTTA
from nrchain.states.cycles.charts import chart, inverse_tangents, rate_derivatives
from nrchain.types import Poses

REACH = 200
"""Most coordinates between those that couple, for elimination as a band."""


class Interval:
    """The stages of one interval.

    Attributes
    ----------
    points
        G at the three stages.
    rates
        f (3, n).
    defect
        (3, n): y − h A f.
    """

    def __init__(
        self,
        chain: RelativeChain,
        base: Poses,
        stages: Poses,
        step: float,
        elementary: np.ndarray,
    ) -> None:
        self.chain, self.step = chain, step
        self.points = [chain.at(pose, elementary) for pose in zip(*stages, strict=True)]
        poses = chart(*stages, base)
        y = np.stack([chain.coordinates(one) for one in poses])
        self._theta = poses[:, chain.free, 3:].reshape(-1, 3)
        self._tangents = inverse_tangents(self._theta).reshape(3, -1, 3, 3)
        self.rates = self.turned(np.stack([point.residual for point in self.points]))
        self.defect = y - step * RUNGE_KUTTA @ self.rates

    def turned(self, changes: np.ndarray) -> np.ndarray:
        """S (3, n) or (3, n, c): rates of y from twists at the stages."""
        out = changes.reshape(3, len(self.chain.free), 2, 3, *changes.shape[2:]).copy()
        out[:, :, 1] = np.einsum("jspq,jsq...->jsp...", self._tangents, out[:, :, 1])
        return out.reshape(changes.shape)

    def factorise(self) -> tuple[_Factors, np.ndarray]:
        """The factors of the matrix of η, and the matrix (3n, n) of δ."""
        n, h = self.chain.dimension, self.step
        omega = np.stack([point.residual for point in self.points]).reshape(3, -1, 2, 3)[:, :, 1]
        omega = omega / self.chain.length
        bends = rate_derivatives(self._theta, omega.reshape(-1, 3)).reshape(3, -1, 3, 3)
        back = inverse_tangents(-self._theta).reshape(3, -1, 3, 3)
        own = np.stack([_by_spheres(one) for one in self._tangents])
        curved = [_by_spheres(c @ s, 0.0) for c, s in zip(bends, self._tangents, strict=True)]
        matrices = [
            part + change
            for part, change in zip(curved, self.turned(self._derivatives()), strict=True)
        ]
        whole = np.empty((3, n, 3, n))
        for j in range(3):
            for i in range(3):
                whole[j, :, i] = -h * RUNGE_KUTTA[j, i] * matrices[i]
            whole[j, :, j] += own[j]
        begin = np.stack([_by_spheres(one) for one in back])
        turns = np.stack([_by_spheres(c @ k, 0.0) for c, k in zip(bends, back, strict=True)])
        begin -= h * np.einsum("ji,ipq->jpq", RUNGE_KUTTA, turns)
        point = self.points[0]
        reach = point.chain.model.reach if point.is_banded else n
        if point.chain.model.period:
            reach = n
        return _Factors(whole, reach), begin.reshape(3 * n, n)

    def _derivatives(self) -> np.ndarray:
        """D (3, n, n)."""
        found = []
        for point in self.points:
            matrix = point.matrix
            if matrix is None:
                raise FloatingPointError("the chain is too long for cycles with all pairs")
            found.append(matrix if isinstance(matrix, np.ndarray) else matrix.toarray())
        return np.stack(found)


def _by_spheres(blocks: np.ndarray, displacements: float = 1.0) -> np.ndarray:
    """The matrix (n, n) of blocks (s, 3, 3) on the rotation of every sphere."""
    count = len(blocks)
    out = np.zeros((count, 2, 3, count, 2, 3))
    places = np.arange(count)
    out[places, 1, :, places, 1, :] = blocks
    out[places, 0, :, places, 0, :] = displacements * np.eye(3)
    return out.reshape(6 * count, 6 * count)


class _Factors:
    """LU of a matrix (3, n, 3, n) of three stages: as a band if spheres reach few neighbours."""

    def __init__(self, matrix: np.ndarray, reach: int) -> None:
        n = matrix.shape[1]
        # stages of a sphere side by side
        self._order = np.arange(3 * n).reshape(3, n // 6, 6).transpose(1, 0, 2).ravel()
        whole = matrix.reshape(3 * n, 3 * n)
        self._width = 18 * (reach + 1) - 1
        self.is_banded = 2 * self._width < min(3 * n, 2 * REACH)
        if self.is_banded:
            self._factors = _band_factors(whole[np.ix_(self._order, self._order)], self._width)
            return
        from scipy.linalg import lu_factor

        self._factors = lu_factor(whole, check_finite=False)
        if not np.all(np.diag(self._factors[0])):
            raise FloatingPointError("the matrix of a step is singular")

    def solve(self, right: np.ndarray) -> np.ndarray:
        """x (3n,) or (3n, c)."""
        if not self.is_banded:
            from scipy.linalg import lu_solve

            return lu_solve(self._factors, right, check_finite=False)
        from scipy.linalg.lapack import dgbtrs

        out = np.empty_like(right)
        found, _ = dgbtrs(
            self._factors[0], self._width, self._width, right[self._order], self._factors[1]
        )
        out[self._order] = found
        return out


def _band_factors(matrix: np.ndarray, width: int) -> tuple[np.ndarray, np.ndarray]:
    """LU of a matrix with so many diagonals on either side."""
    from scipy.linalg.lapack import dgbtrf

    size = len(matrix)
    band = np.zeros((3 * width + 1, size))
    for diagonal in range(-width, width + 1):
        values = np.diagonal(matrix, diagonal)
        first = max(diagonal, 0)
        band[2 * width - diagonal, first : first + len(values)] = values
    factors, pivots, singular = dgbtrf(band, width, width)
    if singular:
        raise FloatingPointError("the matrix of a step is singular")
    return factors, pivots
