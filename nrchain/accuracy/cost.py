"""Error against work: what the accuracy of a scene costs, measured on the scene itself.

Accuracy is bought along three axes: the stepping (integrator and tolerances), the reach of the
flows, and the hydrodynamic model. :func:`work_precision` runs the scene, or as much of its
beginning as a budget of counted work allows, along all of them. Errors of the stepping are
distances from a reference far below all settings tried; those of reach and model are distances
from the same run with everything the package can simulate. What is run, its errors and its counts
are the same on every machine; the times are those of :mod:`nrchain.work`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from nrchain.accuracy.timing import (
    PILOT,
    SNAPSHOTS,
    Measured,
    foretell,
    measure_all,
    simulate_quietly,
)
from nrchain.errors import SceneError
from nrchain.planning.scene_changes import all_pairs, all_sizes, reach_keys
from nrchain.planning.start import starting_poses
from nrchain.run.work import CARRIED, DEFINITION, FEWEST_STEPS, RunCost, carried
from nrchain.scene.scene import Scene, load_scene
from nrchain.trajectory.trajectory import Trajectory
from nrchain.wording import brief, digits, span

Axis = Literal["stepping", "reach", "model"]
Changes = dict[str, Any]

BUDGET = 30.0
"""Nominal seconds (:mod:`nrchain.planning.nominal_cost`) that the short runs take together,
about."""

TOLERANCES = {
    "cvode": (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9),
    "radau": (1e-3, 1e-4, 1e-5, 1e-6, 1e-7),
    "scipy-bdf": (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8),
}
"""What is tried of each integrator: from some 1e-2 radii to some 1e-7."""

REFERENCE = "cvode", 1e-12
SECOND_OPINION = (("radau", 1e-9), ("cvode", 1e-10))
"""Whose distance from the reference is taken for its error; the second where the first cannot."""

PILOT_SHARE = PILOT / BUDGET
"""Part of the budget that one run at the scene's own setting may take."""

LIMITS = ("run.max_steps", "run.max_seconds")
"""Budgets that a scene may have of its own; the short runs are made without."""

MARGIN = 2.0
"""A setting is advised if its error is below the target by this factor: errors scatter."""

RESOLVED = 10.0
"""Errors are told from that of the reference if they are this many times as large."""

LONGEST_REACH = 64
LARGEST = 2000
"""Spheres up to which reach and model are compared with all pairs, whose cost grows as N²."""


@dataclass(frozen=True)
class Point:
    """A setting of an axis: the changes to the scene that make it, and what it gives."""

    axis: Axis
    setting: str
    changes: Changes
    measured: Measured

    __repr__ = brief


@dataclass(frozen=True)
class Advice:
    """The cheapest setting for a target, or the most accurate one if none is sure to reach it.

    ``error`` and ``seconds`` (least, most) of processor time are those of the whole run; where
    ``known`` is False, of the part that was run. ``seconds`` is None where steps are too few to
    tell. ``sure`` says in sentences how well they are known.
    """

    target: float
    point: Point
    reached: bool
    known: bool
    error: float
    seconds: tuple[float, float] | None
    sure: list[str]

    __repr__ = brief

    def lines(self) -> list[str]:
        """The advice in words: error, cost, and how sure both are."""
        time = "a time too short to tell"
        if self.seconds:
            time = span(*map(digits, self.seconds)) + " s"
        whole = "for the whole run" if self.known else "for the part that was run"
        return [f"global error {self.error:.1e}, in {time} of a processor {whole}", *self.sure]

    @property
    def arguments(self) -> str:
        """The setting as arguments of the command line."""
        return " ".join(f"--set {key}={value}" for key, value in self.point.changes.items())


