"""ẏ = f(t, y): the interface of integrators, and their counters."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from nrchain.motion.bend import BendCheck
from nrchain.motion.clearance import Clearance
from nrchain.outcome import Cause
from nrchain.types import Poses

if TYPE_CHECKING:
    from nrchain.motion.charts import ChartedChain


class IntegrationError(Exception):
    """The integrator cannot take its next step; the message says why."""

    cause = Cause.STEP


class NotFinite(IntegrationError):
    """The velocities are not finite at the start of a step or within it."""

    cause = Cause.NOT_FINITE

    def __init__(self, message: str = "the velocities are not finite") -> None:
        super().__init__(message)


class StepChecks(NamedTuple):
    """What tells compiled code that a step needs no look: it is clear, and the chain is bent."""

    clearance: Clearance
    bend: BendCheck


class Samples:
    """Poses of N = ``count`` spheres at up to ``most`` times, taken while steps pass them.

    Attributes
    ----------
    times
        (T,) at which poses are wanted, in order.
    taken
        How many of them are filled in.
    positions, frames, counted
        (T, N, 3), (T, N, 3, 3), and (T, 2) the steps of the integrator and the right-hand sides of
        the chain up to each.
    """

    def __init__(self, most: int, count: int) -> None:
        self.times, self.taken = np.empty(0), 0
        self.positions, self.frames = np.empty((most, count, 3)), np.empty((most, count, 3, 3))
        self.counted = np.empty((most, 2), np.int64)

    def want(self, times: np.ndarray) -> None:
        """Ask for poses at the first of these times, as many as there is room for."""
        self.times, self.taken = np.ascontiguousarray(times[: len(self.counted)]), 0


class Integrator(ABC):
    """ẏ = f(t, y): one step after another in the coordinates of a chain.

    For implementers: ``start`` discards all history. ``step`` takes one step of a length that the
    integrator chooses, returns the time reached and raises :class:`IntegrationError` if it fails.
    ``at`` interpolates within the last step. Only ``start`` may change the later steps: a run that
    restarts at the same times with the same poses repeats itself bit for bit.

    Parameters
    ----------
    chain
        The ODE, with its Jacobian.
    end
        End time of the run: sets the scale of the first step only.
    rtol, atol
        Of a step, √mean((error/(``atol`` + ``rtol`` |y|))²) < 1; ``atol`` (dimension,) in the units
        of y.
    """

    name: str
    """Name of the scheme in scenes and reports."""

    order: int
    """Highest order of its global error."""

    growth_limit: float
    """h μ up to which a step h reproduces growth at rate μ of what is below the tolerance."""

    share: ClassVar[float] = 1.0
    """Tolerance of a step over that of the run: the errors of runs are then comparable.

    Measured on shipped, hard and random scenes at 1e-3 to 1e-8: nine runs of ten err by at most ten
    times their tolerance, with the integrator that ``"auto"`` takes (``python -m validation
    integrators``).
    """

    evaluations: ClassVar[float] = 1.0
    """Right-hand sides of a step, at least, as a rule."""

    renews_chart: ClassVar[bool] = False
    """Whether every step starts in a chart of its own, which no run has to renew."""

    begin: float
    reached: float
    """The times at which the last step began and ended."""

    def __init__(self, chain: ChartedChain, end: float, rtol: float, atol: np.ndarray) -> None:
        self.chain, self.end, self.rtol, self.atol = chain, end, rtol, atol
        self.steps = self.solves = 0

    @abstractmethod
    def start(self, time: float, y: np.ndarray) -> None:
        """Start at (time, y), without history."""

    @abstractmethod
    def step(self) -> float:
        """Take one step; return the time reached."""

    def advance(self, samples: Samples, most: int, checks: StepChecks) -> int:
        """Take at most ``most`` steps, up to the first that has to be looked at; how many.

        These are any that ``checks`` do not pass, and the one that passes the last time of
        ``samples``. Poses at these times are sampled in the steps before, which need no look. By
        default, every step needs one.
        """
        self.step()
        return 1

    @abstractmethod
    def at(self, time: float) -> np.ndarray:
        """y at a time within the last step."""

    def poses_at(self, time: float) -> Poses:
        """Poses in the lab at a time within the last step, in arrays of their own."""
        positions, frames = self.chain.poses(time, self.at(time))
        return positions, frames.copy()
