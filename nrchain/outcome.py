"""completed, refused, or stopped at time t for a cause: how a run ends, and what to do then.

A scene that cannot be simulated is refused with :class:`~nrchain.errors.SceneError` before any time
is spent. A run that has begun either completes or stops with one :class:`Cause`, and keeps what it
has reached.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Any


class Cause(StrEnum):
    """Why a run stopped before its end.

    >>> Cause.BUDGET == "budget-reached"
    True
    """

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
        """What to try on a chain whose spheres have no slip."""
        return _WITHOUT_SLIP.get(self, self.advice)


_QUARTER = (
    "beyond a quarter turn, twist and bend drive a link on to a half turn. The paper's measures of "
    "twist and bend soften from an eighth of a turn on: elasticity.measure = 'isotropic' holds "
    "larger bends"
)
_BEYOND = "velocities exceed the range of floating point"

_ADVICE = {
    Cause.TOUCH: "add a repulsion in [steric] to continue through contacts, stiffen the chain, or "
    "weaken the slip",
    Cause.TURN: f"raise elasticity.twist and elasticity.bend, or weaken the slip: {_QUARTER}",
    Cause.CHART: "tighten run.rtol and run.atol, so that no step turns a sphere by half a turn",
    Cause.FRICTION: "raise friction.neighbours, or set it to 'all', unless a net force acts on a "
    "periodic chain: the mobility of all pairs is always positive definite",
    Cause.STEP: "loosen run.rtol and run.atol, lower elasticity.ratio, or look in the last poses "
    "for what moves fast",
    Cause.NOT_FINITE: f"weaken the slip or the moduli: {_BEYOND}",
    Cause.BUDGET: "resume the run, or raise run.max_steps or run.max_seconds",
    Cause.INTERRUPTED: "resume the run",
    Cause.NEGLECTED: "run the scene again with those keys or a smaller tolerance; or resume it "
    "with --unwatched: it keeps its effects, and no bound holds",
    Cause.GROWTH: "set the tolerances that the reason names, or start from a larger bend: growing "
    "modes must be above the tolerance",
    Cause.ERROR: "the message names the failure; its cause lies outside the run",
}


_WITHOUT_SLIP = {
    Cause.TOUCH: "add a repulsion in [steric] to continue through contacts, stiffen the chain, or "
    "weaken the external forces and flows",
    Cause.TURN: "raise elasticity.twist and elasticity.bend, or start from a chain that is less "
    f"bent: {_QUARTER}",
    Cause.NOT_FINITE: f"weaken the moduli, or the external forces and flows: {_BEYOND}",
}


class Settled(Exception):
    """A run is complete at ``time``, before its latest end; the message says in what it settled."""

    def __init__(self, time: float, message: str) -> None:
        super().__init__(message)
        self.time = time

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.time, str(self)), vars(self)

    @property
    def reason(self) -> str:
        """What happened, with the time, in one sentence."""
        return f"at t = {self.time:.6g}: {self}"


class Stop(Exception):
    """A run stops at ``time``, before its end; the message says what happened."""

    def __init__(self, cause: Cause, time: float, message: str) -> None:
        super().__init__(message)
        self.cause, self.time = cause, time

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.cause, self.time, str(self)), vars(self)

    @property
    def reason(self) -> str:
        """What happened, with the time, in one sentence."""
        return f"at t = {self.time:.6g}: {self}"