@dataclass(frozen=True)
class WorkPrecision:
    """What was measured of a scene, up to t = ``reached``.

    ``reference_error`` is the distance of the second opinion from the reference, in radii and
    radians. ``own`` is what the scene costs as it is, the same number as of a run and of a plan.
    ``skipped`` says what was not tried, and why.
    """

    scene: Scene
    reached: float
    own: RunCost
    points: list[Point]
    reference: str
    reference_error: float
    skipped: list[str] = field(default_factory=list)

    __repr__ = brief

    @property
    def part(self) -> float:
        """How much of the run the short runs cover."""
        return self.reached / self.scene.run.end

    def whole_run(self, measured: Measured) -> tuple[float, float] | None:
        """Seconds (least, most) of processor time of the whole run; None where not known.

        The spread of the repetitions, carried on by :func:`nrchain.work.carried`.
        """
        factors = carried(self.part, measured.late)
        if factors is None or measured.work.steps < FEWEST_STEPS:
            return None
        least, most = factors
        return min(measured.seconds) * least, max(measured.seconds) * most

    def notes(self) -> list[str]:
        """What the numbers are, one line each: the part of the run, the references, the gaps."""
        lines = [
            "runs cover the whole run"
            if self.part == 1.0
            else f"runs cover t = 0 to {self.reached:.4g}, {self.part:.2g} of the whole run",
            f"the scene as it is: {self.own.words()}",
            f"seconds: {DEFINITION}",
            f"stepping: largest distance from {self.reference}, which an independent run meets to "
            f"{self.reference_error:.1e}",
            "reach, model: largest distance from the run with all that is listed, at the scene's "
            "own tolerances",
        ]
        if self.scene.run.max_steps is not None or self.scene.run.max_seconds is not None:
            lines.append(f"without {' and '.join(LIMITS)}, which would cut the runs short")
        return lines + [f"not measured: {reason}" for reason in self.skipped]

    def advise(self, target: float) -> Advice:
        """The cheapest stepping whose global error, in radii and radians, is sure to be below.

        Sure is a factor of :data:`MARGIN` on what was measured, which is taken to grow in
        proportion to time where the short runs end before the run does. Where they cover less
        than 1/:data:`nrchain.work.CARRIED` of it, nothing is carried on: the advice is for what
        they cover. Raises
        :class:`~nrchain.errors.SceneError` for a target that is not a number above 0.
        """
        check_target(target)
        known = self.part * CARRIED >= 1.0
        floor, share = RESOLVED * self.reference_error, self.part if known else 1.0
        stepping = [point for point in self.points if point.axis == "stepping"]
        errors = [max(point.measured.error, floor) / share for point in stepping]
        good = [k for k, error in enumerate(errors) if error * MARGIN <= target]
        if good:
            best = min(good, key=lambda k: stepping[k].measured.median)
        else:
            best = min(range(len(errors)), key=errors.__getitem__)
        point, error = stepping[best], errors[best]
        times = point.measured.seconds
        seconds = self.whole_run(point.measured) if known else (min(times), max(times))
        sure = list(self._sureness(point, error, target, known))
        return Advice(target, point, bool(good) and known, known, error, seconds, sure)

    def _sureness(self, point: Point, error: float, target: float, known: bool) -> Iterator[str]:
        if not known:
            yield (
                f"not sure for the whole run: {self.part:.2g} of it was run, nothing is "
                f"carried on to more than {CARRIED:g} times that, and beyond it neither error nor "
                "time is known; a larger --budget runs more of it"
            )
        if not error:
            yield "no two runs differ: the chain does not move"
        elif error * MARGIN <= target:
            yield f"the error is below the target by a factor of {target / error:.2g}"
        else:
            yield (
                f"no setting tried is sure to reach {target:.2g}: this one is the most accurate, "
                f"and a margin of {MARGIN:g} is asked for"
            )
        yield (
            f"errors are against {self.reference}, which agrees with an independent run to "
            f"{self.reference_error:.1e}"
        )
        seconds = point.measured.seconds
        if len(seconds) > 1:
            took = span(digits(min(seconds)), digits(max(seconds)))
            yield f"{len(seconds)} repetitions took {took} s"
        else:
            yield f"run once, in {digits(seconds[0])} s: the budget allowed no repetition"
        if self.part == 1.0:
            yield "measured over the whole run: nothing is extrapolated"
        elif known:
            yield (
                f"measured up to t = {self.reached:.4g}, {self.part:.2g} of the run; errors are "
                "taken to grow in proportion to time and the pace to stay: a chain that buckles, "
                "coils or takes off later will need more of both"
            )


def check_target(target: float) -> None:
    """Refuse an error that is not a number above 0."""
    if not (math.isfinite(target) and target > 0):
        raise SceneError("target", target, "must be a finite number of more than 0")


