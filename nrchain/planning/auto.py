"""The cheapest set of effects whose neglected part is below a tolerance: ``effects = "auto"``.

The full model of a chain is what the package can simulate of its hydrodynamics: the slip flows of
all pairs and the disturbance of a background flow by all spheres, both with their finite size where
they have one, and friction between all of them, where the scene allows it. A scene with
``effects = "auto"`` and ``tolerance = x`` is run with as little of that as keeps every sphere, at
every snapshot, within x radii and x radians of the run of the full model. Elasticity, modes,
steric repulsion and all else that the scene names are kept as they are.

The error is that of poses and not of velocities, because poses are what a run is for, and because
a small error of a velocity that makes the chain unstable is a large one of its poses.

How it is chosen. Sets are the combinations of a reach of the flows, 1, 2, 4, … and all, with and
without friction between spheres and finite size; each has a counted cost
(:mod:`nrchain.planning.nominal_cost`), and of sets that cost about as much the fuller is kept,
beside the cheapest of all. They are integrated together with the full model on shared steps of
loose tolerance (:mod:`nrchain.planning.paired`); each is given up as soon as it strays from the
full model by x over :data:`MARGIN`. Of those that reach the end the cheapest is taken. Where no set
saves a third of the work of the full model, that is taken. Whenever it is, the choice holds what
the cheapest set would have saved, and its error.

A probe that would cost too much ends early: the distances are then carried on (:func:`carry_on`),
and the bound is an estimate beyond that time. In either case the run compares the velocities of its
set with those of the full model at every snapshot, and stops when they have come apart by more than
:data:`nrchain.planning.choice.BREACH` times what the probe found: a chain that coils brings distant
spheres near.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from nrchain.effects.shared.slip_flow import reach_text
from nrchain.errors import SceneError
from nrchain.motion.model import Model
from nrchain.planning.choice import Choice, Forgone, full_scene, missing_friction
from nrchain.planning.nominal_cost import Fluid, evaluation_cost
from nrchain.planning.paired import PairedRun, apart
from nrchain.planning.scene_changes import keys_that_differ, reaching, sized
from nrchain.planning.start import starting_poses
from nrchain.scene.scene import Scene
from nrchain.types import Poses
from nrchain.watch.neglected import velocity_difference

MARGIN = 1.1
"""The bound over the distance that a probe finds; it has to be within the tolerance."""

ALIKE = 1.5
"""Of two sets of which one holds the other, the fuller is tried alone if it costs no more."""

SAMPLES = 17
"""Times at which sets are compared with the full model, evenly spaced, and as many again early."""

LOOSEST, CLOSE = 3e-3, 0.03
"""Tolerance of the steps of a probe: this, or less as a part of the distance allowed."""

FEWEST_SAMPLES = 4
"""Samples that a difference must have been followed for before it is carried on by a fit."""

FIRST = 1e-3
"""Part of the run after which sets are first compared with the full model."""

SETTLED, SURE = 0.1, 0.1
"""After this part of the run a set this much nearer than allowed is followed alone: those that cost
more are given up."""

PROBE_BUDGET = 20.0
"""Nominal seconds that a probe may take."""

FIGURE_BUDGET = 0.3
"""Those of a probe that only tells how far a set strays which would save too little."""


def choose(
    scene: Scene, poses: Poses | None = None, *, budget: float = PROBE_BUDGET
) -> tuple[Scene, Choice]:
    """The scene with the effects chosen for its tolerance, named, and what they leave out.

    ``poses`` (N, 3) and (N, 3, 3) are those it starts from, if not its own.
    """
    if scene.effects != "auto" or scene.tolerance is None:
        raise SceneError("effects", scene.effects, "must be 'auto', with a tolerance")
    begin = starting_poses(scene, *(poses or (None, None)))
    chosen, choice = _chosen(scene.tolerance, full_scene(scene), begin, budget)
    if missing := missing_friction(scene):
        reason = f"{choice.reason}; friction between spheres is no part of it: {missing}"
        choice = replace(choice, reason=reason)
    sets = (f"{key} from {old!r} to {new!r}" for key, old, new in keys_that_differ(scene, chosen))
    return chosen, replace(choice, end=scene.run.end, sets=tuple(sets))


def _chosen(tolerance: float, full: Scene, begin: Poses, budget: float) -> tuple[Scene, Choice]:
    others = list(_subsets(full))
    if not others:
        reason = "there is nothing that could be left out"
        return full, Choice(tolerance, (), 0.0, 0.0, (), (), reason)
    if sets := ladder(full):
        return _tried(tolerance, full, sets, begin, budget).choice()
    cheapest = min(others, key=lambda one: evaluation_cost(full, one))
    probe = _tried(tolerance, full, [cheapest], begin, min(budget, FIGURE_BUDGET))
    return probe.full_model(f"every other set takes more than 1/{ALIKE:g} of its work")


def ladder(full: Scene) -> list[Fluid]:
    """The sets worth trying, by their cost: each costs clearly less than any fuller one kept.

    The cheapest of all is among them unless it costs about as much as the full model: what it
    leaves out may cancel, and a fuller set is not always nearer.
    """
    costs = {one: evaluation_cost(full, one) for one in sorted(_subsets(full), reverse=True)}
    whole = Fluid.of(full)
    kept = {whole: evaluation_cost(full)}
    for one, cost in costs.items():
        if all(ALIKE * cost < other for fuller, other in kept.items() if fuller.holds(one)):
            kept[one] = cost
    if len(kept) > 1:
        cheapest = min(costs, key=costs.__getitem__)
        kept[cheapest] = costs[cheapest]
    del kept[whole]
    return sorted(kept, key=kept.__getitem__)


def _subsets(full: Scene) -> set[Fluid]:
    """Sets with less than the full model, all flows cut at the same reach.

    Friction is that of all spheres or none: cut at a reach it need not be positive definite, and
    takes its products more steps than it saves.
    """
    whole, reaches = Fluid.of(full), [math.inf]
    places = 1
    while places < full.chain.particles - (full.chain.ends != "periodic"):
        reaches.append(places)
        places *= 2
    found = {
        Fluid(friction, min(reach, whole.slip), min(reach, whole.strain), size)
        for friction in (whole.friction, 0.0)
        for reach in reaches
        for size in (whole.finite_size, False)
    }
    return found - {whole}


@dataclass
class _Probe:
    """The full model and sets of its effects, by their cost, followed side by side.

    ``distances`` and ``velocities`` hold those of every member from the full model at the times
    ``reached``, as long as it was followed.
    """

    tolerance: float
    full: Scene
    sets: list[Fluid]
    run: PairedRun
    reached: list[float]
    distances: list[list[float]]
    velocities: list[list[float]]

    def compare(self) -> None:
        """Look at all members there are, at the time the run has reached."""
        run, models = self.run, self.run.models
        self.reached.append(run.time)
        for m in [m for m in run.members if m]:
            far = max(apart(run.poses[m], run.poses[0], self.full.chain.radius))
            self.distances[m].append(far)
            self.velocities[m].append(_neglected(models, m, run.poses[m], self.full))

    def is_open(self, member: int) -> bool:
        """Whether the probe has ended before the run of this member and of the full model does."""
        going = member in self.run.members and 0 not in self.run.stops
        return going and self.reached[-1] < self.full.run.end

    def bound(self, member: int) -> float:
        """Distance from the full model to be expected by the end, or by the last look at it."""
        found = max(self.distances[member])
        if self.is_open(member):
            followed = np.array(self.reached), np.array(self.distances[member])
            found = max(found, carry_on(*followed, self.full.run.end))
        return found * MARGIN

    def work(self, member: int) -> float:
        """Of a right-hand side, over that of the full model."""
        return evaluation_cost(self.full, self.sets[member - 1]) / evaluation_cost(self.full)

    def choice(self) -> tuple[Scene, Choice]:
        """The cheapest set that stays within the tolerance, or the full model."""
        probed = self.reached[-1]
        if probed == 0.0:
            return self.full_model("a probe of what could be left out takes too long")
        for m in sorted(m for m in self.run.members if m):
            if (bound := self.bound(m)) <= self.tolerance:
                chosen = self.run.scenes[m]
                return chosen, Choice(
                    self.tolerance,
                    tuple(_left_out(self.full, chosen)),
                    bound,
                    probed,
                    tuple(self.reached),
                    tuple(self.velocities[m]),
                    "the cheapest set that a probe beside the full model allows",
                    work=self.work(m),
                )
        return self.full_model(
            f"every cheaper set strays from it by {self.tolerance:g} by t = {probed:.3g}"
        )

    def full_model(self, reason: str) -> tuple[Scene, Choice]:
        """The full model, and what the cheapest set would have saved."""
        followed = len(self.distances[1])
        stop = self.run.stops.get(1)
        forgone = Forgone(
            tuple(_left_out(self.full, self.run.scenes[1])),
            self.work(1),
            self.bound(1) if followed > 1 else None,
            self.reached[followed - 1],
            self.is_open(1),
            f"{stop.cause} at t = {stop.time:.3g}" if stop else "",
        )
        choice = Choice(self.tolerance, (), 0.0, self.reached[-1], (), (), reason, forgone=forgone)
        return self.full, choice


def _tried(tolerance: float, full: Scene, sets: list[Fluid], begin: Poses, budget: float) -> _Probe:
    """Integrate all sets beside the full model, as long as they stay near it."""
    members = [full, *(one.applied(full) for one in sets)]
    end = full.run.end
    even, early = np.linspace(0.0, end, SAMPLES)[1:], np.geomspace(FIRST * end, end, SAMPLES)[:-1]
    run = PairedRun(members, begin, min(LOOSEST, CLOSE * tolerance))
    velocities = [[_neglected(run.models, m, begin, full)] for m in range(len(members))]
    probe = _Probe(tolerance, full, sets, run, [0.0], [[0.0] for _ in members], velocities)
    for time in run.go(np.union1d(even, early), budget):
        probe.compare()
        far = probe.distances
        run.drop([m for m in run.members if m and far[m][-1] * MARGIN > tolerance])
        if time >= SETTLED * end:
            near = [m for m in run.members if m and max(far[m]) < SURE * tolerance]
            run.drop([m for m in run.members if near and m > near[0]])
    if run.time > probe.reached[-1] and 0 in run.members:
        probe.compare()
    return probe


def _neglected(models: list[Model], member: int, poses: Poses, full: Scene) -> float:
    return velocity_difference(models[0], models[member], poses, full.chain.radius)


def _left_out(full: Scene, chosen: Scene) -> Iterator[str]:
    for name, section in reaching(full).items():
        reach = getattr(chosen, section).neighbours
        if reach != getattr(full, section).neighbours:
            yield f"{name} beyond {reach_text(reach)}"
    for name, section in sized(full).items():
        if getattr(chosen, section).finite_size != getattr(full, section).finite_size:
            yield name
    if chosen.friction.kind != full.friction.kind:
        yield "friction between spheres"


def carry_on(times: np.ndarray, values: np.ndarray, end: float) -> float:
    """A difference followed over ``times`` from 0, carried on to ``end``.

    Over the second half of what was followed, ln D is fitted by a line in t and by one in ln t. The
    better one is followed: e^{st}, or t^p with p between 0 and 1, as of a drift. Differences that
    shrink are kept as they are.
    """
    late = (times >= 0.5 * times[-1]) & (values > 0.0)
    last = float(values[-1])
    if np.count_nonzero(late) < FEWEST_SAMPLES or last <= 0.0:
        return last * end / float(times[-1]) if times[-1] > 0.0 else last
    logarithm = np.log(values[late])
    fits = {}
    for name, x in (("exponential", times[late]), ("power", np.log(times[late]))):
        slope, shift = np.polyfit(x, logarithm, 1)
        fits[name] = float(slope), float(np.square(logarithm - slope * x - shift).sum())
    (rate, rough), (power, rougher) = fits["exponential"], fits["power"]
    if rate <= 0.0:
        return last
    if rough < rougher and rate * times[-1] > 2.0:
        return last * math.exp(min(rate * (end - float(times[-1])), 700.0))
    return last * (end / float(times[-1])) ** min(max(power, 0.0), 1.0)
