"""Where the difference of a chain of all pairs and a linear rod comes from, part by part.

The chain loses in turn its coarse steps, its finite size and its further neighbours; the rod is
that of second order, then the linear one, then that of coarse steps. Each part is the distance
between two neighbours in this row, so that their sum bounds the whole.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from nrchain import load_scene
from validation.report.recorder import Recorder
from validation.rod.cases import CASES, SPACING, Case, chain_of, chain_positions, rod_motion

PARTS = ("stepping, chain", "a/d", "reach", "d/L", "strain", "stepping, rod")
COARSE = 1e-4
"""Tolerance of coarse steps."""

SPHERES = 41

BUDGETS = CASES | {
    "3a": replace(CASES["3a"], groups={"3a": 4.0}),
    "mix": replace(CASES["mix"], groups={"2s": 20.0, "3a": 3.0, "3t": 30.0, "4a": 10.0}),
}
"""3a is weaker here: with all pairs it would turn links over."""


def parts_of(case: Case, spheres: int) -> tuple[list[float], float]:
    """Distances over L of the parts, and of the first and the last."""
    places = SPACING * np.arange(spheres)
    coarse = {"run.rtol": COARSE, "run.atol": COARSE}
    far = {"slip.neighbours": "all", "slip.finite_size": True}
    chains = [far | coarse, far, {"slip.neighbours": "all", "slip.finite_size": False}, {}]
    scene = chain_of(case, spheres)
    path = [chain_positions(case, load_scene(scene, **changes)) for changes in chains]
    for options in ({}, {"nonlinear": False}, {"nonlinear": False, "tolerance": COARSE}):
        shape, positions, frames = rod_motion(case, scene, **options)
        path.append(shape.at(places, positions, frames)[0])

    def apart(first: np.ndarray, second: np.ndarray) -> float:
        return float(np.linalg.norm(first - second, axis=1).max() / places[-1])

    return [apart(*pair) for pair in pairwise(path)], apart(path[0], path[-1])


def compare(recorder: Recorder) -> None:
    """Record the budget of every case."""
    spheres = 21 if recorder.quick else SPHERES
    rows = []
    for name, case in BUDGETS.items():
        parts, whole = parts_of(case, spheres)
        rows.append((name, *parts, whole))
    recorder.table(
        "budget",
        ("case", *PARTS, "whole"),
        rows,
        f"Distances over L, N = {spheres}: a chain of all pairs with finite size, at a tolerance of"
        f" {COARSE:g}, less the linear rod of nearest neighbours. A L/κ of 3a is 4, in the mix 3.",
    )
