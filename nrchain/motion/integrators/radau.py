"""Y_i = h Σ_j a_ij f(t_n + c_j h, Y_j): Radau IIA of order 5, in a fresh chart at every step.

L-stable, with three stages at c = (4 ∓ √6)/10 and 1. Every step starts at y = 0 of a chart about
the present poses, with bases that drift and spin as the chain does: a Lie-group method without
large coordinates and without singular charts. At y = 0 the tangent of the Cayley map is the
identity and the Jacobian is the derivative of the twists in the lab: it is continuous from chart to
chart, and is reused while Newton's iteration converges fast.

Steps run in compiled code (:mod:`~nrchain.motion.integrators.radau_steps`) and without the global
lock of the interpreter, up to the next event that Python has to see.

Hairer & Wanner, *Solving Ordinary Differential Equations II* (2nd ed., 1996), Sec. IV.8.
"""

from __future__ import annotations

from typing import NoReturn

import numpy as np

from nrchain.motion.charts import ChartedChain
from nrchain.motion.integrators import radau_steps as steps
from nrchain.motion.integrators.base import (
    IntegrationError,
    Integrator,
    NotFinite,
    Samples,
    StepChecks,
)
from nrchain.motion.integrators.chain_equation import ChainEquation
from nrchain.motion.integrators.far_pairs import FarPairSolver
from nrchain.motion.integrators.stage_solver import KrylovSolver
from nrchain.types import Poses


class Radau(Integrator):
    """Radau IIA, 3 stages, order 5, on R³ × SO(3).

    In a new chart y is the motion of a sphere in one step: ``rtol`` is relative to this motion, and
    ``atol`` usually decides.

    ``at`` evaluates the collocation polynomial: the error is O(h⁴) within a step and globally O(h⁵)
    at its ends.

    Parameters
    ----------
    fixed_step
        Take steps of this length for any error, to measure the order.

    Attributes
    ----------
    equation
        The functions that steps call, with what they share.
    """

    name = "radau"
    order = 5
    # R(2) = 7.5 and exp(2) = 7.39: beyond, R departs from exp, up to its pole at 3.64
    growth_limit = 2.0
    evaluations = 6.0
    renews_chart = True

    def __init__(
        self,
        chain: ChartedChain,
        end: float,
        rtol: float,
        atol: np.ndarray,
        *,
        fixed_step: float | None = None,
    ) -> None:
        super().__init__(chain, end, rtol, atol)
        self.equation = ChainEquation(chain, end, rtol, atol, fixed_step or 0.0)
        self._solver: KrylovSolver | FarPairSolver | None = None
        if not chain.model.is_near:
            self._solver = KrylovSolver(chain, self.equation)
        elif self.equation.has_far_pairs:
            self._solver = FarPairSolver(self.equation)
        self._places = (6 * chain.order[:, None] + np.arange(6)).ravel()
        equation = self.equation
        self._state = equation.functions, equation.numbers, equation.counts, equation.vectors

    def start(self, time: float, y: np.ndarray) -> None:
        vectors = self.equation.vectors
        vectors[steps.Y] = 0.0
        vectors[steps.Y, self._places] = y
        steps.start(self.equation.numbers, self.equation.counts, time)
        self.begin = self.reached = time

    def step(self) -> float:
        self._advance(Samples(0, 0), 1)
        return self.reached

    def advance(self, samples: Samples, most: int, checks: StepChecks) -> int:
        self.equation.watch(checks)
        return self._advance(samples, most)

    def _advance(self, samples: Samples, most: int) -> int:
        to = samples.positions.ctypes.data, samples.frames.ctypes.data
        status, taken = steps.advance(
            *self._state, self.equation.pair, most, samples.times, samples.counted, *to
        )
        samples.taken = int(self.equation.counts[steps.SAMPLED])
        samples.counted[: samples.taken, 1] += self.chain.evaluations
        self._count()
        if status != steps.ADVANCED:
            self._raise(status)
        return taken

    def at(self, time: float) -> np.ndarray:
        _, *shared = self._state
        y = np.empty(shared[-1].shape[1])
        steps.interpolate(*shared, time, y)
        return y[self._places]

    def poses_at(self, time: float) -> Poses:
        return self.equation.poses_at(time)

    def _count(self) -> None:
        numbers, counts, chain = self.equation.numbers, self.equation.counts, self.chain
        self.begin, self.reached = float(numbers[steps.BEGIN]), float(numbers[steps.TIME])
        self.steps, self.solves = int(counts[steps.STEPS]), int(counts[steps.SOLVES])
        chain.evaluations += int(counts[steps.EVALUATIONS])
        chain.jacobians += int(counts[steps.JACOBIANS])
        counts[[steps.EVALUATIONS, steps.JACOBIANS]] = 0

    def _raise(self, status: int) -> NoReturn:
        self.equation.raise_error()
        if self._solver:
            self._solver.raise_error()
        if status == steps.NOT_FINITE:
            raise NotFinite
        fixed = self.equation.numbers[steps.FIXED]
        if fixed and status == steps.DIVERGES:
            raise IntegrationError(f"{_CAUSES[status][2:]} in a step of {fixed:.6g}")
        raise IntegrationError(f"steps have become too small{_CAUSES[status]}")


_CAUSES = {
    steps.NO_STEP: " from the first on",
    steps.ERROR_STAYS: ": the error stays above the tolerance",
    steps.DIVERGES: ": Newton's iteration does not converge",
}
