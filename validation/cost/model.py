"""Leading-order pair laws → finite size → friction between spheres → the resolved spheres.

:class:`nrchain.hydrodynamics.resolved.ResolvedSpheres` solves the exterior Stokes problem with the
printed slips, whose far fields are the pair laws, to convergence. Held against it are the levels of
the simulation, in three settings:

- two spheres, one of which has slip: the error is the response of the other;
- five on an arc, all with the slip of one mode: the recoil adds to the error. The flow of a sphere
  induces a stresslet in its neighbour, which acts back at (a/r)³ relative to the pair law. A more
  accurate pair law cannot reduce that error;
- the same five without slip, driven by elastic forces and torques: friction of single spheres, or
  between all of them.

Errors are the largest error of a velocity over the largest velocity.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from statistics import median

import numpy as np
from numpy.typing import NDArray

from nrchain.hydrodynamics.resolved import ResolvedSpheres
from validation.cost import figures
from validation.cost.arcs import (
    LEVELS,
    SHORTER,
    STIFFNESS,
    arc,
    chain_errors,
    driven_errors,
    largest_error,
    model_of,
    pair_errors,
    stretched_wrenches,
)
from validation.cost.results import Case, Priced
from validation.report.recorder import Recorder
from validation.report.uniform_chains import STRENGTHS

Array = NDArray[np.float64]

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
    """At close range, finite size alone increases the error of a chain of active spheres."""
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
        "**Finite size.** Between two spheres of which one is active, finite size reduces "
        "the error of 2s from second to sixth order. On a chain of active spheres it helps only "
        "if the chain is slender. The flow of each sphere induces a stresslet in its neighbours, "
        "which acts back: an error of third order at both levels. Its sign compensates part of the "
        f"missing finite size. Velocities: {text}. Below about 15 radii the leading order has the "
        "smaller error, and it is the default."
    )


def _prices(recorder: Recorder) -> list[Priced]:
    """Slip and elastic forces together at d = 10a: error and time of each level."""
    positions, frames = arc(10.0)
    moduli = {f"elasticity.{name}": value for name, value in STIFFNESS.items()}
    changes = moduli | {"chain.spacing": SHORTER * 10.0}
    wrenches = stretched_wrenches(positions, frames)
    slip = {"2s": STRENGTHS["2s"]}

    def resolved(order: int) -> Array:
        spheres = ResolvedSpheres(positions, order=order)
        return spheres.mobility_problem(frames, slip, wrenches=wrenches).velocities

    exact = resolved(8 if recorder.quick else 10)
    evaluations: dict[str, Callable[[], Array]] = {}
    for level in LEVELS:
        model = model_of(5, slip, level, changes)
        evaluations[level] = lambda model=model: model.twists(positions, frames)[:, :3]  # type: ignore[misc]
    for order in (2, 4) if recorder.quick else (2, 3, 4, 6, 8):
        evaluations[f"resolved, L = {order}"] = lambda order=order: resolved(order)  # type: ignore[misc]
    times: dict[str, list[float]] = {name: [] for name in evaluations}
    errors = {name: largest_error(evaluate(), exact) for name, evaluate in evaluations.items()}
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
