"""Which attractor a run has reached, since when, and how sure that is."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from nrchain.analysis.measure.attractors.alignment import first_inside
from nrchain.analysis.measure.attractors.kinds import Attracted, Attractor
from nrchain.analysis.measure.attractors.lyapunov import lyapunov
from nrchain.analysis.measure.attractors.steady import steady_attractor
from nrchain.analysis.measure.line_fit import Estimate
from nrchain.analysis.measured_chain import MeasurementError, positions_of, require_trajectory
from nrchain.comoving.recurrence import (
    CANDIDATE,
    NEARLY,
    RECURS,
    Cycle,
    find_cycle,
    frequency,
)
from nrchain.comoving.relative import RelativeChain
from nrchain.comoving.shapes import Series
from nrchain.comoving.tangents import FEWEST, PERIODS, largest_exponent
from nrchain.errors import SceneError
from nrchain.notices import ignore
from nrchain.outcome import Cause
from nrchain.run.preparation import check_start
from nrchain.run.simulation import simulate_in_memory
from nrchain.trajectory.trajectory import Trajectory

STOPS = {Cause.TOUCH: Attracted.TOUCHING, Cause.TURN: Attracted.TORN, Cause.CHART: Attracted.TORN}
"""What a chain ends in if it stops for one of these causes."""

RESUMABLE = (None, Cause.BUDGET, Cause.INTERRUPTED)
"""Causes of a stop after which the chain itself can go on."""

HALF_ROUND = math.tan(math.pi / 8.0)
"""Ratio of the axes of an ellipse half-way, in angle, between a line and a circle."""

FINE, LONG = 40, 16
"""Snapshots in a period, and periods, of the chain that goes on."""

LATE = 64
"""Snapshots at which it is found how fast a shape changes."""

CERTAIN, FAR = 3.0, 3.0
"""Standard errors by which a Lyapunov exponent must exceed 0 to make a motion irregular, and the
logarithm of the growth of small changes that must be seen."""

STATIONARY = 0.5
"""An irregular motion keeps its mean to this part of its extent, and its extent to this part."""


def attractor(trajectory: Trajectory, *, further: bool = True) -> Attractor:
    """The kind of attractor at the end of a run, since when, and the numbers that decided.

    Parameters
    ----------
    trajectory
        A run, with whatever snapshots.
    further
        Whether the chain may go on from the last snapshot, for at most as long as the run again,
        where the snapshots do not tell. They are then close enough to see a period.

    A run that stopped because spheres touch, or because a link has turned by a quarter turn, ends
    as "touching" or "torn".

    Steady: Newton's method goes from the last snapshot to the next state. If no mode of it grows,
    and the chain is within 0.1 a of it, the run ends in this state. ``since`` is the first snapshot
    from which on all spheres are within 1e-3 a of it, but for motions of the chain as a whole, or
    None if the chain is still farther away. The kind is "straight", "buckled" or "coiled" at rest,
    "swimming", "spinning" or "rotating shape" if the chain moves by more than a, or turns by more
    than 1 rad, in the time of the run.

    Periodic: the strains of all links recur after a period, to 1 % of their amplitude, and their
    amplitude will not change by more than 1 % if its change goes on as a geometric series.
    ``since`` is the first snapshot from which on they are within 2 % of the amplitude from the
    orbit, or None where the chain gets there later. A shape that recurs to 5 % has a kind too, and
    no ``since``. If the bends go round, on ellipses nearer to a circle than to a line,
    the kind is "rotating shape". Otherwise it is "travelling oscillation" or "standing
    oscillation", by the phase of the bends along the chain. With ``further``, the rate at which
    small changes beside the cycle grow is among the numbers, and ``confidence`` says if it is above
    0: a start that keeps a plane may lead to a cycle that others leave.

    Irregular: neither, the largest Lyapunov exponent (:func:`lyapunov`) of the chain that goes on
    exceeds 0 by three standard errors, small changes grow by more than e³, and the shape keeps its
    mean and the extent of its motion. Anything else is "unsettled", and ``confidence`` says why.

    Raises :class:`~nrchain.analysis.measured_chain.MeasurementError` for a trajectory without
    snapshots.
    """
    positions = positions_of(require_trajectory(trajectory))
    if not len(positions):
        raise MeasurementError("the trajectory has no snapshots")
    if trajectory.cause in STOPS:
        return _stopped(trajectory)
    try:
        return _moving(trajectory, positions, further)
    except (SceneError, FloatingPointError, np.linalg.LinAlgError) as error:
        return Attractor(Attracted.UNSETTLED, confidence=f"no twists at the end: {error}")


def _stopped(trajectory: Trajectory) -> Attractor:
    assert trajectory.cause is not None
    kind = STOPS[trajectory.cause]
    return Attractor(kind, float(trajectory.time[-1]), confidence=trajectory.reason)


def _moving(trajectory: Trajectory, positions: np.ndarray, further: bool) -> Attractor:
    """The attractor of a run that has not broken off."""
    steady = steady_attractor(trajectory, positions)
    if steady is not None:
        return steady
    if trajectory.cause not in RESUMABLE:
        return Attractor(Attracted.UNSETTLED, confidence=f"the run stops {trajectory.reason}")
    scene = trajectory.scene
    chain = RelativeChain(scene, (positions[-1], trajectory.frames[-1]))
    if not chain.dimension:
        return Attractor(Attracted.UNSETTLED, confidence="no sphere is free to move")
    series = Series(chain, trajectory.time, positions, trajectory.frames)
    found = find_cycle(series)
    if isinstance(found, Cycle) and found.persists(RECURS):
        return _periodic(found, series, trajectory if further else None)
    if further and trajectory.time[-1] > 0.0:
        return _further(trajectory, series)
    return _not_settled(found)


def _further(trajectory: Trajectory, series: Series) -> Attractor:
    """The attractor that the chain reaches if it goes on for some of its periods."""
    duration = float(trajectory.time[-1])
    period = 2.0 * math.pi / max(frequency(series.late(LATE)), 1e-300)
    length = min(LONG * period, duration)
    run = replace(
        trajectory.scene.run,
        end=length,
        snapshots=int(min(FINE * max(length / period, 1.0), 4000)) + 1,
        verify=False,
        until="end",
        max_steps=None,
        max_seconds=None,
    )
    scene = replace(trajectory.scene, run=run)
    start = check_start(scene, trajectory.positions[-1], trajectory.frames[-1])
    more = simulate_in_memory(start, report=ignore)
    if more.cause in STOPS:
        ended = _stopped(more)
        return replace(
            ended, since=None, confidence=f"goes on from the last snapshot: {more.reason}"
        )
    positions = positions_of(more)
    steady = steady_attractor(more, positions)
    if steady is not None:
        return replace(
            steady, since=None, confidence=f"after {length:.4g} more; {steady.confidence}"
        )
    going_on = Series(series.chain, more.time, positions, more.frames)
    found = find_cycle(going_on)
    if isinstance(found, Cycle):
        is_found = found.persists(RECURS)
        return _periodic(found, series, more) if is_found else _not_settled(found)
    return _irregular(more, going_on, found)


def _irregular(more: Trajectory, series: Series, why: str) -> Attractor:
    """Irregular, if the chain keeps on moving as much and small changes grow by far."""
    try:
        exponent = lyapunov(more)
    except MeasurementError:
        return _not_settled(why)
    values = series.late(LATE).values
    earlier, later = values[: len(values) // 2], values[len(values) // 2 :]
    numbers = {
        "exponent": exponent.value,
        "exponent error": exponent.error,
        "growth of a change": exponent.value * float(more.time[-1]),
        "shift": float(np.linalg.norm(later.mean(axis=0) - earlier.mean(axis=0))) / _extent(later),
        "change of extent": abs(math.log(_extent(later) / _extent(earlier))),
    }
    is_sure = exponent.value > CERTAIN * exponent.error and numbers["growth of a change"] > FAR
    if is_sure and max(numbers["shift"], numbers["change of extent"]) < STATIONARY:
        words = f"largest Lyapunov exponent {exponent}, over {more.time[-1]:.4g} more"
        return Attractor(Attracted.IRREGULAR, None, None, numbers, words)
    return _not_settled(why, numbers)


def _extent(values: np.ndarray) -> float:
    """rms |x − ⟨x⟩|."""
    return max(float(np.sqrt(((values - values.mean(axis=0)) ** 2).sum(axis=1).mean())), 1e-300)


def _periodic(cycle: Cycle, series: Series, fine: Trajectory | None) -> Attractor:
    """The attractor of a shape that recurs, since it is near the orbit in the series.

    Whether small changes grow out of it is found on ``fine``, if that is given.
    """
    count = len(series.time)
    first = first_inside(count, lambda places: cycle.distances(series.at(places)) > 2.0 * RECURS)
    since = float(series.time[first]) if first < count else None
    words = f"recurs to {cycle.change:.1g} of its amplitude in a period"
    found = _of_cycle(cycle, since, words)
    exponent = None if fine is None else _exponent_on(cycle, fine, series.chain)
    if exponent is None:
        return found
    numbers = {**found.numbers, "exponent": exponent.value, "exponent error": exponent.error}
    grows = exponent.value > CERTAIN * exponent.error and exponent.value * cycle.period > RECURS
    if grows:
        words = f"unstable: small changes grow at rate {exponent}; {words}"
    return replace(found, numbers=numbers, confidence=words)


def _exponent_on(cycle: Cycle, fine: Trajectory, chain: RelativeChain) -> Estimate | None:
    """The exponent of changes beside the cycle, over its last periods; None for few snapshots."""
    count = len(fine.time)
    spacing = float(fine.time[-1] - fine.time[0]) / (count - 1)
    stride = max(int(cycle.period / (FINE * spacing)), 1)
    seen = min(count - 1, round(PERIODS * cycle.period / spacing))
    places = np.arange(count - 1, count - 2 - seen, -stride)[::-1]
    if len(places) < FEWEST:
        return None
    time, frames = fine.time[places], fine.frames[places]
    positions = positions_of(fine)[places]
    try:
        return Estimate(*largest_exponent(chain, time, positions, frames, beside=True))
    except ValueError:
        return None


def _of_cycle(cycle: Cycle, since: float | None, words: str) -> Attractor:
    if cycle.ellipticity > HALF_ROUND:
        kind = Attracted.ROTATING
    else:
        is_wave = cycle.travelling > HALF_ROUND
        kind = Attracted.TRAVELLING if is_wave else Attracted.STANDING
    return Attractor(kind, since, cycle.period, _numbers(cycle), words)


def _numbers(cycle: Cycle) -> dict[str, float]:
    return {
        "change in a period": cycle.change,
        "change tolerance": RECURS,
        "amplitude": cycle.amplitude,
        "amplitude growth": cycle.growth,
        "amplitude change left": cycle.left,
        "travelling": cycle.travelling,
        "ellipticity": cycle.ellipticity,
        "half round": HALF_ROUND,
    }


def _not_settled(found: Cycle | str, numbers: dict[str, float] | None = None) -> Attractor:
    """What is known of a run that has not reached an attractor, or is only near it."""
    if isinstance(found, str):
        return Attractor(Attracted.UNSETTLED, None, None, numbers or {}, found)
    if found.change > CANDIDATE:
        words = "the shape does not recur"
        return Attractor(Attracted.UNSETTLED, None, None, _numbers(found), words)
    part = math.expm1(found.growth * found.period)
    words = (
        f"oscillates with period {found.period:.4g}: in a period its amplitude changes by"
        f" {part:.1%} and its shape by {found.change:.1%} of it"
    )
    if found.persists(NEARLY):
        return _of_cycle(found, None, f"approaches a cycle: {words}")
    return Attractor(Attracted.UNSETTLED, None, None, _numbers(found), words)
