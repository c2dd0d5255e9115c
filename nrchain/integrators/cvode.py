"""Σ_j α_j y_{n−j} = h β f(t_n, y_n): backward differences of order 1 to 5, by CVODE.

CVODE chooses step and order. Its Newton systems (I − γJ) δ = r are solved by GMRES with the exact
product Jδ and, as preconditioner, the banded factors of the part of J near the diagonal. With
nearest neighbours the factors are those of the whole matrix and one iteration solves it; with
all pairs a few more make up for what the band leaves out. Memory grows linearly with N in either
case. Hindmarsh et al., ACM TOMS 31 (2005) 363.
"""

from __future__ import annotations

import numpy as np
from sksundae.cvode import CVODE, CVODEJacTimes, CVODEPrecond

from nrchain.charts import ChartedChain
from nrchain.integrators.base import IntegrationError, Integrator, NotFinite

KRYLOV_DIMENSION = 20
"""Upper bound on the iterations of one linear solve."""


class Cvode(Integrator):
    """CVODE's BDF with preconditioned GMRES."""

    name = "cvode"
    order = 5

    def __init__(self, chain: ChartedChain, end: float, rtol: float, atol: np.ndarray) -> None:
        super().__init__(chain, end, rtol, atol)
        self._time = 0.0
        self._solver = CVODE(
            self._rates,
            method="BDF",
            rtol=rtol,
            atol=atol,
            linsolver="gmres",
            krylov_dim=KRYLOV_DIMENSION,
            precond=CVODEPrecond(self._prepare, self._solve),
            jactimes=CVODEJacTimes(None, self._product),
        )

    def _rates(self, t, y, ydot) -> None:
        self.chain.rates(t, y, ydot)
        if not np.isfinite(ydot).all():
            raise NotFinite

    def _prepare(self, t, y, ydot, jacobian_is_current, jacobian_is_new, gamma) -> None:
        jacobian_is_new[0] = 0 if jacobian_is_current else 1
        if not jacobian_is_current:
            self.chain.linearise(t, y)
        self.chain.factorise(gamma)

    def _solve(self, t, y, ydot, right, out, gamma, delta, side) -> None:
        self.solves += 1
        self.chain.solve(right, out)

    def _product(self, t, y, ydot, vector, out) -> None:
        self.chain.product(vector, out)

    def start(self, time: float, y: np.ndarray) -> None:
        self._time = time
        self._solver.init_step(time, y)

    def step(self) -> float:
        result = self._solver.step(self.end, method="onestep")
        if not result.success:
            raise IntegrationError(f"{result.message} (t = {result.t:.6g})")
        self.steps += 1
        self._time = float(result.t)
        return self._time

    def at(self, time: float) -> np.ndarray:
        result = self._solver.step(time, method="normal")
        if not result.success:
            raise IntegrationError(result.message)
        return result.y
