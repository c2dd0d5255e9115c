"""completed, refused, or stopped at time t for a cause: how a run ends, and what to do about it.

A scene that cannot be simulated is refused with :class:`~nrchain.errors.SceneError` before any
time is spent. A run that began either completes or stops, with one :class:`Cause`; what it reached
is kept. There is no other end.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Any


class Cause(StrEnum):
    """Why a run stopped before its end."""

    TOUCH = "spheres-touch"
    TURN = "link-turned"
    CHART = "chart-invalid"
    STEP = "step-too-small"
    NOT_FINITE = "not-finite"
    BUDGET = "budget-reached"
    INTERRUPTED = "interrupted"
    ERROR = "error"
    FRICTION = "friction-indefinite"
    NEGLECTED = "neglected-effects"
    GROWTH = "growth-unresolved"

    @property
    def advice(self) -> str:
        """What to try."""
        return _ADVICE[self]

    @property
    def advice_without_slip(self) -> str:
        """What to try on a chain whose spheres have none."""
        return _WITHOUT_SLIP.get(self, self.advice)


_QUARTER = (
    "beyond a quarter turn the springs of a link pull it on. The paper's springs soften from an "
    "eighth of a turn on: elasticity.measure = 'isotropic' holds larger bends"
)
_BEYOND = "velocities have left the range of floating point"

_ADVICE = {
    Cause.TOUCH: "name a repulsion in [steric] to go on through contacts, stiffen the chain, or "
    "weaken the slip",
    Cause.TURN: f"raise elasticity.twist and elasticity.bend, or weaken the slip: {_QUARTER}",
    Cause.CHART: "tighten run.rtol and run.atol, so that a step turns no sphere by half a turn",
    Cause.FRICTION: "set friction.neighbours to a larger number, or, unless a net force acts on a "
    "periodic chain, to 'all', whose mobility is positive definite wherever the spheres are",
    Cause.STEP: "loosen run.rtol and run.atol, lower elasticity.ratio, or see in the last poses "
    "what has become fast",
    Cause.NOT_FINITE: f"weaken the slip or the moduli: {_BEYOND}",
    Cause.BUDGET: "resume the run, or raise run.max_steps or run.max_seconds",
    Cause.INTERRUPTED: "resume the run to go on",
    Cause.NEGLECTED: "run the scene again with those keys or a smaller tolerance; or resume it "
    "with --unwatched, as it is and without a bound",
    Cause.GROWTH: "set the tolerances as the reason says, or start from a larger bend: what "
    "grows must be above them",
    Cause.ERROR: "see the message: something outside the run failed",
}


_WITHOUT_SLIP = {
    Cause.TOUCH: "name a repulsion in [steric] to go on through contacts, stiffen the chain, or "
    "weaken what acts on it from outside",
    Cause.TURN: "raise elasticity.twist and elasticity.bend, or start from a chain that is less "
    f"bent: {_QUARTER}",
    Cause.NOT_FINITE: f"weaken the moduli, or what acts from outside: {_BEYOND}",
}


class Stop(Exception):
    """A run ends at ``time``, before its end, for a cause; the message tells what happened."""

    def __init__(self, cause: Cause, time: float, message: str) -> None:
        super().__init__(message)
        self.cause, self.time = cause, time

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.cause, self.time, str(self)), vars(self)

    @property
    def reason(self) -> str:
        """One sentence with the time."""
        return f"at t = {self.time:.6g}: {self}"
