"""Y_i = h Σ_j a_ij f(t_n + c_j h, Y_j): Radau IIA of order 5, in a fresh chart at every step.

L-stable, with three stages at c = (4 ∓ √6)/10 and 1. Every step starts at y = 0 of a chart about
the present poses, with bases that drift and spin as the chain does: a Lie-group method without
large coordinates and without singular charts. At y = 0 the tangent of the Cayley map is the
identity and the Jacobian is the derivative of the twists in the lab: it is continuous from chart to
chart, and is reused while Newton's iteration converges fast.

Hairer & Wanner, *Solving Ordinary Differential Equations II* (2nd ed., 1996), Sec. IV.8: the
scheme, the error estimate and the control of the step; named constants are theirs.
"""

from __future__ import annotations

import math

import numpy as np

from nrchain._compile import kernel
from nrchain.geometry import lie
from nrchain.motion.charts import TURN_LIMIT, ChartedChain
from nrchain.motion.integrators.base import IntegrationError, Integrator, NotFinite
from nrchain.motion.integrators.linear import SingularMatrix, jacobian_of
from nrchain.motion.integrators.radau_stages import (
    ITERATIONS,
    NODES,
    Outcome,
    StageSystem,
    cubics,
    powers,
    scaled_norm,
)

SAFETY = 0.9
SLOWEST, FASTEST = 0.2, 8.0
"""Smallest and largest ratio of a step to the one before."""

KEEP = 1.2
"""A step that could grow by less than this keeps its length and factors (Sec. IV.8, c_2)."""

FRESH_JACOBIAN = 1e-3
"""Rate of Newton's iteration above which the next step takes a new Jacobian (Sec. IV.8, ϑ)."""

NEWTON_TOLERANCE = 0.03
"""Largest error of the stages, in units of the tolerance per step (Sec. IV.8, κ)."""

PATIENCE = 50
"""Largest number of Newton iterations of a fixed step, which cannot be shortened."""

SMALLEST_ERROR = 1e-2
"""Errors below this, in units of the tolerance, do not speed up the predictive controller."""

EPSILON = float(np.finfo(float).eps)

_WITHIN = cubics(NODES)
_PAST_NODES = np.array([0.0, *NODES[:2]]) - 1.0
_BEYOND = cubics(_PAST_NODES)


