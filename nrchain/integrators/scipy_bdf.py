"""Σ_k γ_k ∇^k y_n = h f(t_n, y_n): backward differences of order 1 to 5, by SciPy.

Quasi-constant steps with the modified formulas of Shampine and Reichelt (SIAM J. Sci. Comput. 18
(1997) 1), written apart from CVODE: a second opinion on its results. J is exact and sparse, and
I − cJ is factorised by SuperLU.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import BDF

from nrchain.charts import ChartedChain
from nrchain.integrators.base import IntegrationError, Integrator, NotFinite
from nrchain.integrators.linear import jacobian_of

SMALLEST_RTOL = 100 * float(np.finfo(float).eps)
"""What SciPy takes in place of any smaller relative tolerance."""


class ScipyBdf(Integrator):
    """SciPy's BDF with the sparse Jacobian of the charted chain."""

    name = "scipy-bdf"
    order = 5

    def __init__(self, chain: ChartedChain, end: float, rtol: float, atol: np.ndarray) -> None:
        super().__init__(chain, end, max(rtol, SMALLEST_RTOL), atol)
        self._jacobian = jacobian_of(chain, self.name)

    def _rates(self, time: float, y: np.ndarray) -> np.ndarray:
        out = np.empty_like(y)
        self.chain.rates(time, y, out)
        if not np.isfinite(out).all():
            raise NotFinite
        return out

    def _matrix(self, time: float, y: np.ndarray):
        self._jacobian.update(time, y)
        return self._jacobian.matrix()

    def start(self, time: float, y: np.ndarray) -> None:
        # An infinite bound: the steps shall not depend on where the run ends.
        self._solver = BDF(
            self._rates, time, y, np.inf, rtol=self.rtol, atol=self.atol, jac=self._matrix
        )

    def step(self) -> float:
        before = self._solver.nfev
        try:
            message = self._solver.step()
        except RuntimeError as error:
            # SuperLU, of a Newton matrix it cannot factorise
            raise IntegrationError(f"{error} (t = {self._solver.t:.6g})") from error
        # Every evaluation within a step is one Newton iteration, and so one linear solve.
        self.solves += self._solver.nfev - before
        if self._solver.status == "failed":
            raise IntegrationError(f"{message} (t = {self._solver.t:.6g})")
        self.steps += 1
        return float(self._solver.t)

    def at(self, time: float) -> np.ndarray:
        if time == self._solver.t:
            return self._solver.y.copy()
        return self._solver.dense_output()(time)