def work_precision(
    scene: Scene,
    *,
    budget: float = BUDGET,
    progress: Callable[[str], None] | None = None,
) -> WorkPrecision:
    """Measure error against work for a scene, by runs that take some ``budget`` nominal seconds.

    The short runs cover the whole run where it takes less than 1.5 % of the budget, and else
    as much of its beginning. Nominal seconds are counted, not timed: what is run does not depend on
    how busy the machine is. ``progress`` is told what is being measured. What a scene leaves to
    ``effects = "auto"`` is chosen first.

    Raises :class:`~nrchain.errors.SceneError` for a budget that is not a number above 0, and for
    a scene that is refused, or stops before the end of the short runs.
    """
    if not (math.isfinite(budget) and budget > 0):
        raise SceneError("budget", budget, "must be a finite number of seconds, more than 0")
    starting_poses(scene)
    tell = progress or (lambda what: None)
    if scene.effects == "auto":
        from nrchain.planning.auto import choose

        scene, _ = choose(scene)
    tell("how much of the run fits the budget")
    short, own = _shortened(scene, PILOT_SHARE * budget)
    tell("the reference")
    reference, name, error = _reference(short)
    tell("integrators and tolerances")
    points, skipped = _stepping(short, reference, budget)
    if scene.chain.particles > LARGEST:
        skipped.append(
            f"reach and model: all pairs of more than {LARGEST} spheres take too long to compare"
        )
    else:
        tell("reach of the flows, hydrodynamic model")
        for axis, settings in _levels(short).items():
            scenes = {name: load_scene(short, **change) for name, change in settings.items()}
            full = simulate_quietly(list(scenes.values())[-1])
            if full.status != "completed":
                skipped.append(f"{axis}: with {list(scenes)[-1]} the run stops {full.reason}")
                continue
            found = measure_all(scenes, full, repeats=3, budget=0.15 * budget)
            points += [Point(axis, name, settings[name], m) for name, m in found.items()]
    return WorkPrecision(scene, short.run.end, own, points, name, error, skipped)


def _shortened(scene: Scene, allowed: float) -> tuple[Scene, RunCost]:
    """The scene up to a time that it reaches in as much work as allowed, and what it costs."""
    found = foretell(scene, allowed, 9 if scene.chain.particles > LARGEST else SNAPSHOTS)
    if found.trajectory.status != "completed":
        allowed_end = f"the run stops {found.trajectory.reason}; name an end before that"
        raise SceneError("run.end", scene.run.end, allowed_end)
    return found.scene, found.cost


def _stepper(scene: Scene, integrator: str, tolerance: float) -> Scene:
    return load_scene(scene, **_stepping_changes(integrator, tolerance))


def _stepping_changes(integrator: str, tolerance: float) -> Changes:
    return {"run.integrator": integrator, "run.rtol": tolerance, "run.atol": tolerance}


def _reference(short: Scene) -> tuple[Trajectory, str, float]:
    """The reference, what it is, and how far an independent run is from it."""
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
        allowed = f"must be resolved at {loosest:g}, where an independent run is compared"
        raise SceneError("start.amplitude", short.start.amplitude, allowed)
    return reference, f"{scheme} at {tolerance:.0e}", found[""].error


def _stepping(short: Scene, reference: Trajectory, budget: float) -> tuple[list[Point], list[str]]:
    """All integrators at all tolerances, the loose ones first; costly ones are left out."""
    changes = {
        f"{scheme}, {tolerance:.0e}": _stepping_changes(scheme, tolerance)
        for scheme, tolerances in TOLERANCES.items()
        for tolerance in tolerances
    }

    def too_long(name: str, found: Mapping[str, Measured]) -> bool:
        return _too_long(changes, name, found, budget / 10.0)

    scenes = {name: load_scene(short, **change) for name, change in changes.items()}
    found = measure_all(scenes, reference, budget=0.6 * budget, skip=too_long)
    points = [Point("stepping", name, changes[name], measured) for name, measured in found.items()]
    missing = [name for name in changes if name not in found]
    reason = "not on offer for this chain, or beyond the budget"
    return points, [f"{name}: {reason}" for name in missing]


def _too_long(
    changes: Mapping[str, Changes], name: str, found: Mapping[str, Measured], most: float
) -> bool:
    """Whether the same integrator took more than ``most`` nominal seconds a tolerance before."""
    scheme = changes[name]["run.integrator"]
    looser = [one for key, one in found.items() if changes[key]["run.integrator"] == scheme]
    return bool(looser) and looser[-1].nominal > most


def _levels(short: Scene) -> dict[Axis, dict[str, Changes]]:
    """Reach and model by one change after another; the last of each has everything."""
    keys, every, reach = reach_keys(short), all_pairs(short), 1
    axes: dict[Axis, dict[str, Changes]] = {"reach": {}, "model": {"the scene itself": {}}}
    while keys and reach <= min(short.chain.particles - 2, LONGEST_REACH):
        axes["reach"][f"{reach} neighbour{'s' * (reach > 1)}"] = dict.fromkeys(keys, reach)
        reach *= 2
    if len(every) == len(keys):
        axes["reach"]["all pairs"] = every
    level: Changes = {}
    friction = {"friction": "pairwise"} if short.friction.kind == "one-body" else {}
    for name, further in (
        ("all pairs", every),
        ("… with finite size", all_sizes(short)),
        ("… and pairwise friction", friction),
    ):
        if load_scene(short, **level, **further) != load_scene(short, **level):
            level = level | further
            axes["model"][name] = level
    return {axis: settings for axis, settings in axes.items() if len(settings) > 1}
