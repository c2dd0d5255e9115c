"""Measure error against work of a scene by short runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from nrchain.accuracy.cost.results import Point, WorkPrecision
from nrchain.accuracy.cost.settings import (
    REFERENCE,
    REFERENCES,
    SECOND_OPINION,
    TOLERANCES,
    Changes,
    reach_and_model,
    stepping_changes,
)
from nrchain.accuracy.timing import (
    PILOT,
    SNAPSHOTS,
    Measured,
    measure_all,
    predict_cost,
    simulate_quietly,
)
from nrchain.errors import SceneError
from nrchain.planning.checked_start import starting_poses
from nrchain.progress import Shown, updates
from nrchain.run.work import RunCost
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene
from nrchain.trajectory.trajectory import Trajectory

BUDGET = 30.0
"""Work of all short runs together, about, in nominal seconds
(:mod:`nrchain.planning.counted_work`)."""

PILOT_SHARE = PILOT / BUDGET
"""Fraction of the budget that one run with the scene's own setting may take."""

LARGEST = 2000
"""Largest number of spheres for which reach and model are compared with all pairs: their cost grows
as N²."""


def work_precision(
    scene: Scene,
    *,
    budget: float = BUDGET,
    progress: bool | Callable[[str], None] | None = None,
) -> WorkPrecision:
    """Measure error against work of a scene, by short runs of about ``budget`` nominal seconds.

    Each short run takes at most 1.5 % of the budget with the scene's own setting. It covers the
    whole run, or as much of its beginning as that allows. Nominal seconds are counted, not timed:
    the runs are the same on every machine. ``progress`` is True for a bar in a terminal or
    a notebook, or a function that gets the name of each stage. A scene with
    ``effects = "auto"`` has its effects chosen first.

    Raises :class:`~nrchain.errors.SceneError` for a budget that is not a number above 0, for a
    scene that is refused, and for one that stops before the end of the short runs.
    """
    if not (math.isfinite(budget) and budget > 0):
        raise SceneError("budget", budget, "must be a finite number of seconds above 0")
    starting_poses(scene)
    if scene.effects == "auto":
        from nrchain.planning.auto import choose

        scene, _ = choose(scene)
    with updates(progress, lambda stage: Shown(0.0, None, f"measuring {stage}")) as update:
        return _measured(scene, budget, update or (lambda stage: None))


def _measured(scene: Scene, budget: float, report: Callable[[str], None]) -> WorkPrecision:
    """The work and the errors of all settings; ``report`` gets the name of each stage."""
    report("how much of the run fits the budget")
    short, own = _shortened(scene, PILOT_SHARE * budget)
    report("the reference")
    reference, name, error = _reference(short)
    report("integrators and tolerances")
    points, skipped = _stepping(short, reference, budget)
    report("reach of the flows, hydrodynamic model")
    further, unmeasured = _reach_and_model(short, budget)
    skipped += unmeasured
    return WorkPrecision(scene, short.run.end, own, points + further, name, error, skipped)


def _shortened(scene: Scene, allowed: float) -> tuple[Scene, RunCost]:
    """The scene up to the time that the allowed work reaches, and what the whole run costs."""
    found = predict_cost(scene, allowed, 9 if scene.chain.particles > LARGEST else SNAPSHOTS)
    if found.trajectory.status != "completed":
        allowed_end = f"the run stops {found.trajectory.reason}; choose an end before that"
        raise SceneError("run.end", scene.run.end, allowed_end)
    return found.scene, found.cost


def _stepper(scene: Scene, integrator: str, tolerance: float) -> Scene:
    """The scene with another integrator and other tolerances."""
    return load_scene(scene, **stepping_changes(integrator, tolerance))


def _reference(short: Scene) -> tuple[Trajectory, str, float]:
    """The reference run, its name, and its distance from an independent run."""
    scheme, tolerance = REFERENCE
    while True:
        reference = simulate_quietly(_stepper(short, scheme, tolerance))
        if reference.status == "completed" or tolerance > 1e-10:
            break
        tolerance *= 10.0
    for other in SECOND_OPINION:
        found = measure_all({"": _stepper(short, *other)}, reference, repeats=1)
        if found:
            break
    else:
        loosest = max(tolerance for _, tolerance in SECOND_OPINION)
        allowed = f"must be large enough for a tolerance of {loosest:g} to resolve the start"
        raise SceneError("start.amplitude", short.start.amplitude, allowed)
    return reference, f"{scheme} at {tolerance:.0e}", found[""].error


def _stepping(short: Scene, reference: Trajectory, budget: float) -> tuple[list[Point], list[str]]:
    """All integrators at all tolerances, loose ones first; costly ones are left out."""
    changes = {
        f"{scheme}, {tolerance:.0e}": stepping_changes(scheme, tolerance)
        for scheme, tolerances in TOLERANCES.items()
        for tolerance in tolerances
    }

    def too_long(name: str, found: Mapping[str, Measured]) -> bool:
        return _too_long(changes, name, found, budget / 10.0)

    scenes = {name: load_scene(short, **change) for name, change in changes.items()}
    found = measure_all(scenes, reference, budget=0.6 * budget, skip=too_long)
    points = [Point("stepping", name, changes[name], measured) for name, measured in found.items()]
    missing = [name for name in changes if name not in found]
    reason = "refused by the integrator, or beyond the budget"
    return points, [f"{name}: {reason}" for name in missing]


def _too_long(
    changes: Mapping[str, Changes], name: str, found: Mapping[str, Measured], most: float
) -> bool:
    """Whether the integrator took more than ``most`` nominal seconds at its last tolerance."""
    scheme = changes[name]["run.integrator"]
    looser = [one for key, one in found.items() if changes[key]["run.integrator"] == scheme]
    return bool(looser) and looser[-1].nominal > most


def _reach_and_model(short: Scene, budget: float) -> tuple[list[Point], list[str]]:
    """Every reach and model, against the last of each; what cannot be compared is left out."""
    points: list[Point] = []
    if short.chain.particles > LARGEST:
        return points, [f"reach and model: all pairs of more than {LARGEST} spheres take too long"]
    skipped = []
    for axis, settings in reach_and_model(short).items():
        scenes = {name: load_scene(short, **change) for name, change in settings.items()}
        full = simulate_quietly(list(scenes.values())[-1])
        if full.status != "completed":
            skipped.append(f"{axis}: its reference, {REFERENCES[axis]}, stops {full.reason}")
            continue
        found = measure_all(scenes, full, repeats=3, budget=0.15 * budget)
        points += [Point(axis, name, settings[name], m) for name, m in found.items()]
    return points, skipped
