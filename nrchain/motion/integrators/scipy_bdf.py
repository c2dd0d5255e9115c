"""Σ_k γ_k ∇^k y_n = h f(t_n, y_n): backward differences of order 1 to 5, by SciPy.

Quasi-constant steps with the modified formulas of Shampine and Reichelt (SIAM J. Sci. Comput. 18
(1997) 1), independent of CVODE: a check of its results. J is exact. If J is sparse, SuperLU
factorises I − cJ; if all pairs act, no matrix is built.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import BDF
from scipy.sparse import csc_matrix

from nrchain.motion.charts import ChartedChain
from nrchain.motion.integrators.base import IntegrationError, Integrator, NotFinite
from nrchain.motion.integrators.linear import KrylovJacobian, SingularMatrix, jacobian_of

SMALLEST_RTOL = 100 * float(np.finfo(float).eps)
"""Smallest relative tolerance that SciPy accepts."""


class _Shift:
    """Replaces J in the expression I − cJ, of which only c is needed."""

    __array_ufunc__ = None

    def __rmul__(self, scale: float) -> float:
        return float(scale)


class _MatrixFree(BDF):
    """SciPy's BDF with matrix-free systems (I − cJ) x = b."""

    def __init__(
        self,
        rates: Callable[[float, np.ndarray], np.ndarray],
        time: float,
        y: np.ndarray,
        jacobian: KrylovJacobian,
        **tolerances,
    ) -> None:
        nothing = csc_matrix((len(y), len(y)))
        super().__init__(rates, time, y, np.inf, jac=nothing, **tolerances)

        def update(time: float, y: np.ndarray) -> _Shift:
            jacobian.update(time, y)
            return _Shift()

        self.jac, self.J, self.I = update, update(time, y), 0.0
        self.lu = lambda minus_scale: jacobian.shifted_inverse(-minus_scale)
        self.solve_lu = lambda solve, right: solve(right)


class ScipyBdf(Integrator):
    """SciPy's BDF with the Jacobian of the charted chain."""

    name = "scipy-bdf"
    order = 5
    # the pole at order 1, as for all backward differences
    growth_limit = 1.0
    share = 1.0 / 30.0

    def __init__(self, chain: ChartedChain, end: float, rtol: float, atol: np.ndarray) -> None:
        super().__init__(chain, end, max(rtol, SMALLEST_RTOL), atol)
        self._jacobian = jacobian_of(chain, atol)

    def _rates(self, time: float, y: np.ndarray) -> np.ndarray:
        out = np.empty_like(y)
        self.chain.rates(time, y, out)
        if not np.isfinite(out).all():
            raise NotFinite
        return out

    def start(self, time: float, y: np.ndarray) -> None:
        # an infinite end: steps do not depend on the end of the run
        jacobian, tolerances = self._jacobian, {"rtol": self.rtol, "atol": self.atol}
        if isinstance(jacobian, KrylovJacobian):
            self._solver = _MatrixFree(self._rates, time, y, jacobian, **tolerances)
        else:

            def matrix(time: float, y: np.ndarray) -> csc_matrix:
                jacobian.update(time, y)
                return jacobian.matrix()

            self._solver = BDF(self._rates, time, y, np.inf, jac=matrix, **tolerances)
        # SciPy subtracts differences that it has not taken yet: whatever the memory held
        self._solver.D[2:] = 0.0
        self.begin = self.reached = time

    def step(self) -> float:
        before = self._solver.nfev
        try:
            message = self._solver.step()
        except (RuntimeError, SingularMatrix) as error:
            # a Newton matrix that cannot be factorised
            raise IntegrationError(f"{error} (t = {self._solver.t:.6g})") from error
        # Every evaluation within a step is one Newton iteration, and so one linear solve.
        self.solves += self._solver.nfev - before
        if self._solver.status == "failed":
            raise IntegrationError(f"{message} (t = {self._solver.t:.6g})")
        self.steps += 1
        self.begin, self.reached = self.reached, float(self._solver.t)
        return self.reached

    def at(self, time: float) -> np.ndarray:
        if time == self._solver.t:
            return self._solver.y.copy()
        return self._solver.dense_output()(time)
