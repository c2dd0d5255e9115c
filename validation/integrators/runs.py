"""error = max(|r − r′|/a, ∠(frame, frame′)): each integrator at each tolerance, on one scene.

Errors are distances from a run of Radau IIA at 1e-11, or 1e-10 with all pairs. Its own error is
below its distance from CVODE at 2e-11, another scheme. It is also that of Radau IIA at 1e-8, in
proportion to the tolerance. Scenes in which the two schemes do not meet have no reference.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from statistics import median

import numpy as np

from nrchain import Cause, Scene, SceneError, Trajectory, load_scene
from nrchain.accuracy.timing import distance, run_timed
from nrchain.planning.counted_work import evaluation_work
from validation.integrators.scenes import classes, is_near

INTEGRATORS = ("cvode", "radau", "scipy-bdf")
TOLERANCES = tuple(10.0**-k for k in range(3, 9))

EVALUATIONS = {"cvode": 1.5, "radau": 8.0, "scipy-bdf": 2.7}
"""Right-hand sides of a step, as a rule: they turn an amount of work into a number of steps."""

REFERENCE = {True: 1e-11, False: 1e-10}
"""Tolerance of the reference of a scene of near neighbours, and of one with all pairs."""

CHECKED = "cvode", 2e-11
MEET = 1e-6
"""The run that checks a reference, and the largest distance between the two."""

PILOT = "cvode", 2e-5
PILOTED = {True: 0.3, False: 0.1}
"""A first run decides how long a scene is: it may take this many nominal seconds. Near neighbours
may take more, because the solves with all pairs are iterations."""

WHOLE = 0.8
"""A scene that stops or takes too long runs to this part of the time that its first run reaches."""

LONGEST = {True: 3.0, False: 0.7}
LONGEST_REFERENCE = {True: 30.0, False: 4.0}
"""Nominal seconds of a run, and of a reference, if all neighbours are near or not; longer runs are
dropped."""

REPEATS = 3
REPEATED = 0.3
"""Runs of more seconds than this are run once."""

CONVERGED = 3.0
"""Error of the reference, at most, over what the error of the tightest run says in proportion."""

TRUSTED = 0.05
"""Largest error of a reference, over the tolerance of a run that counts."""

COMPLETED, REFUSED, TOO_LONG = "completed", "refused", "too long"


@dataclass(frozen=True)
class Run:
    """One integrator at one tolerance (rtol = atol).

    ``position`` and ``frame`` are the largest errors over the snapshots, in radii and radians.
    ``ended`` is "completed", "refused", "too long" or the cause of a stop.
    """

    integrator: str
    tolerance: float
    ended: str
    position: float = np.inf
    frame: float = np.inf
    steps: int = 0
    evaluations: int = 0
    jacobians: int = 0
    seconds: float = np.nan

    @property
    def error(self) -> float:
        """The larger of both errors, in radii or radians."""
        return max(self.position, self.frame)


@dataclass(frozen=True)
class Mapped:
    """All runs of a scene, to t = ``end``.

    ``path`` is the longest displacement of a sphere, in radii. ``apart`` is the distance of the
    reference from CVODE at 2e-11, ``floor`` the bound of its error, in radii or radians.
    """

    name: str
    end: float
    classes: tuple[str, ...]
    path: float
    apart: float
    floor: float
    runs: tuple[Run, ...]

    def trusts(self, tolerance: float) -> bool:
        """Whether the reference is accurate enough for runs at a tolerance."""
        return self.floor <= TRUSTED * tolerance

    def completed(self, integrator: str) -> list[Run]:
        """The runs that reach their end and whose error is known, from loose to tight."""
        mine = [run for run in self.runs if run.integrator == integrator]
        return [run for run in mine if run.ended == COMPLETED and self.trusts(run.tolerance)]


def shorten(scene: Scene) -> Scene:
    """The scene up to a time that all of its runs reach."""
    ended, pilot, _ = _timed(scene, *PILOT, PILOTED[is_near(scene)])
    if pilot is None or ended == COMPLETED:
        return scene
    return load_scene(scene, **{"run.end": WHOLE * float(pilot.time[-1])})


def map_scene(name: str, scene: Scene, tolerances: tuple[float, ...], repeats: int) -> Mapped | str:
    """Measure a scene; if it has no reference, the reason."""
    references = []
    finest, longest = REFERENCE[is_near(scene)], LONGEST_REFERENCE[is_near(scene)]
    for integrator, tolerance in (("radau", finest), CHECKED):
        ended, trajectory, _ = _timed(scene, integrator, tolerance, longest)
        if trajectory is None or ended != COMPLETED:
            return f"{integrator} at {tolerance:g}: {ended}"
        references.append(trajectory)
    reference, check = references
    apart = max(distance(check, reference))
    if apart > MEET:
        return f"the two schemes are {apart:.1g} apart"
    runs = _run_all(scene, tolerances, reference)
    moved = np.linalg.norm(reference.positions - reference.positions[0], axis=-1).max()
    proportional = runs["radau", tolerances[-1]].error * finest / tolerances[-1]
    doubt = min(apart, CONVERGED * proportional)
    return Mapped(
        name, scene.run.end, classes(scene), float(moved) / scene.chain.radius, apart, doubt,
        tuple(_repeat(scene, runs, repeats)),
    )  # fmt: skip


def _run_all(
    scene: Scene, tolerances: tuple[float, ...], reference: Trajectory
) -> dict[tuple[str, float], Run]:
    """Every integrator from loose to tight; what follows a run that takes too long is left out."""
    runs: dict[tuple[str, float], Run] = {}
    for integrator in INTEGRATORS:
        too_long = False
        for tolerance in tolerances:
            run = Run(integrator, tolerance, TOO_LONG)
            if not too_long:
                run = _measure(scene, integrator, tolerance, reference)
                too_long = run.ended == TOO_LONG
            runs[integrator, tolerance] = run
    return runs


def _measure(scene: Scene, integrator: str, tolerance: float, reference: Trajectory) -> Run:
    ended, trajectory, seconds = _timed(scene, integrator, tolerance, LONGEST[is_near(scene)])
    if trajectory is None or ended != COMPLETED:
        return Run(integrator, tolerance, ended)
    counts = trajectory.counters
    return Run(
        integrator, tolerance, ended, *distance(trajectory, reference),
        int(counts["steps"]), int(counts["evaluations"]), int(counts["jacobians"]), seconds,
    )  # fmt: skip


def _repeat(scene: Scene, runs: Mapping[tuple[str, float], Run], repeats: int) -> Iterator[Run]:
    """The runs with the median of their processor times; repetitions take turns."""
    times = {key: [run.seconds] for key, run in runs.items()}
    short = [key for key, run in runs.items() if run.seconds < REPEATED]
    for _ in range(repeats - 1):
        for key in short:
            times[key].append(_timed(scene, *key, LONGEST[is_near(scene)])[2])
    for key, run in runs.items():
        yield replace(run, seconds=median(times[key]))


def _timed(
    scene: Scene, integrator: str, tolerance: float, longest: float
) -> tuple[str, Trajectory | None, float]:
    """How a run ends, its trajectory unless it is refused, and its processor time."""
    steps = longest / (EVALUATIONS[integrator] * evaluation_work(scene))
    keys = {
        "run.integrator": integrator,
        "run.rtol": tolerance,
        "run.atol": tolerance,
        "run.max_steps": int(steps),
    }
    try:
        trajectory, cost = run_timed(load_scene(scene, **keys))
    except SceneError as error:
        return (REFUSED if error.key == "run.atol" else f"{REFUSED}: {error.key}"), None, np.nan
    if trajectory.status == COMPLETED:
        return COMPLETED, trajectory, cost.seconds
    ended = TOO_LONG if trajectory.cause is Cause.BUDGET else str(trajectory.cause)
    return ended, trajectory, cost.seconds
