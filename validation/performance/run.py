"""How fast is it, against today's practice and against itself, and what grows with N?

Everything is measured in one run on one machine: rivals take turns with what they are compared
with, numbers are medians, and runs are compared at equal measured error, each side at the loosest
tolerance that meets it. Sums over all pairs are timed with one thread a side, so that neither waits
for what else the machine does; what all threads make of it is recorded beside it. The bars are the
project's own, and those that are missed are stated as such. Today's practice is the recipe of
:mod:`validation.performance.recipe`: SciPy's BDF with a dense difference Jacobian, PyStokes for
every pair interaction, and a potential vectorised with NumPy.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from nrchain import Scene, Trajectory, load_scene
from nrchain.motion.charts import ChartedChain
from nrchain.motion.model import Model
from nrchain.scene.poses import initial_poses
from validation.performance import growth
from validation.performance.recipe import Recipe, Solution, solve_compiled, solve_recipe
from validation.performance.timing import (
    Timed,
    in_turns,
    loosest,
    ours,
    rates_of,
    reference,
    theirs,
)
from validation.report.recorder import Recorder
from validation.report.threads import one_thread

MODES = {"slip.2s": 100.0, "slip.3a": 5000.0, "slip.3t": 1000.0, "slip.4a": 10000.0}
ALL_PAIRS = {"slip.neighbours": "all"}
LONG_RANGE = {"slip.neighbours": "all", "friction": "pairwise"}
EQUAL_ERROR = 1e-4
"""Largest distance from the reference that compared runs may have, in sphere radii."""

AGREEMENT = 1e-10
PROJECT = "the project's bar"

NEAR_RECIPE, NEAR_COMPILED, FAR_RECIPE = 24.0, 3.6, 61.0
"""Times faster than rivals that are given care, as measured when the bars were given up."""


@dataclass(frozen=True)
class Missed:
    """A bar that is not met."""

    asked: float
    reached: float


def study(recorder: Recorder) -> None:
    recorder.step("pair sums against PyStokes")
    recorder.text(
        "PyStokes is compiled with -O1, as the README's line sets it up. On one thread its slip of "
        "2s and 4a and its friction take up to 5 % less time with -O3 (N = 400)."
    )
    _pair_sums(recorder)
    recorder.step("nearest neighbours at equal error")
    _nearest(recorder)
    recorder.step("long range at equal error")
    _long_range(recorder)
    recorder.text(
        "The recipe is run as it is written down, with SciPy's own difference Jacobian and the "
        "threads that every library takes by itself, and once more with care. Care is one thread "
        "(two that wait for each other are ten times slower in PyStokes when it is shown two "
        "spheres at a time, and much slower in SciPy's dense factorisation) and difference steps "
        "of one size (SciPy's own are lost in rounding where a coordinate is zero). SciPy's BDF "
        "then asks for few Jacobians, and most of its cost is that of 6N right-hand sides for "
        "each of them."
    )
    recorder.step("effects left out")
    _absent(recorder)
    recorder.step("spinning chains")
    growth.spiral(recorder)
    recorder.step("cost against N")
    growth.cost(recorder)
    recorder.step("memory")
    growth.memory(recorder)
    recorder.step("start-up")
    growth.start(recorder)


def curved(count: int, **changes: object) -> Scene:
    """A free chain on a sine of five radii: no pair of spheres is like another."""
    table = {
        "chain.particles": count,
        "elasticity.stretch": 200.0,
        "elasticity.shear": 200.0,
        "start.shape": "sine",
        "start.amplitude": 5.0,
        "run.end": 1.0,
    }
    return load_scene(table | changes)


def buckling(count: int, **changes: object) -> Scene:
    """2s at V = 100 and R = 1e12, free ends, from a random tenth of a radius to t = 400."""
    table = {
        "chain.particles": count,
        "elasticity.ratio": 1e12,
        "slip.2s": 100.0,
        "start.shape": "random",
        "run.end": 400.0,
        "run.snapshots": 11,
    }
    return load_scene(table, **changes)


def _pair_sums(recorder: Recorder) -> None:
    """One evaluation of what PyStokes has routines for, N = 1024, all pairs, at the same poses."""
    count = 1024
    rows: list[tuple[str, dict, float]] = [
        ("slip, four modes", MODES, 15.0),
        ("slip, 2s alone", {"slip.2s": 100.0}, 7.0),
        ("friction", {"slip.2s": 100.0, "friction": "pairwise"}, 5.0),
    ]
    for name, effects, bar in rows:
        scene = curved(count, **ALL_PAIRS, **effects)
        mine, rival = _pair_tasks(scene, friction=name == "friction")
        error = np.abs(mine() - rival()).max() / np.abs(mine()).max()
        recorder.check(
            f"{name}: largest difference from PyStokes, N = {count}",
            0.0,
            error,
            AGREEMENT,
            source="the same output is compared",
        )
        rounds = 5 if recorder.quick else 25
        with one_thread():
            alone = in_turns({"ours": mine, "theirs": rival}, rounds=rounds)
        shared = in_turns({"ours": mine, "theirs": rival}, rounds=rounds)
        for found, how in ((shared, "all threads"), (alone, "one thread")):
            our, their = (float(np.median(found[side])) for side in ("ours", "theirs"))
            pairs = count * (count - 1)
            what = (
                f"all pairs, N = {count}, {how}: {1e9 * our / pairs:.2f} ns a pair against "
                f"{1e9 * their / pairs:.1f} ns with PyStokes, tensors ready"
            )
            recorder.benchmark(f"all pairs, {name}, {how}", our, their, what=what)
        recorder.bound(
            f"all pairs, {name}: times PyStokes' speed", their / our, least=bar, source=PROJECT
        )


def _pair_tasks(scene: Scene, friction: bool) -> tuple[Callable, Callable]:
    """Ours and PyStokes', both returning (2, 3, N)."""
    positions, frames = initial_poses(scene)
    model, recipe = Model(scene), Recipe(scene, positions, frames)
    centres, turned = recipe.poses(recipe.start)
    forces, torques = recipe.elasticity.wrenches(centres, turned)
    tensors = recipe.slip.tensors(turned[:, 0])
    wrenches = np.concatenate([forces, torques]).T.copy()

    def mine() -> np.ndarray:
        twists = np.zeros((model.count, 6))
        if friction:
            assert model.friction
            model.friction.apply(positions, wrenches, twists)
        else:
            model.slip.add_twists(positions, frames, twists)
        return twists.T.reshape(2, 3, -1)

    def rival() -> np.ndarray:
        out = np.zeros((2, 3, model.count))
        if friction:
            assert recipe.friction
            recipe.friction.add(centres, forces, torques, out)
        else:
            recipe.slip.add(centres, tensors, out)
        return out

    return mine, rival


