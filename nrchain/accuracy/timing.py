"""Runs side by side: how far each is from a reference, and what it costs.

How much is run is decided by counted work (:mod:`nrchain.planning.nominal_cost`), so that it is the
same on every machine; the time it takes is that of :mod:`nrchain.work`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from statistics import median

import numpy as np

from nrchain.errors import SceneError
from nrchain.notices import nobody
from nrchain.outcome import Cause
from nrchain.planning.nominal_cost import evaluation_cost
from nrchain.run.simulate import Progress, simulate_telling
from nrchain.run.work import FEWEST_STEPS, RunCost, Work, cost_of
from nrchain.scene.scene import Scene, load_scene
from nrchain.trajectory.trajectory import Trajectory

REPEATS = 5

PILOT = 0.45
"""Nominal seconds that the first run of a scene may take, by which its cost is foretold."""

SNAPSHOTS = 33


@dataclass(frozen=True)
class Measured:
    """One setting: its distance from the reference, and what it costs.

    ``position`` is the largest distance of a sphere in radii, over all snapshots, and ``frame`` the
    largest angle between frames, in radians; infinite if the run did not reach its end. ``work`` is
    what it took by count, and ``nominal`` the seconds that stand for it; ``seconds`` is the
    processor time of all repetitions, and ``late`` the part of the right-hand sides that fell in
    the second half of the time simulated.
    """

    position: float
    frame: float
    work: Work
    seconds: tuple[float, ...]
    late: float
    nominal: float

    @property
    def error(self) -> float:
        """The larger of the two, in radii and radians."""
        return max(self.position, self.frame)

    @property
    def median(self) -> float:
        """Processor time of the repetition in the middle."""
        return median(self.seconds)


@dataclass(frozen=True)
class Foretold:
    """The scene, to its end or to as far as was allowed; the run of it; what all of it costs."""

    scene: Scene
    trajectory: Trajectory
    cost: RunCost


def distance(trajectory: Trajectory, reference: Trajectory) -> tuple[float, float]:
    """max |r − r′|/a and max ∠(frame, frame′) over spheres and snapshots, in radii and radians.

    The angle is that of the rotation between frames, exact down to rounding. Infinite where the
    snapshots are not those of the reference, as of a run that stopped before its end.
    """
    if not np.array_equal(trajectory.time, reference.time):
        return math.inf, math.inf
    apart = np.linalg.norm(trajectory.positions - reference.positions, axis=-1)
    between = np.einsum("tnak,tnam->tnkm", trajectory.frames, reference.frames)
    sine = np.linalg.norm(
        [between[..., (k + 2) % 3, (k + 1) % 3] - between[..., (k + 1) % 3, (k + 2) % 3]
         for k in range(3)],
        axis=0,
    )  # fmt: skip
    cosine = np.trace(between, axis1=-2, axis2=-1) - 1.0
    radius = reference.scene.chain.radius
    return float(apart.max() / radius), float(np.arctan2(sine, cosine).max())


simulate_quietly = partial(simulate_telling, nobody)
"""A run without warnings of settings that are tried to be measured."""


def run_timed(scene: Scene) -> tuple[Trajectory, RunCost]:
    """A run in memory, and what it cost."""
    passed: list[tuple[float, float]] = []

    def watch(progress: Progress) -> None:
        passed.append((progress.time, progress.counters["evaluations"]))

    trajectory = simulate_quietly(scene, progress=watch)
    times, evaluations = np.array(passed).T
    total = trajectory.counters["evaluations"]
    half = float(np.interp(0.5 * trajectory.time[-1], times, evaluations))
    return trajectory, cost_of(trajectory, 1.0 - half / total if total else 0.5)


def foretell(scene: Scene, allowed: float = PILOT, snapshots: int = SNAPSHOTS) -> Foretold:
    """What the run of a scene will cost, from a run of it, or of as much of it as is allowed.

    ``allowed`` are nominal seconds, about: a count, so that the same part of a scene is run on
    every machine. Where it does not do for the whole run, what it reaches is run once more, with
    ``snapshots`` that tell its pace. Budgets of the scene itself are left out of it.

    Raises :class:`~nrchain.errors.SceneError` for a scene that is refused.
    """
    steps = max(int(allowed / evaluation_cost(scene)), FEWEST_STEPS)
    free = {"run.snapshots": snapshots, "run.max_seconds": None}
    pilot, cost = run_timed(load_scene(scene, **free, **{"run.max_steps": steps}))
    free["run.max_steps"] = None
    if pilot.cause is not Cause.BUDGET:
        return Foretold(load_scene(scene, **free), pilot, cost)
    short = load_scene(scene, **free, **{"run.end": float(pilot.time[-1])})
    trajectory, cost = run_timed(short)
    return Foretold(short, trajectory, replace(cost, end=scene.run.end))


def measure_all(
    scenes: Mapping[str, Scene],
    reference: Trajectory,
    *,
    repeats: int = REPEATS,
    budget: float = math.inf,
    skip: Callable[[str, Mapping[str, Measured]], bool] | None = None,
) -> dict[str, Measured]:
    """Run scenes side by side, and again and again, against a reference with their snapshots.

    Repetitions are interleaved, so that what else the machine does falls on all alike. Every scene
    runs once, unless ``skip`` of its name and of what has been measured so far says no; it is
    repeated as far as a ``budget`` of nominal seconds allows. A scene whose integrator refuses it,
    or whose start its tolerance does not resolve, is left out.
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
        nominal = cost.work.evaluations * evaluation_cost(scene)
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
