"""ẏ = f(t, y): what an integrator of the charted chain has to offer, and what it counts."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

import numpy as np

from nrchain.outcome import Cause

if TYPE_CHECKING:
    from nrchain.motion.charts import ChartedChain


class IntegrationError(Exception):
    """The integrator cannot take its next step; the message says why."""

    cause = Cause.STEP


class NotFinite(IntegrationError):
    """The velocities are not finite at the beginning of a step, or on the way to its end."""

    cause = Cause.NOT_FINITE

    def __init__(self, message: str = "the velocities are not finite") -> None:
        super().__init__(message)


class Integrator(ABC):
    """One step after another along the coordinates of a charted chain.

    For implementers: ``start`` forgets all history; ``step`` takes one step of the integrator's
    own choosing, returns the time reached and raises :class:`IntegrationError` when it cannot go
    on; ``at`` interpolates within the last step, to an order the scheme states. Nothing outside
    ``start`` may change what a step does, so that a run restarted at the same points, with the
    same poses, repeats itself bit for bit.

    Parameters
    ----------
    chain
        The ODE, with its Jacobian.
    end
        Where the run is going: sets the scale of the first step, not its outcome.
    rtol, atol
        Tolerances per step, √mean((error/(``atol`` + ``rtol`` |y|))²) < 1; ``atol`` (dimension,) in
        the units of y.
    """

    name: str
    """What scenes and reports call the scheme."""

    order: int
    """Highest order of its global error."""

    growth_limit: float
    """h μ up to which a step h reproduces growth at rate μ of what is below the tolerance."""

    def __init__(self, chain: ChartedChain, end: float, rtol: float, atol: np.ndarray) -> None:
        self.chain, self.end, self.rtol, self.atol = chain, end, rtol, atol
        self.steps = self.solves = 0

    @abstractmethod
    def start(self, time: float, y: np.ndarray) -> None:
        """Begin at (time, y), with no history."""

    @abstractmethod
    def step(self) -> float:
        """Take one step; return the time reached."""

    @abstractmethod
    def at(self, time: float) -> np.ndarray:
        """y at a time within the last step."""
