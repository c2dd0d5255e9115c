"""Runs side by side: the distance of each from a reference, and its cost.

Counted work (:mod:`nrchain.planning.counted_work`) decides how much of a scene is run. So this is
the same on every machine. :mod:`nrchain.work` defines the times.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from statistics import median

import numpy as np

from nrchain.errors import SceneError
from nrchain.geometry.distances import pose_distances
from nrchain.motion.integrators import find_integrator
from nrchain.notices import ignore
from nrchain.outcome import Cause
from nrchain.planning.counted_work import evaluation_work
from nrchain.planning.integrator import integrator_of
from nrchain.run.preparation import check_start
from nrchain.run.recording import Progress
from nrchain.run.simulation import simulate_in_memory
from nrchain.run.work import FEWEST_STEPS, RunCost, Work, cost_of
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene
from nrchain.trajectory.trajectory import Trajectory

REPEATS = 5
"""Number of runs of each scene."""

PILOT = 0.45
"""Work of the first run of a scene, in nominal seconds; the cost of the scene follows from it."""

SNAPSHOTS = 33
"""Number of times at which runs are compared."""


@dataclass(frozen=True)
class Measured:
    """The distance of a run from the reference, and its cost.

    Attributes
    ----------
    position, frame
        Largest distance of a sphere, in radii, and largest angle of a frame, in radians, over all
        snapshots; infinite if the run did not reach its end.
    work, nominal
        Counts of the run, and the nominal seconds that they stand for.
    seconds
        Processor time of each repetition.
    late
        Fraction of the right-hand sides in the second half of the simulated time.
    """

    position: float
    frame: float
    work: Work
    seconds: tuple[float, ...]
    late: float
    nominal: float

    @property
    def error(self) -> float:
        """The larger of the two distances, in radii and radians."""
        return max(self.position, self.frame)

    @property
    def median(self) -> float:
        """Median of the processor times."""
        return median(self.seconds)


@dataclass(frozen=True)
class Prediction:
    """The part of a scene that was run, its trajectory, and the cost of the whole run."""

    scene: Scene
    trajectory: Trajectory
    cost: RunCost


def distance(trajectory: Trajectory, reference: Trajectory) -> tuple[float, float]:
    """max |r − r′|/a and max ∠(frame, frame′) over spheres and snapshots, in radii and radians.

    The angle of the rotation between both frames is exact down to rounding. Both are infinite if
    the runs have snapshots at different times, such as a run that stopped before its end.
    """
    if not np.array_equal(trajectory.time, reference.time):
        return math.inf, math.inf
    poses, others = ((one.positions, one.frames) for one in (trajectory, reference))
    apart, turned = pose_distances(poses, others)
    return float(apart.max() / reference.scene.chain.radius), float(turned.max())


def simulate_quietly(
    scene: Scene, progress: Callable[[Progress], None] | None = None
) -> Trajectory:
    """A run in memory, only to be measured: without warnings, and without ``run.verify``."""
    start = check_start(scene)
    alone = replace(start.scene, run=replace(start.scene.run, verify=False, until="end"))
    return simulate_in_memory(replace(start, scene=alone), progress, ignore)


def run_timed(scene: Scene) -> tuple[Trajectory, RunCost]:
    """Run a scene in memory; return its trajectory and its cost."""
    passed: list[tuple[float, float]] = []

    def watch(progress: Progress) -> None:
        passed.append((progress.time, progress.counters["evaluations"]))

    trajectory = simulate_quietly(scene, progress=watch)
    times, evaluations = np.array(passed).T
    total = trajectory.counters["evaluations"]
    half = float(np.interp(0.5 * trajectory.time[-1], times, evaluations))
    return trajectory, cost_of(trajectory, 1.0 - half / total if total else 0.5)


def predict_cost(scene: Scene, allowed: float = PILOT, snapshots: int = SNAPSHOTS) -> Prediction:
    """Predict the cost of a run, by running all of it or as much as ``allowed`` nominal seconds.

    Where these do not reach the end, the part that they reach is run once more, with ``snapshots``
    that show its pace. Budgets of the scene itself are ignored.

    Raises :class:`~nrchain.errors.SceneError` for a scene that is refused.
    """
    scheme = find_integrator(integrator_of(scene))
    steps = max(int(allowed / (evaluation_work(scene) * scheme.evaluations)), FEWEST_STEPS)
    free = {"run.snapshots": snapshots, "run.max_seconds": None}
    pilot, cost = run_timed(load_scene(scene, **free, **{"run.max_steps": steps}))
    free["run.max_steps"] = None
    if pilot.cause is not Cause.BUDGET:
        return Prediction(load_scene(scene, **free), pilot, cost)
    short = load_scene(scene, **free, **{"run.end": float(pilot.time[-1])})
    trajectory, cost = run_timed(short)
    return Prediction(short, trajectory, replace(cost, end=scene.run.end))


def measure_all(
    scenes: Mapping[str, Scene],
    reference: Trajectory,
    *,
    repeats: int = REPEATS,
    budget: float = math.inf,
    skip: Callable[[str, Mapping[str, Measured]], bool] | None = None,
) -> dict[str, Measured]:
    """Run each scene several times, and measure its distance from a reference and its cost.

    The scenes take turns, so that other programs on the machine affect all of them alike. Every
    scene runs once, unless ``skip(name, measured so far)`` is true, and again as far as a
    ``budget`` of nominal seconds allows. A scene is left out if its integrator refuses it or if
    its tolerance does not resolve its start.
    """
    found: dict[str, Measured] = {}
    for name, scene in scenes.items():
        if skip and skip(name, found):
            continue
        try:
            trajectory, cost = run_timed(scene)
        except SceneError as error:
            if error.key not in ("run.integrator", "run.atol"):
                raise
            continue
        nominal = cost.work.evaluations * evaluation_work(scene)
        apart = distance(trajectory, reference)
        found[name] = Measured(*apart, cost.work, (cost.seconds,), cost.late, nominal)
    left = budget - sum(measured.nominal for measured in found.values())
    for _ in range(repeats - 1):
        for name, measured in found.items():
            left -= measured.nominal
            if left > 0.0:
                again = run_timed(scenes[name])[1].seconds
                found[name] = replace(measured, seconds=(*measured.seconds, again))
    return found
