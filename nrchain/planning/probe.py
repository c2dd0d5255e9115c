"""max |r − r′|/a of sets of effects from the full model, found by a short run of both.

The probe behind ``effects = "auto"``, see :mod:`nrchain.planning.auto`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from nrchain.effects.shared.slip_flow import reach_text
from nrchain.motion.pose_model import PoseModel
from nrchain.planning.choice import Choice, Forgone
from nrchain.planning.counted_work import evaluation_work
from nrchain.planning.flow_keys import finite_size_sections, flow_sections
from nrchain.planning.hydrodynamic_set import HydrodynamicSet
from nrchain.planning.shared_steps import SharedStepRun, largest_distance
from nrchain.scene.scene import Scene
from nrchain.types import Poses
from nrchain.watch.neglected import velocity_difference

MARGIN = 1.1
"""The bound over the distance that a probe finds. The bound has to be within the tolerance."""

SAMPLES = 17
"""Times at which sets are compared with the full model: so many evenly spaced, and so many early
ones."""

LOOSEST, CLOSE = 3e-3, 0.03
"""Tolerance of the steps of a probe: ``LOOSEST``, or ``CLOSE`` times the distance allowed if that
is less."""

FEWEST_SAMPLES = 4
"""Samples of a difference that a fit needs before it is extrapolated."""

FIRST = 1e-3
"""Part of the run after which sets are first compared with the full model."""

SETTLED, SURE = 0.1, 0.1
"""After ``SETTLED`` of the run, a set within ``SURE`` times the tolerance is good enough, and sets
that cost more are dropped."""


@dataclass
class Probe:
    """The full model and sets of its effects, by their cost, followed on shared steps.

    ``distances`` (in radii or radians) and ``velocities`` (in radii or radians per unit time) hold
    those of every member from the full model at the times ``reached``, as long as the member was
    followed. Member 0 is the full model.
    """

    tolerance: float
    full: Scene
    sets: list[HydrodynamicSet]
    run: SharedStepRun
    reached: list[float]
    distances: list[list[float]]
    velocities: list[list[float]]

    def compare(self) -> None:
        """Record the distance of every member that is left, at the time the run has reached."""
        run, models = self.run, self.run.models
        self.reached.append(run.time)
        for m in [m for m in run.members if m]:
            far = max(largest_distance(run.poses[m], run.poses[0], self.full.chain.radius))
            self.distances[m].append(far)
            self.velocities[m].append(_neglected(models, m, run.poses[m], self.full))

    def ended_early(self, member: int) -> bool:
        """Whether the probe ended before the run of this member and of the full model would."""
        going = member in self.run.members and 0 not in self.run.stops
        return going and self.reached[-1] < self.full.run.end

    def bound(self, member: int) -> float:
        """Distance from the full model to expect by the end, or by the last comparison."""
        found = max(self.distances[member])
        if self.ended_early(member):
            followed = np.array(self.reached), np.array(self.distances[member])
            found = max(found, extrapolate(*followed, self.full.run.end))
        return found * MARGIN

    def work(self, member: int) -> float:
        """Work of a right-hand side, over that of the full model."""
        return evaluation_work(self.full, self.sets[member - 1]) / evaluation_work(self.full)

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
                    "the cheapest set that stays within the tolerance in a probe",
                    work=self.work(m),
                )
        return self.full_model(
            f"every cheaper set is {self.tolerance:g} radii or radians off, or more,"
            f" by t = {probed:.3g}"
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
            self.ended_early(1),
            f"{stop.cause} at t = {stop.time:.3g}" if stop else "",
        )
        choice = Choice(self.tolerance, (), 0.0, self.reached[-1], (), (), reason, forgone=forgone)
        return self.full, choice


def run_probe(
    tolerance: float, full: Scene, sets: list[HydrodynamicSet], begin: Poses, budget: float
) -> Probe:
    """Integrate all sets with the full model, each as long as it stays near it.

    ``budget`` is in nominal seconds (:mod:`nrchain.planning.counted_work`).
    """
    members = [full, *(one.apply_to(full) for one in sets)]
    end = full.run.end
    even, early = np.linspace(0.0, end, SAMPLES)[1:], np.geomspace(FIRST * end, end, SAMPLES)[:-1]
    run = SharedStepRun(members, begin, min(LOOSEST, CLOSE * tolerance))
    velocities = [[_neglected(run.models, m, begin, full)] for m in range(len(members))]
    probe = Probe(tolerance, full, sets, run, [0.0], [[0.0] for _ in members], velocities)
    for time in run.advance(np.union1d(even, early), budget):
        probe.compare()
        far = probe.distances
        run.remove([m for m in run.members if m and far[m][-1] * MARGIN > tolerance])
        if time >= SETTLED * end:
            near = [m for m in run.members if m and max(far[m]) < SURE * tolerance]
            run.remove([m for m in run.members if near and m > near[0]])
    if run.time > probe.reached[-1] and 0 in run.members:
        probe.compare()
    return probe


def _neglected(models: list[PoseModel], member: int, poses: Poses, full: Scene) -> float:
    return velocity_difference(models[0], models[member], poses, full.chain.radius)


def _left_out(full: Scene, chosen: Scene) -> Iterator[str]:
    """In words, what the full model has and the chosen scene has not."""
    for name, section in flow_sections(full).items():
        reach = getattr(chosen, section).neighbours
        if reach != getattr(full, section).neighbours:
            yield f"{name} beyond {reach_text(reach)}"
    for name, section in finite_size_sections(full).items():
        if getattr(chosen, section).finite_size != getattr(full, section).finite_size:
            yield name
    if chosen.friction.kind != full.friction.kind:
        yield "friction between spheres"


def extrapolate(times: np.ndarray, values: np.ndarray, end: float) -> float:
    """The value at ``end`` of a difference D that was followed over ``times`` from 0.

    Over the second half of the times ln D is fitted by a line in t, D = e^{st}, and by one in ln t,
    D = t^p with p between 0 and 1 as for a drift. The better fit is taken. A difference that
    shrinks keeps its last value.
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
