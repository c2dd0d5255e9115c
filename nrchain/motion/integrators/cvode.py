"""Σ_j α_j y_{n−j} = h β f(t_n, y_n): backward differences of order 1 to 5, by CVODE.

CVODE chooses step and order. Its Newton systems (I − γJ) δ = r are solved by GMRES with the exact
product Jδ. The preconditioner is the factors of the part of J near the diagonal. With all pairs a
few iterations are needed. With near neighbours the factors are those of the whole matrix: the first
vector of GMRES is the solution, and the iteration that confirms it costs no product and no solve.
Memory grows linearly with N in both cases.

CVODE would print errors and warnings to standard output. This class stops first: it gives up a step
before CVODE does, and ends before steps fail to advance the time.

Source: Hindmarsh et al., ACM TOMS 31 (2005) 363.
"""

from __future__ import annotations

import numpy as np
from sksundae.cvode import CVODE, CVODEJacTimes, CVODEPrecond

from nrchain.motion.charts import ChartedChain
from nrchain.motion.integrators.base import IntegrationError, Integrator, NotFinite

KRYLOV_DIMENSION = 20
"""Upper bound on the iterations of one linear solve."""

ATTEMPTS = 6
"""Jacobians within one step at which it is given up. Every attempt after the first computes one.
CVODE itself fails at the seventh error test (``MXNEF``) or the tenth Newton iteration. Scenes far
beyond their beam limit need 3."""

LEAST_ADVANCE = 8.0
"""Smallest advance of the time in a step, in spacings of floating-point numbers. The step after a
successful one has at least 0.4 of its length, and advances the time too."""


class Cvode(Integrator):
    """CVODE's BDF with preconditioned GMRES."""

    name = "cvode"
    order = 5
    # the first pole of R(z) is at 1 at order 1, and at 1 + … + 1/q at order q: growth is damped
    # beyond it, and faster than exp(z) below it
    growth_limit = 1.0
    share = 1.0 / 20.0

    def __init__(self, chain: ChartedChain, end: float, rtol: float, atol: np.ndarray) -> None:
        super().__init__(chain, end, rtol, atol)
        self._y, self._astray, self._jacobians = np.empty(0), False, 0
        # arrays of CVODE are read-only: kernels are compiled for others
        self._given = np.empty(len(atol))
        self._is_direct, self._confirms = chain.is_banded, False
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
        self._given[:] = y
        self.chain.rates(t, self._given, ydot)
        if not np.isfinite(ydot).all():
            raise NotFinite

    def _prepare(self, t, y, ydot, jacobian_is_current, jacobian_is_new, gamma) -> None:
        # CVODE would keep an old Jacobian for up to 50 steps. A new one costs about as much as the
        # factors computed here, and halves the number of steps of long stiff chains: with an old
        # one, Newton's residual of rotated bonds counts as an error.
        jacobian_is_new[0] = 1
        self._jacobians += 1
        if self._jacobians == ATTEMPTS:
            begin = self.reached
            raise IntegrationError(
                f"a step from t = {begin:.6g} misses the tolerance at every length tried, down to"
                f" {t - begin:.3g}"
            )
        self._given[:] = y
        self.chain.linearise(t, self._given)
        self.chain.factorise(gamma)

    def _solve(self, t, y, ydot, right, out, gamma, delta, side) -> None:
        if self._confirms:
            # of (I − γJ) v, given as v by _product
            self._confirms, out[:] = False, right
            return
        self.solves += 1
        self.chain.solve(right, out)

    def _product(self, t, y, ydot, vector, out) -> None:
        self._confirms = self._is_direct
        if self._is_direct:
            out[:] = 0.0
        else:
            self._given[:] = vector
            self.chain.product(self._given, out)

    def start(self, time: float, y: np.ndarray) -> None:
        self.begin = self.reached = time
        self._y, self._astray = y.copy(), False
        self._refuse_no_first_step(time, y)
        self._solver.init_step(time, y)

    def _refuse_no_first_step(self, time: float, y: np.ndarray) -> None:
        """Raise IntegrationError if CVODE's first step, bounded by the tolerance, would be 0."""
        slope = np.empty_like(y)
        self._rates(time, y, slope)
        with np.errstate(over="ignore"):
            rate = np.sqrt(np.mean((slope / (self.atol + self.rtol * np.abs(y))) ** 2))
        if not rate * LEAST_ADVANCE * np.spacing(time) < 1.0:
            raise IntegrationError(f"no step is short enough for rates of {abs(slope).max():.2g}")

    def step(self) -> float:
        self._return_to_end()
        begin, self._jacobians = self.reached, 0
        # the first step needs a distance to the end that is not rounding
        towards = max(self.end, begin + 1e3 * np.spacing(begin))
        result = self._solver.step(towards, method="onestep")
        if not result.success:
            raise IntegrationError(f"{result.message} (t = {result.t:.6g})")
        if result.t - begin < LEAST_ADVANCE * np.spacing(begin):
            raise IntegrationError("steps have become too small to advance the time")
        self.steps += 1
        self.begin, self.reached, self._y = begin, float(result.t), result.y
        return self.reached

    def at(self, time: float) -> np.ndarray:
        if time == self.reached:
            return self._y
        self._astray = True
        result = self._solver.step(time, method="normal")
        if not result.success:
            raise IntegrationError(result.message)
        return result.y

    def _return_to_end(self) -> None:
        """Return CVODE to the end of its step after an interpolation."""
        if self._astray:
            self._solver.step(self.reached, method="normal")
            self._astray = False
