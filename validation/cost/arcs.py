"""Two spheres and five on an arc: velocities of each level of the model, and their errors."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache

import numpy as np
from numpy.typing import NDArray

from nrchain import elastic_wrenches, load_scene
from nrchain.hydrodynamics.resolved import ResolvedSpheres
from nrchain.motion.model import Model
from nrchain.scene.poses import frames_along
from validation.cost.results import Case
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


def pair_errors(label: str, distance: float) -> Case:
    """The velocity of a force-free sphere beside one with slip, seen at an oblique angle."""
    positions = arc(distance, 2)[0]
    axis = np.array([1.0, 0.5, 0.3])
    frames = frames_along(np.stack([axis / np.linalg.norm(axis), [1.0, 0.0, 0.0]]))
    slip = {label: np.array([STRENGTHS[label], 0.0])}
    exact = _resolved(2, distance).mobility_problem(frames, slip).velocities[1]
    errors = {}
    for level in ("leading order", "finite size"):
        model = model_of(2, {label: (STRENGTHS[label], 0.0)}, level)
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
            level: largest_error(
                model_of(5, {label: STRENGTHS[label]}, level).twists(positions, frames), exact
            )
            for level in ("leading order", "finite size")
        },
    )


def driven_errors(distance: float) -> Case:
    """Five spheres on an arc, driven by the wrenches of a chain with shorter rest lengths."""
    positions, frames = arc(distance)
    wrenches = stretched_wrenches(positions, frames)
    exact = _resolved(5, distance).mobility_problem(frames, {}, wrenches=wrenches).velocities
    moduli = {f"elasticity.{name}": value for name, value in STIFFNESS.items()}
    errors = {}
    for name, level in (("each by itself", "leading order"), ("pairwise", "pairwise friction")):
        model = model_of(5, {}, level, moduli | {"chain.spacing": SHORTER * distance})
        errors[name] = largest_error(model.twists(positions, frames), exact)
    return Case(distance, errors)


def arc(distance: float, count: int = 5) -> tuple[Array, Array]:
    """Spheres on an arc, neighbours ``distance`` apart, with frames along its tangents."""
    turns = BEND * (np.arange(count) - (count - 1) / 2)
    links = BEND * (np.arange(count - 1) - (count - 2) / 2)
    positions = np.zeros((count, 3))
    positions[1:, :2] = np.cumsum(distance * np.stack([np.cos(links), np.sin(links)], 1), axis=0)
    return positions, frames_along(np.stack([np.cos(turns), np.sin(turns), 0 * turns], axis=1))


def stretched_wrenches(positions: Array, frames: Array) -> tuple[Array, Array]:
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


def model_of(
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


def largest_error(twists: Array, exact: Array) -> float:
    off = np.linalg.norm(twists[:, :3] - exact, axis=1)
    return float(off.max() / np.linalg.norm(exact, axis=1).max())