def _nearest(recorder: Recorder) -> None:
    """The buckling start, nearest neighbours, with the default integrator."""
    scene = buckling(64)
    true = reference(scene)
    mine = loosest(partial(_ours, scene, true), EQUAL_ERROR)
    where = "nearest neighbours, 2s, N = 64, R = 1e12, t = 400, random start"
    rivals = (
        ("the recipe", solve_recipe, Missed(250.0, NEAR_RECIPE)),
        (
            "SciPy's BDF with our compiled right-hand side",
            solve_compiled,
            Missed(60.0, NEAR_COMPILED),
        ),
    )
    for title, solve, missed in rivals:
        _compare(recorder, f"near run against {title}", where, scene, mine, true, solve, missed)


def _ours(scene: Scene, true: Trajectory, tolerance: float) -> Timed:
    return ours(scene, tolerance, true)


def _compiled(scene: Scene, true: Trajectory, tolerance: float) -> Timed:
    """SciPy's BDF with our right-hand side, which needs the tolerance that the recipe will need."""
    return theirs(partial(solve_compiled, careful=True), scene, tolerance, true)


def _long_range(recorder: Recorder) -> None:
    """All pairs and friction between them: against the recipe, and against nearest neighbours."""
    count = 32 if recorder.quick else 200
    near, far = buckling(count), buckling(count, **LONG_RANGE)
    true = reference(far)
    # all pairs take the integrator that is the fastest at this error, as `nrchain cost` would say
    choices = [load_scene(far, **{"run.integrator": name}) for name in ("cvode", "scipy-bdf")]
    found = [loosest(partial(_ours, scene, true), EQUAL_ERROR) for scene in choices]
    best = min(range(len(found)), key=lambda k: found[k].seconds)
    scene, mine = choices[best], found[best]
    where = f"all pairs, pairwise friction, 2s, N = {count}, R = 1e12, t = 400, random start, "
    where += f"by {scene.run.integrator}"
    name = "long-range run against the recipe"
    missed = Missed(200.0, FAR_RECIPE)
    _compare(recorder, name, where, scene, mine, true, solve_recipe, missed)

    turns = [(ours(near, 1e-6, true), ours(far, 1e-6, true)) for _ in range(5)]
    short, long = (float(np.median([pair[k].seconds for pair in turns])) for k in (0, 1))
    recorder.benchmark(
        "long-range run against nearest neighbours",
        long,
        short,
        what=f"both by cvode at a tolerance of 1e-6, N = {count}: {turns[0][1].evaluations} "
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
    missed: Missed,
) -> None:
    """A rival as it is written down, and one that is given care.

    The bar is for the first, whose threads wait for each other for more or less long: its time
    swings threefold from run to run, and a quick study leaves it out. What is held to is the
    second. Repetitions stand between ours; only a rival that is quick is run more than once.
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
        if run is careful and not recorder.quick:
            recorder.shortfall(
                f"{what}: times faster",
                their / our,
                asked=missed.asked,
                reached=missed.reached,
                source="the bar counts on a Jacobian every few steps; SciPy's BDF asks for "
                f"{other[0].jacobians} in this whole run, and takes {other[0].evaluations} "
                "right-hand sides with them",
            )


def _absent(recorder: Recorder) -> None:
    """What is not named costs nothing: right-hand sides with and without an effect."""
    rounds = 9 if recorder.quick else 41
    far = {**ALL_PAIRS, "slip.2s": 100.0}
    zeros = {label: 0.0 for label in MODES if label != "slip.2s"}
    shear = {"flow.gradient": [[0, 1e-3, 0], [0] * 3, [0] * 3]}
    cases: list[tuple[str, dict, dict]] = [
        ("3a, 3t and 4a beside 2s, all pairs", far, {**ALL_PAIRS, **MODES}),
        ("zero strengths of 3a, 3t, 4a, all pairs", far, {**far, **zeros}),
        ("finite size of 2s, all pairs", far, {**far, "slip.finite_size": True}),
        ("friction between spheres, all pairs", far, {**far, "friction": "pairwise"}),
        ("all pairs in place of neighbours", {"slip.2s": 100.0}, far),
        ("2s, neighbours", {}, {"slip.2s": 100.0}),
        ("twist, passive", {"elasticity.twist": 0.0}, {}),
        ("twist and bend, passive", {"elasticity.twist": 0.0, "elasticity.bend": 0.0}, {}),
        ("stretch and shear, passive", {"elasticity.stretch": 0.0, "elasticity.shear": 0.0}, {}),
        ("uniform force", {}, {"field.force": [0.0, 0.0, -1.0]}),
        ("shear flow and its disturbance, neighbours", {}, {**shear, "flow.neighbours": 1}),
        ("shear flow and its disturbance, all pairs", {}, shear),
    ]
    rows = []
    for name, less, more in cases:
        tasks = {"without": rates_of(curved(1024, **less)), "with": rates_of(curved(1024, **more))}
        with one_thread():
            found = in_turns(tasks, rounds=rounds)
        ratio = float(np.median(found["with"] / found["without"]))
        without, with_it = (float(np.median(found[key])) for key in ("without", "with"))
        rows.append((name, 1e6 * without, 1e6 * with_it, ratio))
        what = "one right-hand side of 1024 spheres, without and with the effect"
        recorder.benchmark(f"dropping: {name}", without, with_it, what=what)
    recorder.table(
        "Effects left out",
        ["Effect", "Without (μs)", "With (μs)", "With / without"],
        rows,
        "One right-hand side of a chain of 1024 spheres with and without an effect: medians of "
        f"{rounds} turns, one thread; the last column is the median of the ratios turn by turn.",
    )
    ratios = {row[0]: row[3] for row in rows}
    recorder.bound(
        "all-pairs right-hand side with four modes over that with 2s alone",
        ratios[cases[0][0]],
        least=1.6,
        source=PROJECT,
    )
    recorder.bound(
        "modes of zero strength over modes that are absent",
        ratios[cases[1][0]],
        most=1.02,
        source=PROJECT,
    )
    chain = ChartedChain(Model(curved(16, **cases[1][2])))
    recorder.check(
        "modes in the kernel of a scene with one mode and three of zero strength",
        1,
        len(chain.model.slip.labels),
        0.0,
        source="zero is as good as absent",
    )
