"""What a measurement of error against work tries: integrators, tolerances, reaches and models."""

from __future__ import annotations

from typing import Any, Literal

from nrchain.planning.flow_keys import all_pair_keys, finite_size_keys, reach_keys
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene

Axis = Literal["stepping", "reach", "model"]
Changes = dict[str, Any]

TOLERANCES = {
    "cvode": (2e-2, 2e-3, 2e-4, 2e-5, 2e-6, 2e-7, 2e-8),
    "radau": (1e-3, 1e-4, 1e-5, 1e-6, 1e-7),
    "scipy-bdf": (3e-2, 3e-3, 3e-4, 3e-5, 3e-6, 3e-7),
}
"""Tolerances tried with each integrator. Their errors go from about 1e-2 to 1e-7 radii."""

REFERENCE = "cvode", 2e-11
SECOND_OPINION = (("radau", 1e-9), ("cvode", 2e-9))
"""An independent run, whose distance from the reference is taken for the error of the reference.
The second is used where the first is refused."""

REFERENCES: dict[Axis, str] = {"reach": "the longest reach", "model": "the fullest model"}
"""The run with which each axis but that of stepping compares."""

LIMITS = ("run.max_steps", "run.max_seconds")
"""Budgets of the scene itself, which the short runs ignore."""

LONGEST_REACH = 64
"""Largest number of neighbours tried, short of all pairs."""


def stepping_changes(integrator: str, tolerance: float) -> Changes:
    """The changes that set the integrator and both tolerances."""
    return {"run.integrator": integrator, "run.rtol": tolerance, "run.atol": tolerance}


def reach_and_model(short: Scene) -> dict[Axis, dict[str, Changes]]:
    """Settings of reach and model, each with one change more than the last."""
    keys, every, reach = reach_keys(short), all_pair_keys(short), 1
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
        ("… with finite size", finite_size_keys(short)),
        ("… and pairwise friction", friction),
    ):
        if load_scene(short, **level, **further) != load_scene(short, **level):
            level = level | further
            axes["model"][name] = level
    return {axis: settings for axis, settings in axes.items() if len(settings) > 1}
