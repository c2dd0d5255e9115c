"""Random scenes with fixed seeds: all ends, modes, reaches and starts, in flows and fields."""

from __future__ import annotations

from typing import Any

import numpy as np

from nrchain import Scene, load_scene

STRENGTHS = {"2s": 100.0, "3a": 5000.0, "3t": 1000.0, "4a": 10_000.0}
"""Those of the shipped scenes; random ones are 0.2 to 1.2 times as large, of either sign."""

MIXES = (
    ("2s",), ("3a",), ("3t",), ("4a",), ("2s", "3a"), ("3t", "4a"), ("2s", "3t", "4a"), (),
)  # fmt: skip
SNAPSHOTS = 21


def random_scene(seed: int) -> Scene:
    """A scene of 3 to 20 spheres at a tolerance of 1e-4 to 1e-7, with the default integrator.

    Every eighth has no slip: a force, or a shear flow on free chains, drives it.
    """
    random = np.random.default_rng([seed, 2718])
    ends = str(random.choice(["free", "clamped", "periodic"]))
    tolerance = 10.0 ** -(4 + seed % 4)
    table: dict[str, Any] = {
        "chain": {
            "particles": int(random.integers(3, 21)),
            "ends": ends,
            "spacing": float(random.uniform(6.0, 14.0)),
            "radius": float(random.uniform(0.5, 1.5)),
            "viscosity": float(random.uniform(0.5, 2.0)),
        },
        "elasticity": {
            "ratio": float(10.0 ** random.uniform(5.0, 12.0)),
            "measure": str(random.choice(["paper", "isotropic"])),
        },
        "start": {
            "shape": str(random.choice(["random", "sine", "helix-left"])),
            "amplitude": float(random.uniform(0.05, 1.0)),
            "seed": int(random.integers(1000)),
        },
        "run": {
            "end": float(10.0 ** random.uniform(1.0, 2.5)),
            "snapshots": SNAPSHOTS,
            "rtol": tolerance,
            "atol": tolerance,
        },
    }
    labels = MIXES[seed % len(MIXES)]
    for label in labels:
        strength = STRENGTHS[label] * random.uniform(0.2, 1.2) * random.choice([-1.0, 1.0])
        table[f"slip.{label}"] = float(strength)
    if ends != "periodic":
        table["slip.neighbours"] = (1, 1, 2, "all")[int(random.integers(4))]
        table["friction"] = str(random.choice(["one-body", "one-body", "pairwise"]))
    shear = float(10.0 ** random.uniform(-3.0, -1.0))
    if ends == "free" and random.random() < 0.5:
        table["flow.gradient"] = [[0.0, 0.0, shear], [0.0] * 3, [0.0] * 3]
        table["friction"] = "pairwise"
    elif not labels:
        table["field.force"] = [0.0, 0.0, -float(random.uniform(0.1, 2.0))]
    return load_scene(table)
