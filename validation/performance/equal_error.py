"""Runs against the recipe, each side at the loosest tolerance that meets the same error."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from nrchain import Scene, Trajectory, load_scene
from validation.performance.recipe import Solution, solve_compiled, solve_recipe
from validation.performance.scenes import LONG_RANGE, PROJECT, buckling
from validation.performance.timing import Timed, loosest, ours, reference, theirs
from validation.report.recorder import Recorder
from validation.report.threads import one_thread

EQUAL_ERROR = 1e-4
"""Largest distance from the reference that compared runs may have, in sphere radii."""


NEAR_RECIPE, NEAR_COMPILED = 40.0, 9.0
"""Least speed over that of careful rivals: two thirds of what was measured. The targets, 250 times
that of the plain recipe and 12 times that of SciPy's BDF, are met."""

FAR_RECIPE = 120.0
"""Speed over that of a careful rival, as measured when the target of 200 was given up."""


QUICKEST = 1e-3
"""Loosest tolerance of the near run: with looser ones, the check of a start whose bend is hardly
larger than the tolerance takes longer than all steps."""


@dataclass(frozen=True)
class Missed:
    """A target that is not met."""

    asked: float
    reached: float


def near(recorder: Recorder) -> None:
    """The buckling start, nearest neighbours, with the integrator that is the fastest there."""
    scene = buckling(64, **{"run.integrator": "radau"})
    true = reference(scene)
    mine = loosest(partial(_ours, scene, true), EQUAL_ERROR, QUICKEST)
    where = "nearest neighbours, 2s, N = 64, R = 1e12, t = 400, random start, by radau"
    rivals = (
        ("the recipe", solve_recipe, NEAR_RECIPE),
        ("SciPy's BDF with our compiled right-hand side", solve_compiled, NEAR_COMPILED),
    )
    for title, solve, least in rivals:
        _compare(recorder, f"near run against {title}", where, scene, mine, true, solve, least)


def _ours(scene: Scene, true: Trajectory, tolerance: float) -> Timed:
    return ours(scene, tolerance, true)


def _compiled(scene: Scene, true: Trajectory, tolerance: float) -> Timed:
    """SciPy's BDF with our right-hand side; it needs the same tolerance as the recipe."""
    return theirs(partial(solve_compiled, careful=True), scene, tolerance, true)


def far(recorder: Recorder) -> None:
    """All pairs and friction between them: against the recipe, and against nearest neighbours."""
    count = 32 if recorder.quick else 200
    cvode = {"run.integrator": "cvode"}
    near, far = buckling(count, **cvode), buckling(count, **cvode, **LONG_RANGE)
    true = reference(far)
    # all pairs use the integrator that is the fastest at this error, as `nrchain cost` advises
    choices = [load_scene(far, **{"run.integrator": name}) for name in ("cvode", "scipy-bdf")]
    found = [loosest(partial(_ours, scene, true), EQUAL_ERROR) for scene in choices]
    best = min(range(len(found)), key=lambda k: found[k].seconds)
    scene, mine = choices[best], found[best]
    where = f"all pairs, pairwise friction, 2s, N = {count}, R = 1e12, t = 400, random start, "
    where += f"by {scene.run.integrator}"
    name = "long-range run against the recipe"
    missed = Missed(200.0, FAR_RECIPE)
    _compare(recorder, name, where, scene, mine, true, solve_recipe, missed)

    turns = [(ours(near, 2e-5, true), ours(far, 2e-5, true)) for _ in range(5)]
    short, long = (float(np.median([pair[k].seconds for pair in turns])) for k in (0, 1))
    recorder.benchmark(
        "long-range run against nearest neighbours",
        long,
        short,
        what=f"both by cvode at a tolerance of 2e-5, N = {count}: {turns[0][1].evaluations} "
        f"right-hand sides against {turns[0][0].evaluations}; a ratio below 1 is what the long "
        "range costs",
    )
    recorder.bound(
        f"long-range run over the nearest-neighbour run, N = {count}",
        long / short,
        most=12.0,
        source=PROJECT,
    )


def _compare(
    recorder: Recorder,
    name: str,
    where: str,
    scene: Scene,
    mine: Timed,
    true: Trajectory,
    solve: Callable[..., Solution],
    target: float | Missed,
) -> None:
    """Compare with a plain rival and with a careful one, whose speed the check uses.

    The threads of the plain rival wait for each other, and its time varies threefold between runs;
    a quick study leaves it out. Repetitions take turns with ours; a slow rival runs only once.
    ``target`` is the least speed over that of the careful rival, or a target that is not met.
    """

    def rival(tolerance: float) -> Timed:
        return theirs(solve, scene, tolerance, true)

    def careful(tolerance: float) -> Timed:
        with one_thread():
            return theirs(partial(solve, careful=True), scene, tolerance, true)

    with one_thread():
        guide = loosest(partial(_compiled, scene, true), EQUAL_ERROR).tolerance
    rivals = ((name, rival), (f"{name}, with care", careful))
    for what, run in rivals[1:] if recorder.quick else rivals:
        other = [loosest(run, EQUAL_ERROR, guide)]
        again = [ours(scene, mine.tolerance, true) for _ in range(5)]
        if other[0].seconds < 10.0 and not recorder.quick:
            other += [run(other[0].tolerance) for _ in range(4)]
        again += [ours(scene, mine.tolerance, true) for _ in range(5)]
        our, their = (float(np.median([r.seconds for r in runs])) for runs in (again, other))
        recorder.benchmark(
            what,
            our,
            their,
            what=f"{where}; error {mine.error:.1e} a at tolerance {mine.tolerance:.0e} in "
            f"{mine.evaluations} right-hand sides, against {other[0].error:.1e} a at "
            f"{other[0].tolerance:.0e} in {other[0].evaluations}",
        )
        if run is not careful or recorder.quick:
            continue
        if not isinstance(target, Missed):
            recorder.bound(f"{what}: times faster", their / our, least=target, source=PROJECT)
        else:
            recorder.shortfall(
                f"{what}: times faster",
                their / our,
                asked=target.asked,
                reached=target.reached,
                source="the target assumes a Jacobian every few steps; SciPy's BDF asks for "
                f"{other[0].jacobians} in this whole run, and takes {other[0].evaluations} "
                "right-hand sides with them",
            )
