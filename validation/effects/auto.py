"""Effects chosen for a tolerance: is it met, and how close is the time to the least possible?

Times are processor times on one thread.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.figure import Figure

from nrchain import Scene, Trajectory, auto, load_scene, simulate, work
from nrchain.accuracy.timing import distance
from nrchain.planning.choice import Choice, full_scene
from nrchain.planning.hydrodynamic_set import HydrodynamicSet
from validation.effects.scenes import completed, long_scene, random_scene
from validation.report.recorder import Recorder

AUTO_KEYS = (
    *("slip.neighbours", "slip.finite_size"),
    *("flow.neighbours", "flow.finite_size"),
    *("friction.kind", "friction.neighbours"),
)
"""The keys that ``effects = "auto"`` decides, and that a scene may not name beside it."""

SCENES, LONG_SCENES = 44, 4
QUICK_SCENES, QUICK_LONG = 3, 1
TOLERANCES = (0.003, 0.03, 0.3, 3.0)
REACHES = (1.0, 2.0, 4.0, 8.0, 16.0, math.inf)
REPEATS = 3
FACTOR = 2.0

WORST, WITH_CHOICE = 12.7, 4.8
"""Times over the least, as measured when near neighbours were compiled."""


@dataclass(frozen=True)
class Outcome:
    """One scene: the choice, its error in radii, and times in seconds.

    ``rival`` is the least time of all sets that meet the tolerance, ``full`` the time of the full
    model. ``work`` is the share of the full right-hand side that the choice states, for its own set
    or for the cheapest one, over the measured share; nan if it cannot be measured.
    """

    name: str
    tolerance: float
    error: float
    choice: Choice
    chosen: HydrodynamicSet
    best: HydrodynamicSet
    chosen_seconds: float
    choosing: float
    rival: float
    full: float
    work: float


def compare(recorder: Recorder) -> None:
    """Record errors and times of choices over all scenes and tolerances."""
    many, long = (QUICK_SCENES, QUICK_LONG) if recorder.quick else (SCENES, LONG_SCENES)
    scenes = [(f"random {seed}", random_scene(seed), TOLERANCES[seed % 4]) for seed in range(many)]
    scenes += [(f"long {seed}", long_scene(seed), 0.3) for seed in range(long)]
    found = []
    for number, (name, scene, tolerance) in enumerate(scenes):
        recorder.step(f"auto: scene {number + 1} of {len(scenes)}")
        found.append(_outcome(name, _left_to_choice(scene, tolerance)))
    _record(recorder, found)


def _left_to_choice(scene: Scene, tolerance: float) -> Scene:
    """The scene with ``effects = "auto"``, short enough for all models to complete."""
    scene = load_scene(scene, **dict.fromkeys(AUTO_KEYS))
    full = full_scene(scene)
    scene = load_scene(scene, **{"run.end": completed(full).run.end})
    return load_scene(scene, effects="auto", tolerance=tolerance)


def _outcome(name: str, scene: Scene) -> Outcome:
    assert scene.tolerance is not None
    choosing = math.inf
    for _ in range(REPEATS):
        began = clock.process_time()
        concrete, choice = auto.choose(scene)
        choosing = min(choosing, clock.process_time() - began)
    full = full_scene(scene)
    reference = simulate(full)
    sets = {fluid: fluid.apply_to(full) for fluid in _sets(full)}
    runs = {fluid: _timed(one) for fluid, one in sets.items()}
    chosen = HydrodynamicSet.of_scene(concrete)
    if chosen not in runs:
        sets[chosen], runs[chosen] = concrete, _timed(concrete)
    good = [f for f, (run, _) in runs.items() if _error(run, reference) <= scene.tolerance]
    quickest = sorted(good, key=lambda fluid: runs[fluid][1])[:3]
    tasks = {
        fluid: partial(_timed, sets[fluid]) for fluid in (*quickest, HydrodynamicSet.of_scene(full))
    }
    *others, own = _least([*tasks.values(), partial(_timed, concrete, choice)])
    times = dict(zip(tasks, others, strict=True))
    best = min(quickest, key=lambda fluid: times[fluid])
    return Outcome(
        name,
        scene.tolerance,
        _error(runs[chosen][0], reference),
        choice,
        chosen,
        best,
        own,
        choosing,
        times[best],
        times[HydrodynamicSet.of_scene(full)],
        _stated_work(choice, full, concrete),
    )


def _stated_work(choice: Choice, full: Scene, chosen: Scene) -> float:
    """Stated share of the work of a right-hand side, over the median of the measured shares."""
    stated, less = choice.work, chosen
    if choice.forgone:
        stated = choice.forgone.work
        if not (sets := auto.candidate_sets(full)):
            return math.nan
        less = sets[0].apply_to(full)
    shares = []
    for _ in range(REPEATS):
        costs = [work.cost_of(simulate(scene)) for scene in (less, full)]
        if min(cost.work.steps for cost in costs) < work.FEWEST_STEPS:
            return math.nan
        own, whole = (cost.seconds / cost.work.evaluations for cost in costs)
        shares.append(own / whole)
    return stated / float(np.median(shares))


def _sets(full: Scene) -> list[HydrodynamicSet]:
    """All combinations that the study tries."""
    whole, count = HydrodynamicSet.of_scene(full), full.chain.particles
    reaches = [r for r in REACHES if r < count - 1 or math.isinf(r)]
    sizes = sorted({whole.finite_size, False})
    flows = {
        (min(reach, whole.slip), min(reach, whole.strain), size)
        for reach in reaches
        for size in sizes
    }
    frictions = [0.0, *(r for r in reaches if r in (4.0, math.inf))]
    return [HydrodynamicSet(friction, *flow) for friction in frictions for flow in sorted(flows)]


def _timed(scene: Scene, choice: Choice | None = None) -> tuple[Trajectory, float]:
    began = clock.process_time()
    run = simulate(scene, choice=choice)
    return run, clock.process_time() - began


def _least(tasks: list[Callable[[], tuple[Trajectory, float]]]) -> list[float]:
    """The least time of each task; tasks take turns."""
    return np.min([[task()[1] for task in tasks] for _ in range(REPEATS)], axis=0).tolist()


def _error(run: Trajectory, reference: Trajectory) -> float:
    return max(distance(run, reference))


def _record(recorder: Recorder, found: list[Outcome]) -> None:
    _record_errors(recorder, found)
    _record_times(recorder, found)
    _record_work_and_bounds(recorder, found)
    _record_table(recorder, found)
    recorder.figure(
        "auto",
        _draw(found),
        "Left: error of the chosen effects over the tolerance. Right: time over that of the "
        "cheapest set that meets it, of the run alone (dots) and with the choice (circles).",
    )


def _record_errors(recorder: Recorder, found: list[Outcome]) -> None:
    met = [one.error <= one.tolerance for one in found]
    recorder.check(
        "scenes in which the chosen effects meet the tolerance",
        len(found),
        sum(met),
        0.0,
        relative=False,
        source="largest distance from the run of the full model over all snapshots",
    )


def _record_times(recorder: Recorder, found: list[Outcome]) -> None:
    """Time of the chosen effects over that of the cheapest set that meets the tolerance."""
    slower = [one.chosen_seconds / one.rival for one in found]
    recorder.bound(
        "time of the chosen effects over that of the cheapest set, nine scenes of ten",
        float(np.quantile(slower, 0.9)),
        most=FACTOR,
        source=f"{len(found)} scenes; all combinations, least of {REPEATS} times each",
    )
    if not recorder.quick:
        recorder.shortfall(
            "the same, worst",
            max(slower),
            asked=FACTOR,
            reached=WORST,
            source="where a bound is too wide, the full model runs with all pairs, which takes ten "
            "times as long as near neighbours in compiled code",
        )
    whole = [(one.chosen_seconds + one.choosing) / one.rival for one in found]
    if not recorder.quick:  # its few scenes are shorter than any probe
        recorder.shortfall(
            "the same, including the time of the choice, median",
            float(np.median(whole)),
            asked=FACTOR,
            reached=WITH_CHOICE,
            source="a probe evaluates the full model in Python, which takes several times as long "
            "as a compiled run of 10 ms",
        )


def _record_work_and_bounds(recorder: Recorder, found: list[Outcome]) -> None:
    """What a choice states, its share of the work and its bound, over what runs show."""
    stated = np.abs(np.log([one.work for one in found if math.isfinite(one.work)]))
    recorder.bound(
        "stated share of the work over the measured one, median factor",
        float(np.exp(np.median(stated))) if len(stated) else math.nan,
        most=1.3,
        source="processor time per right-hand side, over whole runs",
    )
    left = [one for one in found if one.choice.left_out]
    bounds = [one.error / one.choice.bound for one in left]
    recorder.bound(
        "error over the stated bound, worst",
        max(bounds, default=math.nan),
        most=1.25,
        source=f"{len(left)} scenes in which an effect is left out",
    )


def _record_table(recorder: Recorder, found: list[Outcome]) -> None:
    recorder.table(
        "Effects chosen for a tolerance",
        ["Scene", "Tolerance [a]", "Left out", "Bound", "Error", "Run [ms]", "Choice [ms]",
         "Cheapest [ms]", "Full [ms]", "Run / cheapest", "With choice / cheapest",
         "Work stated / measured"],
        [
            (
                one.name, one.tolerance, ", ".join(one.choice.left_out) or "nothing",
                one.choice.bound, one.error, 1e3 * one.chosen_seconds, 1e3 * one.choosing,
                1e3 * one.rival, 1e3 * one.full, one.chosen_seconds / one.rival,
                (one.chosen_seconds + one.choosing) / one.rival, one.work,
            )
            for one in found
        ],
        "Scenes with effects = \"auto\", against the full model and all combinations of reach, "
        "finite size and friction; the cheapest is the fastest that meets the tolerance.",
    )  # fmt: skip


def _draw(found: list[Outcome]) -> Figure:
    figure = Figure(figsize=(7.2, 3.2))
    left, right = figure.subplots(1, 2)
    number = np.arange(len(found))
    left.semilogy(number, [max(o.error / o.tolerance, 1e-6) for o in found], ".", color="0.2")
    left.axhline(1.0, ls=":", color="0.6")
    left.set(xlabel="scene", ylabel="error / tolerance")
    right.semilogy(number, [o.chosen_seconds / o.rival for o in found], ".", color="0.2")
    whole = [(o.chosen_seconds + o.choosing) / o.rival for o in found]
    right.semilogy(number, whole, "o", mfc="none", color="0.6")
    right.axhline(FACTOR, ls=":", color="0.6")
    right.set(xlabel="scene", ylabel="time / cheapest")
    return figure
