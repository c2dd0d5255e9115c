"""One verified point of a region: the same run with an error estimate, and the state it ends in.

A run is repeated with ``run.verify``: the error of its poses is the distance from a run with
tighter tolerances, and its kind must be the same. Where a chain ends at rest or in steady motion,
Newton's method finds the state from there, and small changes of it must decay. Likewise it finds
the cycle of an oscillation, whose multipliers must not exceed 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nrchain.diagrams.linear import Length
from nrchain.diagrams.trials import Trial, reached, simulated
from nrchain.errors import NrchainError
from nrchain.jobs.crew import FAILED
from nrchain.jobs.ledger import Result
from nrchain.notebook import record_html
from nrchain.run.interruption import Interruption
from nrchain.scene.scene import Scene
from nrchain.states.cycles.cycle import find_cycle
from nrchain.states.state import find_state
from nrchain.trajectory.trajectory import Trajectory
from nrchain.wording import brief

STATES = ("straight", "buckled", "coiled", "swimming", "spinning", "rotating shape")
"""Kinds in which a chain keeps its shape."""

CYCLES = ("rotating shape", "standing oscillation", "travelling oscillation")
"""Kinds in which a chain may have a period."""

AWAY = 0.1
"""Largest distance from its state, in radii, at which a run has ended there."""


@dataclass(frozen=True)
class Verification:
    """What confirms the kind of a region at one of its points.

    Attributes
    ----------
    x, y, start, kind
        The point, and the run that is confirmed.
    agrees
        Whether the run ends in this kind again, and its state or cycle is stable.
    error
        Largest error of positions in the verified run, in radii; NaN where it is not known.
    growth
        Re Λ₁ of the state that Newton's method finds from the end of the run, or ln |μ₁|/T of the
        cycle; NaN without one.
    away
        Largest distance of the spheres from this state at the end of the run, in radii.
    period
        T of the cycle; NaN for a state.
    why
        What does not agree; empty otherwise.
    """

    x: float
    y: float
    start: str
    kind: str
    agrees: bool
    error: float
    growth: float
    away: float
    period: float
    why: str

    __repr__ = brief
    _repr_html_ = record_html

    @classmethod
    def of(cls, place: tuple[float, float], trial: Trial, result: Result) -> Verification:
        """The verification of the result of :func:`verify`."""
        if FAILED in result:
            error = growth = away = period = math.nan
            why = result[FAILED]
        else:
            error, why = result["error"], result["why"]
            growth, away, period = result["growth"], result["away"], result["period"]
        return cls(*place, trial.start, trial.kind, not why, error, growth, away, period, why)


def verify(
    scene: Scene,
    start: str,
    kind: str,
    length: Length,
    interruption: Interruption | None = None,
) -> Result:
    """Repeat a run with an estimate of its error, and find the state or the cycle at its end."""
    done = simulated(scene, start, length, interruption, verify=True)
    assert done.position_error is not None
    known = done.position_error[np.isfinite(done.position_error)]
    error = float(known.max()) / scene.chain.radius if len(known) else math.nan
    again = reached(done).kind.value
    why = "" if again == kind else f"the verified run ends {again}"
    confirmed = _confirmed(done, kind)
    return {
        "error": error,
        "growth": confirmed.growth,
        "away": confirmed.away,
        "period": confirmed.period,
        "why": why or confirmed.why,
    }


@dataclass(frozen=True)
class _Confirmed:
    """What Newton's method finds from the end of a run, and what is wrong with it."""

    growth: float = math.nan
    away: float = math.nan
    period: float = math.nan
    why: str = ""


def _confirmed(done: Trajectory, kind: str) -> _Confirmed:
    """The state or the cycle at the end of a run."""
    found = _Confirmed()
    if kind in STATES:
        found = _state(done)
    if kind in CYCLES and (kind not in STATES or found.why):
        # a shape that goes round may change periodically as it does so
        found = _cycle(done)
    return found


def _state(done: Trajectory) -> _Confirmed:
    try:
        state = find_state(done.scene, done, modes=1)
    except NrchainError as error:
        return _Confirmed(why=str(error))
    apart = np.linalg.norm(state.positions - done.positions[-1], axis=1).max()
    leading = state.spectrum.leading
    grows = leading.growth > leading.error
    away = float(apart) / done.scene.chain.radius
    why = f"its state is unstable, Re Λ = {leading.growth:.3g}" if grows else ""
    if away > AWAY:
        why = why or f"its end is {away:.3g} a from the nearest state"
    return _Confirmed(leading.growth, away, why=why)


def _cycle(done: Trajectory) -> _Confirmed:
    try:
        cycle = find_cycle(done.scene, done, modes=2)
    except NrchainError as error:
        return _Confirmed(why=str(error))
    largest = float(np.abs(cycle.multipliers).max())
    growth = math.log(max(largest, 1e-300)) / cycle.period
    grows = largest > 1.0 + cycle.multiplier_error
    why = f"its cycle is unstable, with a multiplier of size {largest:.6g}" if grows else ""
    return _Confirmed(growth, period=cycle.period, why=why)
