"""Runs at a point of the plane: what a chain ends in from several starts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from nrchain.analysis import measure
from nrchain.diagrams.linear import Length
from nrchain.diagrams.plane import Site
from nrchain.diagrams.starts import start_poses
from nrchain.errors import NrchainError
from nrchain.jobs.crew import FAILED
from nrchain.jobs.ledger import Result
from nrchain.notebook import record_html
from nrchain.notices import ignore
from nrchain.outcome import Cause
from nrchain.run.interruption import Interruption
from nrchain.run.preparation import check_start
from nrchain.run.simulation import simulate_in_memory
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene
from nrchain.states.state import find_state
from nrchain.trajectory.trajectory import Trajectory
from nrchain.wording import brief

UNSETTLED = "unsettled"
"""The kind of a run that ended before it settled."""

UNDECIDED = (UNSETTLED, FAILED)
"""Kinds that say nothing about the attractor, if another start tells it."""


@dataclass(frozen=True)
class Trial:
    """One run at a point.

    Attributes
    ----------
    start
        Its start.
    kind
        What it ends in: a value of :class:`nrchain.measure.Attracted`, or ``"failed"``.
    since, period
        Time from which on it is settled, and its period, where there are any.
    numbers
        What decided, by name.
    end
        Time that it reached.
    length
        End and snapshots that it was given, and whether the straight chain asks for more.
    steps
        Steps that it took.
    seconds
        Processor time, no part of a comparison.
    why
        Why it stopped early, failed or has not settled; empty for others.
    """

    start: str
    kind: str
    since: float | None
    period: float | None
    numbers: Mapping[str, float]
    end: float
    length: Length
    steps: int
    seconds: float = field(compare=False)
    why: str

    __repr__ = brief
    _repr_html_ = record_html

    @classmethod
    def of(cls, start: str, length: Length, result: Result) -> Trial:
        """The trial of the result of :func:`run_trial`."""
        if FAILED in result:
            return cls(start, FAILED, None, None, {}, 0.0, length, 0, 0.0, result[FAILED])
        end, snapshots, is_capped = result["length"]
        return cls(
            start=start,
            kind=result["kind"],
            since=result["since"],
            period=result["period"],
            numbers=result["numbers"],
            end=result["end"],
            length=Length(end, snapshots, is_capped, length.most),
            steps=result["steps"],
            seconds=result["seconds"],
            why=result["why"],
        )


@dataclass(frozen=True)
class PhasePoint:
    """A point of the plane: the growth of the straight chain there, and its runs.

    Attributes
    ----------
    x, y
        The values of the two keys.
    growth, frequency
        Re Λ₁ and |Im Λ₁| of the straight chain; NaN where it has no spectrum.
    trials
        One for each start.
    """

    site: Site
    x: float
    y: float
    growth: float
    frequency: float
    trials: tuple[Trial, ...]

    __repr__ = brief
    _repr_html_ = record_html

    @property
    def kinds(self) -> tuple[str, ...]:
        """What the runs end in, each kind once, in alphabetical order.

        A run that has not settled, or failed, counts only if all have.
        """
        kinds = {trial.kind for trial in self.trials}
        return tuple(sorted(kinds.difference(UNDECIDED) or kinds))

    @property
    def kind(self) -> str:
        """The kinds in words; there are several where more than one attractor is stable."""
        return " or ".join(self.kinds)


def simulated(
    scene: Scene,
    start: str,
    length: Length,
    interruption: Interruption | None,
    *,
    verify: bool = False,
) -> Trajectory:
    """The run of a scene from a start, over a length.

    Raises KeyboardInterrupt if it is interrupted.
    """
    # a run with an end costs a fraction of one that looks at each snapshot whether it has settled
    changes = {"end": length.end, "snapshots": length.snapshots, "until": "end"}
    run = load_scene(scene, run=changes | {"verify": verify})
    checked = check_start(run, *start_poses(run, start))
    done = simulate_in_memory(checked, report=ignore, interruption=interruption)
    if done.cause is Cause.INTERRUPTED:
        raise KeyboardInterrupt(done.reason)
    return done


def run_trial(
    scene: Scene, start: str, length: Length, interruption: Interruption | None = None
) -> Result:
    """Run a scene from a start, and say what it ends in.

    A run that has not settled in its length is made again with a longer one.
    """
    done = simulated(scene, start, length, interruption)
    found, steps, seconds = measure.attractor(done, further=False), _steps(done), _seconds(done)
    is_near = found.period is not None and found.since is None
    if found.kind.value == UNSETTLED or is_near:
        # a cycle that is only neared may be one that the chain passes by
        longer = _longer(done, length)
        if longer is not None:
            length = longer
            done = simulated(scene, start, length, interruption)
            steps, seconds = steps + _steps(done), seconds + _seconds(done)
        found = reached(done)
    return {
        "kind": found.kind.value,
        "since": found.since,
        "period": found.period,
        "numbers": {key: float(value) for key, value in found.numbers.items()},
        "length": [length.end, length.snapshots, length.is_capped],
        "end": float(done.time[-1]),
        "steps": steps,
        "seconds": seconds,
        "why": _why(done, found),
    }


def _why(done: Trajectory, found: measure.Attractor) -> str:
    """Why a run stopped or has not settled; empty for others."""
    if done.status == "stopped":
        return done.reason
    return found.confidence if found.kind.value == UNSETTLED else ""


def reached(done: Trajectory) -> measure.Attractor:
    """The attractor of a run; the chain goes on only where the snapshots do not tell."""
    found = measure.attractor(done, further=False)
    return measure.attractor(done) if found.kind.value == UNSETTLED else found


def _longer(done: Trajectory, length: Length) -> Length | None:
    """The length of a second run; None after one that stopped before its end."""
    if done.status == "stopped":
        return None
    try:
        state = find_state(done.scene, done, modes=1)
    except NrchainError:
        return length.longer()
    return length.longer(state.spectrum.leading.growth)


def _steps(done: Trajectory) -> int:
    return int(done.counters.get("steps", 0))


def _seconds(done: Trajectory) -> float:
    return float(done.counters.get("processor_time", math.nan))
