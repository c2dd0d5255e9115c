"""d(t) = min_g ‖g X(0) − X(t)‖: when the shape of a chain returns, and the orbit it goes round.

The last snapshot of a run is compared with earlier ones, up to motions g of the chain as a whole.
A run from there over one period, with closer snapshots, gives the orbit from which Newton's method
begins.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nrchain.comoving.motions import moved
from nrchain.comoving.relative import RelativeChain
from nrchain.errors import SceneError, Words
from nrchain.run.preparation import check_start
from nrchain.run.simulation import simulate_in_memory
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene
from nrchain.states.cycles.carrying import carry, fit, rates
from nrchain.states.cycles.charts import chart
from nrchain.states.cycles.orbit import FIRST, Orbit, orbit_of
from nrchain.trajectory.trajectory import Trajectory
from nrchain.types import Poses

COMPARED = 1000
"""Most snapshots that are compared with the last one."""

RETURNED = 0.15
"""A shape has returned if d is below this fraction of the largest d of the orbit."""

LEFT = 0.5
"""It has left before if d was above this fraction."""

AS_NEAR = 3.0, 0.02
"""The first return counts that is as near as the nearest one times the first of these, or nearer
than the second one as a fraction of the largest d."""

STILL = 1e-6
"""A shape that changes by less than this fraction of d has settled."""

SAMPLES = 400
"""Snapshots of the run over one period and a quarter, and of one that seeks a return."""


class Return(NamedTuple):
    """When a shape has returned, and d there over the largest d."""

    time: float
    distance: float


def orbit_from_run(scene: Scene, run: Trajectory) -> tuple[RelativeChain, Orbit]:
    """The orbit that a run goes round in the end; an error says how nearly it returns."""
    begin = run.positions[-1], run.frames[-1]
    chain = RelativeChain(scene, begin)
    back = slice(None, -COMPARED - 1, -1)
    earlier = _returns(chain, run.time[-1] - run.time[back], run.positions[back], run.frames[back])
    tried = [one for one in earlier if one.distance <= RETURNED]
    durations = [1.25 * _first(tried).time] if tried else []
    durations.append(float(run.time[-1] - run.time[0]))
    best = min((one.distance for one in earlier), default=np.inf)
    for duration in durations:
        on = _run_on(scene, begin, duration)
        if on.status != "completed":
            raise SceneError("guess", Words("the run"), f"does not go on from its end: {on.reason}")
        found = _returns(chain, on.time, on.positions, on.frames)
        best = min([best, *(one.distance for one in found)])
        near = [one for one in found if one.distance <= RETURNED]
        if near:
            return chain, _orbit(chain, on, _first(near).time)
    allowed = (
        f"is not nearly periodic: the shape returns to {best:.2g} of its largest excursion at best,"
        f" and {RETURNED} is needed; run it longer, until its oscillation has settled"
    )
    if not np.isfinite(best):
        allowed = (
            "does not return to its shape: run it over several periods, with snapshots that resolve"
            " each"
        )
    raise SceneError("guess", Words("the run"), allowed)


def _run_on(scene: Scene, begin: Poses, duration: float) -> Trajectory:
    """A run from given poses."""
    times = {"run.end": duration, "run.snapshots": SAMPLES + 1, "run.verify": False}
    start = check_start(load_scene(scene, **times), *begin, None)
    return simulate_in_memory(start, report=lambda text: None)


def _first(returns: list[Return]) -> Return:
    """The first of the returns that are as near as any."""
    nearest = min(one.distance for one in returns)
    enough = max(AS_NEAR[0] * nearest, AS_NEAR[1])
    return next(one for one in returns if one.distance <= enough)


def _returns(
    chain: RelativeChain, times: np.ndarray, positions: np.ndarray, frames: np.ndarray
) -> list[Return]:
    """Where the distance from the first pose has a minimum after the shape has left it."""
    begin = positions[0], frames[0]
    away = np.array([fit(chain, begin, pose)[1] for pose in zip(positions, frames, strict=True)])
    largest = float(away.max(initial=0.0))
    if largest <= STILL * chain.scene.chain.spacing:
        allowed = "has settled: its shape does not change; find_state finds states of steady motion"
        raise SceneError("guess", Words("the run"), allowed)
    left = np.flatnonzero(away > LEFT * largest)
    found = []
    for k in range(int(left[0]) + 1, len(away) - 1):
        if away[k] <= away[k - 1] and away[k] < away[k + 1]:
            time, square = _vertex(times[k - 1 : k + 2], away[k - 1 : k + 2] ** 2)
            found.append(Return(time, float(np.sqrt(max(square, 0.0))) / largest))
    return found


def _vertex(times: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """Place and height of the minimum of the parabola through three points."""
    curve = np.polyfit(times - times[1], values, 2)
    shift = -0.5 * curve[1] / curve[0]
    return float(times[1] + shift), float(np.polyval(curve, shift))


def _orbit(chain: RelativeChain, run: Trajectory, period: float) -> Orbit:
    """The orbit of a run whose shape returns after a period, in axes that go along."""

    def at(time: float) -> Poses:
        k = int(np.clip(np.searchsorted(run.time, time) - 1, 0, len(run.time) - 2))
        share = (time - run.time[k]) / (run.time[k + 1] - run.time[k])
        begin = run.positions[k], run.frames[k]
        return moved(*begin, share * chart(run.positions[k + 1], run.frames[k + 1], begin))

    drift = rates(chain, fit(chain, at(0.0), at(period))[0]) / period

    def along(fraction: float) -> Poses:
        time = fraction * period
        return carry(chain, drift, -time).applied(at(time), chain.origin)

    return orbit_of(along, period, drift, np.full(FIRST, 1.0 / FIRST))
