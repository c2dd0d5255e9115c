"""The cheapest set of effects whose error stays within a tolerance: ``effects = "auto"``.

The full model of a chain holds all hydrodynamics that the package can simulate: the slip flows of
all pairs and the disturbance of a background flow by all spheres, both with their finite size, and
friction between all spheres, where the scene allows it. A scene with ``effects = "auto"`` and
``tolerance = x`` runs with as little of that as keeps every sphere, at every snapshot, within x
radii and x radians of the run of the full model. Elasticity, modes, steric repulsion and all else
that the scene names stay as they are.

The error is one of poses and not of velocities: poses are what a run is for, and a small error of a
velocity may make a chain unstable, which is a large error of its poses.

How it is chosen. Candidate sets combine a reach of the flows, 1, 2, 4, … neighbours or all pairs,
with or without friction between spheres and finite size. Each has a counted cost
(:mod:`nrchain.planning.counted_work`). Of sets that cost about the same the fuller one stays, and
the cheapest of all stays too. A probe (:mod:`nrchain.planning.probe`) integrates them together with
the full model on shared steps of loose tolerance, and drops a set as soon as it is off the
full model by x/:data:`MARGIN`. Of those that reach the end the cheapest is taken. If no set saves a
third of the work of the full model, the full model is taken. Whenever it is, the choice records
what the cheapest set would have saved, and its error.

A probe that would cost too much ends early. The distances are then extrapolated
(:func:`~nrchain.planning.probe.extrapolate`), and the bound is an estimate beyond that time. In
either case the run compares the velocities of its set with those of the full model at snapshots,
and stops when they differ by more than :data:`nrchain.planning.choice.BREACH` times what the probe
found: a chain that coils brings distant spheres near.
"""

from __future__ import annotations

import math
from dataclasses import replace

from nrchain.errors import SceneError
from nrchain.planning.checked_start import starting_poses
from nrchain.planning.choice import Choice, full_scene, missing_friction
from nrchain.planning.counted_work import evaluation_work
from nrchain.planning.flow_keys import differing_keys
from nrchain.planning.hydrodynamic_set import HydrodynamicSet
from nrchain.planning.probe import run_probe
from nrchain.scene.scene import Scene
from nrchain.types import Poses

ALIKE = 1.5
"""If one set contains another, only the fuller is tried, unless its cost exceeds this ratio."""

PROBE_BUDGET = 20.0
"""Nominal seconds that a probe may take."""

ERROR_BUDGET = 0.3
"""Nominal seconds for a probe that only finds the error of a set that saves too little."""


def choose(
    scene: Scene, poses: Poses | None = None, *, budget: float = PROBE_BUDGET
) -> tuple[Scene, Choice]:
    """The scene with the effects chosen for its tolerance, named, and what they leave out.

    ``poses`` (N, 3) and (N, 3, 3) replace the start of the scene. ``budget`` is the largest work of
    the probe, in nominal seconds (:mod:`nrchain.planning.counted_work`).

    Raises :class:`~nrchain.errors.SceneError` for a scene without ``effects = "auto"``, and for a
    start that a run would refuse.
    """
    if scene.effects != "auto" or scene.tolerance is None:
        raise SceneError("effects", scene.effects, "must be 'auto', with a tolerance")
    begin = starting_poses(scene, *(poses or (None, None)))
    chosen, choice = _chosen(scene.tolerance, full_scene(scene), begin, budget)
    if missing := missing_friction(scene):
        reason = f"{choice.reason}; friction between spheres is no part of it: {missing}"
        choice = replace(choice, reason=reason)
    sets = (f"{key} from {old!r} to {new!r}" for key, old, new in differing_keys(scene, chosen))
    return chosen, replace(choice, end=scene.run.end, sets=tuple(sets))


def choose_again(scene: Scene, choice: Choice) -> tuple[Scene, Choice]:
    """What the choice of a run would be with the end that its scene has now.

    ``scene`` has the effects that were chosen. Returns the scene with those that its present end
    asks for, and their choice.
    """
    chosen, again = _chosen(
        choice.tolerance, full_scene(scene), starting_poses(scene), PROBE_BUDGET
    )
    return chosen, replace(again, end=scene.run.end, sets=choice.sets)


def _chosen(tolerance: float, full: Scene, begin: Poses, budget: float) -> tuple[Scene, Choice]:
    others = list(_subsets(full))
    if not others:
        reason = "there is nothing that could be left out"
        return full, Choice(tolerance, (), 0.0, 0.0, (), (), reason)
    if sets := candidate_sets(full):
        return run_probe(tolerance, full, sets, begin, budget).choice()
    cheapest = min(others, key=lambda one: evaluation_work(full, one))
    probe = run_probe(tolerance, full, [cheapest], begin, min(budget, ERROR_BUDGET))
    return probe.full_model(f"every other set takes more than 1/{ALIKE:g} of its work")


def candidate_sets(full: Scene) -> list[HydrodynamicSet]:
    """The sets worth trying, cheapest first: each costs clearly less than any fuller one.

    The cheapest of all is among them unless it costs about as much as the full model: the effects
    it leaves out may cancel, and a fuller set is not always nearer to the full model.
    """
    costs = {one: evaluation_work(full, one) for one in sorted(_subsets(full), reverse=True)}
    whole = HydrodynamicSet.of_scene(full)
    kept = {whole: evaluation_work(full)}
    for one, cost in costs.items():
        if all(ALIKE * cost < other for fuller, other in kept.items() if fuller.contains(one)):
            kept[one] = cost
    if len(kept) > 1:
        cheapest = min(costs, key=costs.__getitem__)
        kept[cheapest] = costs[cheapest]
    del kept[whole]
    return sorted(kept, key=kept.__getitem__)


def _subsets(full: Scene) -> set[HydrodynamicSet]:
    """Sets with less than the full model. All flows of a set have the same reach.

    Friction acts between all spheres or none: cut at a reach it need not be positive definite, and
    costs more steps than it saves.
    """
    whole, reaches = HydrodynamicSet.of_scene(full), [math.inf]
    places = 1
    while places < full.chain.particles - (full.chain.ends != "periodic"):
        reaches.append(places)
        places *= 2
    found = {
        HydrodynamicSet(friction, min(reach, whole.slip), min(reach, whole.strain), size)
        for friction in (whole.friction, 0.0)
        for reach in reaches
        for size in (whole.finite_size, False)
    }
    return found - {whole}