@kernel
def _coordinates(order, base_positions, base_frames, positions, frames, out):
    """out = y of poses about base poses: ρ = r − r⁰, R = Fᵀ F⁰, θ = cay⁻¹(R)."""
    rotation = np.empty((3, 3))
    for slot in range(order.shape[0]):
        i = order[slot]
        for k in range(3):
            for m in range(3):
                rotation[k, m] = (
                    frames[i, 0, k] * base_frames[i, 0, m]
                    + frames[i, 1, k] * base_frames[i, 1, m]
                    + frames[i, 2, k] * base_frames[i, 2, m]
                )
        lie.inverse_cayley(rotation, out[6 * slot + 3 : 6 * slot + 6])
        for k in range(3):
            out[6 * slot + k] = positions[i, k] - base_positions[i, k]


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
    """

    name = "radau"
    order = 5
    # R(2) = 7.5 and exp(2) = 7.39: beyond, R departs from exp, up to its pole at 3.64
    growth_limit = 2.0

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
        self._fixed = fixed_step
        self._jacobian = jacobian_of(chain, atol)
        patience = PATIENCE if fixed_step else ITERATIONS
        self._system = StageSystem(chain.rates, self._jacobian, chain.dimension, patience)
        self._slope = np.empty(chain.dimension)
        self._still = np.zeros(chain.dimension)

    def start(self, time: float, y: np.ndarray) -> None:
        self._begin = self._time = time
        self._y = np.array(y, float)
        self._stages: np.ndarray | None = None
        self._past = np.empty((0, self.chain.dimension))
        self._length = self._next = 0.0
        self._error = 0.0
        self._linearised = self._factorised = False
        self._system.reset()

    def step(self) -> float:
        self._move_base()
        self.chain.rates(self._time, self._still, self._slope)
        if not np.isfinite(self._slope).all():
            raise NotFinite
        if not self._linearised:
            self._linearise()
        step, rejected, cause = self._fixed or self._next or self._first_step(), False, ""
        while True:
            if not step > 10.0 * np.spacing(abs(self._time)):
                because = f": {cause}" if cause else " from the first on"
                raise IntegrationError(f"steps have become too small{because}")
            outcome = self._attempt(step)
            if outcome.converged:
                error = self._estimate(outcome.stages, rejected)
                room = SAFETY * self._room_to_turn(outcome.stages[-1])
                if self._fixed or (error < 1.0 and room >= SAFETY):
                    break
                factor = max(SLOWEST, min(self._growth(outcome, error), room))
                cause = "the error stays above the tolerance"
            else:
                factor, cause = 0.5, "Newton's iteration does not converge"
                if self._fixed:
                    raise IntegrationError(f"{cause} in a step of {step:.6g}")
            step, rejected, self._factorised = factor * step, True, False
        self._accept(step, outcome, error, rejected, room)
        return self._time

    def at(self, time: float) -> np.ndarray:
        if time == self._time or self._stages is None:
            return self._y.copy()
        return _WITHIN @ powers((time - self._begin) / self._length) @ self._stages

    def _move_base(self) -> None:
        """Change to a chart about the present poses; ``_past`` are the last stages in it.

        Called at the start of a step: until then ``at`` and the chain refer to the last step.
        """
        chain, past = self.chain, self._past_poses()
        chain.rebase(self._time, *chain.poses(self._time, self._y))
        self._past = np.empty((len(past), chain.dimension))
        for (time, *poses), y in zip(past, self._past, strict=True):
            _coordinates(chain.order, *chain.poses(time, self._still), *poses, y)
        self._begin, self._y, self._stages = self._time, self._still, None
        self._fresh = False

    def _past_poses(self) -> list[tuple[float, np.ndarray, np.ndarray]]:
        """Times, positions and frames of the start and the inner stages of the last step."""
        if self._stages is None:
            return []
        times = self._time + self._length * _PAST_NODES
        ys = self._still, *self._stages[:2]
        return [
            (time, *(array.copy() for array in self.chain.poses(time, y)))
            for time, y in zip(times, ys, strict=True)
        ]

    def _linearise(self) -> None:
        self._jacobian.update(self._time, self._still)
        self._linearised, self._fresh, self._factorised = True, True, False

    def _first_step(self) -> float:
        """h with ω³‖f‖ h⁴ = 1 for the rate ω = ‖Jf‖/‖f‖: what the error estimate should be."""
        curvature = np.empty_like(self._slope)
        self.chain.product(self._slope, curvature)
        speed = scaled_norm(self._slope, self.atol)
        if speed == 0.0:
            return self.end
        rate = scaled_norm(curvature, self.atol) / speed
        return SAFETY / max((speed * rate**3) ** 0.25, SAFETY / self.end)

    def _attempt(self, step: float) -> Outcome:
        """The stages of a step of this length, with a new Jacobian if the old one fails."""
        outcome = self._solve_stages(step)
        if not outcome.converged and not self._fresh:
            self._linearise()
            outcome = self._solve_stages(step)
        return outcome

    def _solve_stages(self, step: float) -> Outcome:
        if not self._factorised:
            try:
                self._system.factorise(step)
            except SingularMatrix:
                return Outcome(np.empty((0, 0)), False, ITERATIONS, 1.0)
            self._factorised = True
        guess = np.zeros((3, self.chain.dimension))
        if len(self._past):
            guess = (_BEYOND @ powers(NODES * (step / self._length))).T @ self._past
            if max(map(self.chain.largest_turn, guess)) > TURN_LIMIT:
                guess[:] = 0.0
        # Lab coordinates are known to rounding, and so are the changes of y.
        rounding = 10.0 * EPSILON * max(1.0, np.abs(self.chain.base_positions).max())
        rounding /= float(self.atol.min())
        tolerance = max(rounding, min(NEWTON_TOLERANCE, math.sqrt(self.rtol)))
        return self._system.solve(self._time, guess, self.atol, tolerance, rounding)

    def _estimate(self, stages: np.ndarray, rejected: bool) -> float:
        """The error of the step in units of the tolerance."""
        scale = self.atol + self.rtol * np.abs(stages[-1])
        error = self._system.error(self._slope, stages)
        size = scaled_norm(error, scale)
        if size >= 1.0 and (rejected or not self._error):
            size = scaled_norm(self._system.filtered_error(self._time, stages, error), scale)
        return max(size, 1e-10)

    def _growth(self, outcome: Outcome, error: float) -> float:
        """The ratio of the next step to this one, from its error and Newton's iterations."""
        work = (2 * ITERATIONS + 1) / (2 * ITERATIONS + outcome.iterations)
        return SAFETY * work * error**-0.25

    def _room_to_turn(self, y: np.ndarray) -> float:
        """A quarter turn over the largest rotation in this step."""
        turn = math.atan(0.5 * self.chain.largest_turn(y))
        return math.atan(0.5 * TURN_LIMIT) / max(turn, EPSILON)

    def _accept(
        self, step: float, outcome: Outcome, error: float, rejected: bool, room: float
    ) -> None:
        """Advance, and choose the next step by the predictive controller."""
        growth = self._growth(outcome, error)
        if self._error:
            growth *= min(1.0, step / self._length * (self._error / error) ** 0.25)
        growth = min(max(growth, SLOWEST), FASTEST, room)
        if rejected:
            growth = min(growth, 1.0)
        self._linearised = outcome.rate < FRESH_JACOBIAN
        if self._linearised and 1.0 <= growth <= KEEP:
            growth = 1.0
        self._factorised &= self._linearised and growth == 1.0
        self._error = max(error, SMALLEST_ERROR)
        self._length, self._next = step, growth * step
        self._stages, self._y = outcome.stages, outcome.stages[-1]
        self._time += step
        self.steps, self.solves = self.steps + 1, self._system.solves
