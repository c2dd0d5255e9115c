"""Leading-order pair laws → finite size → friction between spheres → the resolved spheres.

:class:`nrchain.hydrodynamics.resolved.ResolvedSpheres` solves the exterior Stokes problem with the
printed slips, whose far fields are the pair laws, to convergence. Held against it are the levels of
the simulation, in three settings:

- two spheres, one of which has slip: what a pair law leaves out, the response of the other;
- five on an arc, all with the slip of one mode: besides, the recoil. The flow of a sphere induces
  a stresslet in its neighbour, which acts back at (a/r)³ relative to the law itself, and whatever
  is more exact in the pair law alone cannot help beyond that;
- the same five without slip, driven by the forces and torques of their bent chain: friction, each
  sphere by itself or between all of them.

Errors are the largest error of a velocity over the largest velocity.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from functools import cache
from statistics import median

import numpy as np
from numpy.typing import NDArray

from nrchain import elastic_wrenches, load_scene
from nrchain.hydrodynamics.resolved import ResolvedSpheres
from nrchain.motion.model import Model
from nrchain.scene.poses import frames_along
from validation.cost import figures
from validation.cost.results import Case, Priced
from validation.report.recorder import Recorder
from validation.report.uniform_chains import STRENGTHS

Array = NDArray[np.float64]

BEND = 0.1
"""Turn of the arc from link to link, in radians."""
LEVELS: dict[str, dict[str, object]] = {
    "leading order": {},
    "finite size": {"slip.finite_size": True},
    "pairwise friction": {"friction": "pairwise"},
    "both": {"slip.finite_size": True, "friction": "pairwise"},
}
STIFFNESS = {"stretch": 20.0, "shear": 20.0, "twist": 1885.0, "bend": 1885.0}
"""The moduli of the buckling scene."""
SHORTER = 0.9
"""Rest spacing of that chain over the distance of its spheres."""
RECOIL = "response of the neighbours' induced stresslet"
SOURCE = "resolved spheres: exterior Stokes problem solved to convergence"


def compare(recorder: Recorder) -> None:
    """Record errors against distance, their orders, and what each level costs."""
    far = (6.0, 10.0, 16.0) if recorder.quick else (3.0, 4.0, 6.0, 8.0, 10.0, 14.0, 20.0, 28.0)
    recorder.step("model: two spheres")
    pairs = {label: [pair_errors(label, d) for d in far] for label in STRENGTHS}
    recorder.step("model: five spheres")
    distances = (
        (3.0, 10.0, 20.0, 40.0) if recorder.quick else (3.0, 4.0, 6.0, 10.0, 14.0, 20.0, 40.0)
    )
    chains = {label: [chain_errors(label, d) for d in distances] for label in STRENGTHS}
    driven = [driven_errors(d) for d in distances]
    _orders(recorder, pairs, driven)
    _recoil(recorder, chains["2s"])
    recorder.step("model: cost")
    priced = _prices(recorder)
    recorder.bound(
        "2s with the elastic forces of the buckling scene, d = 10a: error with pairwise friction",
        next(p.error for p in priced if p.level == "pairwise friction"),
        most=0.01,
        source=SOURCE,
    )
    _table(recorder, pairs, chains, driven)
    recorder.table(
        "What a level of the model costs",
        ["Level", "Error at d = 10a", "Seconds, five spheres"],
        [(p.level, p.error, p.seconds) for p in priced],
        "Velocities of five spheres on an arc with slip in mode 2s and elastic forces: "
        "error against the resolved spheres at a higher order, and median time of one evaluation.",
    )
    recorder.figure(
        "Hydrodynamic model",
        figures.model(pairs, chains, driven, priced),
        "True relative error of velocities. (a) Two spheres, one with slip. (b) Five on an arc, "
        "all with slip. Solid: leading order; dashed: finite size, where it differs. (c) Five on "
        "an arc, driven by forces and torques. (d) Error at d = 10a of all this together against "
        "the time of one evaluation; ring: the default.",
    )


def pair_errors(label: str, distance: float) -> Case:
    """The velocity of a force-free sphere beside one with slip, seen at an oblique angle."""
    positions = arc(distance, 2)[0]
    axis = np.array([1.0, 0.5, 0.3])
    frames = frames_along(np.stack([axis / np.linalg.norm(axis), [1.0, 0.0, 0.0]]))
    slip = {label: np.array([STRENGTHS[label], 0.0])}
    exact = _resolved(2, distance).mobility_problem(frames, slip).velocities[1]
    errors = {}
    for level in ("leading order", "finite size"):
        model = _model(2, {label: (STRENGTHS[label], 0.0)}, level)
        velocity = model.twists(positions, frames)[1, :3]
        errors[level] = float(np.linalg.norm(velocity - exact) / np.linalg.norm(exact))
    return Case(distance, errors)


def chain_errors(label: str, distance: float) -> Case:
    """Five spheres on an arc with the slip of a mode."""
    positions, frames = arc(distance)
    exact = _resolved(5, distance).mobility_problem(frames, {label: STRENGTHS[label]}).velocities
    return Case(
        distance,
        {
            level: _error(
                _model(5, {label: STRENGTHS[label]}, level).twists(positions, frames), exact
            )
            for level in ("leading order", "finite size")
        },
    )


def driven_errors(distance: float) -> Case:
    """Five spheres on an arc, driven by the wrenches of a chain with shorter rest lengths."""
    positions, frames = arc(distance)
    wrenches = _elastic(positions, frames)
    exact = _resolved(5, distance).mobility_problem(frames, {}, wrenches=wrenches).velocities
    moduli = {f"elasticity.{name}": value for name, value in STIFFNESS.items()}
    errors = {}
    for name, level in (("each by itself", "leading order"), ("pairwise", "pairwise friction")):
        model = _model(5, {}, level, moduli | {"chain.spacing": SHORTER * distance})
        errors[name] = _error(model.twists(positions, frames), exact)
    return Case(distance, errors)


def arc(distance: float, count: int = 5) -> tuple[Array, Array]:
    """Spheres on an arc, neighbours ``distance`` apart, with frames along its tangents."""
    turns = BEND * (np.arange(count) - (count - 1) / 2)
    links = BEND * (np.arange(count - 1) - (count - 2) / 2)
    positions = np.zeros((count, 3))
    positions[1:, :2] = np.cumsum(distance * np.stack([np.cos(links), np.sin(links)], 1), axis=0)
    return positions, frames_along(np.stack([np.cos(turns), np.sin(turns), 0 * turns], axis=1))


def _elastic(positions: Array, frames: Array) -> tuple[Array, Array]:
    """Forces and torques of a chain stretched beyond its rest lengths."""
    spacing = SHORTER * float(np.linalg.norm(positions[1] - positions[0]))
    stretch, shear, twist, bend = STIFFNESS.values()
    return elastic_wrenches(
        positions, frames, spacing=spacing, stretch=stretch, shear=shear, twist=twist, bend=bend
    )


@cache
def _resolved(count: int, distance: float) -> ResolvedSpheres:
    """Of order L with e^{−2αL}, cosh α = d/2a, below 1e-9, or as close as L = 11 comes to it."""
    order = math.ceil(math.log(1e9) / (2 * math.acosh(distance / 2)))
    return ResolvedSpheres(arc(distance, count)[0], order=min(max(order, 6), 11))


def _model(
    count: int,
    slip: Mapping[str, float | tuple[float, ...]],
    level: str,
    changes: Mapping[str, object] | None = None,
) -> Model:
    limp = {f"elasticity.{name}": 0.0 for name in STIFFNESS}
    table: dict[str, object] = {
        "chain.particles": count,
        "run.end": 1.0,
        "slip.neighbours": "all",
        **{f"slip.{label}": strength for label, strength in slip.items()},
    }
    return Model(load_scene(table | limp | dict(changes or {}) | LEVELS[level]))


def _error(twists: Array, exact: Array) -> float:
    off = np.linalg.norm(twists[:, :3] - exact, axis=1)
    return float(off.max() / np.linalg.norm(exact, axis=1).max())


def _slope(cases: list[Case], level: str, beyond: float) -> float:
    """Power of a/d of the error, from the distances beyond."""
    far = [case for case in cases if case.distance >= beyond]
    logs = np.log([[case.distance, case.errors[level]] for case in far])
    return float(-np.polyfit(logs[:, 0], logs[:, 1], 1)[0])


def _orders(recorder: Recorder, pairs: Mapping[str, list[Case]], driven: list[Case]) -> None:
    for label, level, power in (
        ("2s", "leading order", 2),
        ("2s", "finite size", 6),
        ("3t", "leading order", 6),
        ("3a", "leading order", 8),
        ("4a", "leading order", 8),
    ):
        recorder.check(
            f"two spheres, one with slip {label}, {level}: error ∝ (a/d)^",
            power,
            _slope(pairs[label], level, 6.0),
            0.4,
            source=SOURCE,
            relative=False,
        )
    for name, power in (("each by itself", 1), ("pairwise", 4)):
        recorder.check(
            f"five driven spheres, friction {name}: error ∝ (a/d)^",
            power,
            _slope(driven, name, 20.0),
            0.3,
            source=SOURCE,
            relative=False,
        )


def _recoil(recorder: Recorder, cases: list[Case]) -> None:
    """Finite size alone makes a chain of active spheres worse at close range."""
    by_distance = {case.distance: case.errors for case in cases}
    for distance, least, most in ((3.0, 1.1, 2.0), (10.0, 1.5, 3.0), (20.0, 0.6, 1.0)):
        errors = by_distance[distance]
        ratio = errors["finite size"] / errors["leading order"]
        name = f"five spheres, all with 2s, d = {distance:g}a: error of finite size over leading"
        recorder.bound(f"{name}, at least", ratio, least=least, source=RECOIL)
        recorder.bound(f"{name}, at most", ratio, most=most, source=RECOIL)
    text = "; ".join(
        f"d = {d:g}a: {by_distance[d]['leading order']:.2g} at leading order and "
        f"{by_distance[d]['finite size']:.2g} with it"
        for d in (3.0, 10.0, 20.0)
    )
    recorder.text(
        "**What a finite size is worth.** Between two spheres of which one is active it takes the "
        "error of 2s from second to sixth order. On a chain where all are active it helps only "
        "where the chain is slender: the flow of each sphere induces a stresslet in its neighbours "
        "which acts back on it, an error of third order that neither level has, and which happens "
        f"to have the sign that makes up for some of the missing finite size. Velocities: {text}. "
        "Within about 15 radii the leading order is the better choice, and it is the default."
    )


def _prices(recorder: Recorder) -> list[Priced]:
    """Slip and elastic forces together at d = 10a: error and time of each level."""
    positions, frames = arc(10.0)
    moduli = {f"elasticity.{name}": value for name, value in STIFFNESS.items()}
    changes = moduli | {"chain.spacing": SHORTER * 10.0}
    wrenches = _elastic(positions, frames)
    slip = {"2s": STRENGTHS["2s"]}

    def resolved(order: int) -> Array:
        spheres = ResolvedSpheres(positions, order=order)
        return spheres.mobility_problem(frames, slip, wrenches=wrenches).velocities

    exact = resolved(8 if recorder.quick else 10)
    evaluations: dict[str, Callable[[], Array]] = {}
    for level in LEVELS:
        model = _model(5, slip, level, changes)
        evaluations[level] = lambda model=model: model.twists(positions, frames)[:, :3]  # type: ignore[misc]
    for order in (2, 4) if recorder.quick else (2, 3, 4, 6, 8):
        evaluations[f"resolved, L = {order}"] = lambda order=order: resolved(order)  # type: ignore[misc]
    times: dict[str, list[float]] = {name: [] for name in evaluations}
    errors = {name: _error(evaluate(), exact) for name, evaluate in evaluations.items()}
    for _ in range(1 if recorder.quick else 9):
        for name, evaluate in evaluations.items():
            repeats = 1 if name.startswith("resolved") else 50
            began = time.perf_counter()
            for _ in range(repeats):
                evaluate()
            times[name].append((time.perf_counter() - began) / repeats)
    return [Priced(name, errors[name], median(times[name])) for name in evaluations]


def _table(
    recorder: Recorder,
    pairs: Mapping[str, list[Case]],
    chains: Mapping[str, list[Case]],
    driven: list[Case],
) -> None:
    rows: list[tuple[object, ...]] = []
    for what, groups in (("two spheres, one active", pairs), ("five, all active", chains)):
        for label, cases in groups.items():
            for case in cases:
                errors = case.errors
                rows.append(
                    (what, label, case.distance, errors["leading order"], errors["finite size"])
                )
    recorder.table(
        "Error of the pair laws",
        ["Spheres", "Mode", "d/a", "Leading order", "Finite size"],
        rows,
        "Largest error of a velocity over the largest velocity, against the resolved spheres.",
    )
    recorder.table(
        "Error of friction",
        ["d/a", "Each by itself", "Pairwise"],
        [(c.distance, c.errors["each by itself"], c.errors["pairwise"]) for c in driven],
        "The same for five spheres on an arc driven by the forces and torques of a chain whose "
        "rest spacing is 0.9 of theirs.",
    )
