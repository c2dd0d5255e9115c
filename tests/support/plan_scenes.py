"""Random scenes with fixed seeds, on both sides of what links hold."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene

MIXES = (("2s",), ("3t",), ("4a",), ("3a",), ("2s", "3t"), ("2s", "3a"), ("3t", "4a"), ("2s", "4a"))

FORCES = {"2s": (7.0 / 3.0, 2), "3t": (4.0 / 5.0, 3)}
"""c and k of the velocity c V (a/d)^k that neighbours on both sides, or one, give along a chain."""

TORQUES = {"3a": (13.0 / 6.0, 4), "4a": (363.0 / 5.0, 5)}
"""The same of the angular velocity times a."""

LEAST, MOST = 0.01, 0.7
"""Of force over λd, force times d over μ⊥ and torque over μ⊥: log-uniform between these."""


def random_scene(seed: int) -> Scene:
    """A scene of 6 to 40 spheres, none of its numbers 1, with strengths along the chain."""
    random = np.random.default_rng([seed, 31415])
    count = int(random.integers(6, 41))
    radius, viscosity = random.uniform(0.5, 2.0, 2)
    spacing = radius * random.uniform(5.0, 12.0)
    drag = 6.0 * math.pi * viscosity * radius
    force, turning, torque = np.exp(random.uniform(math.log(LEAST), math.log(MOST), 3))
    bend = drag * spacing**2 * random.uniform(0.3, 3.0)
    largest = turning * bend / spacing
    stretch = largest / (force * spacing)
    ends = str(random.choice(["free", "clamped", "periodic"]))
    table: dict[str, Any] = {
        "chain": {
            "particles": count,
            "radius": float(radius),
            "viscosity": float(viscosity),
            "spacing": float(spacing),
            "ends": ends,
        },
        "elasticity": {
            "stretch": float(stretch),
            "shear": float(stretch * random.uniform(0.3, 2.0)),
            "bend": float(bend),
            "twist": float(bend * 10.0 ** random.uniform(-1.5, 0.3)),
            "measure": str(random.choice(["paper", "isotropic"])),
        },
        "slip.neighbours": (1, 2, 3, "all")[int(random.integers(4))],
        "friction": str(random.choice(["one-body", "one-body", "pairwise"])),
        "start": {
            "shape": str(random.choice(["random", "sine", "helix-left"])),
            "amplitude": float(spacing * 10.0 ** random.uniform(-3.0, -1.0)),
            "seed": int(random.integers(1000)),
        },
        "run.end": float(spacing * drag / largest * 10.0 ** random.uniform(0.5, 3.0)),
        "run.snapshots": 2,
    }
    for label in MIXES[seed % len(MIXES)]:
        if label in FORCES:
            factor, power = FORCES[label]
            strength = largest / (drag * factor * (radius / spacing) ** power)
        else:
            factor, power = TORQUES[label]
            velocity = torque * bend / (8.0 * math.pi * viscosity * radius**3)
            strength = velocity * radius / (factor * (radius / spacing) ** power)
        table[f"slip.{label}"] = _along_the_chain(random, count, float(strength))
    return load_scene(table)


def _along_the_chain(random: np.random.Generator, count: int, strength: float) -> Any:
    """One strength, two halves that differ, a few spheres alone, or one a sphere."""
    signed = strength * float(random.choice([-1.0, 1.0]))
    kind = int(random.integers(4))
    if kind == 0:
        return signed
    if kind == 1:
        cut = int(random.integers(1, count))
        return [signed] * cut + [signed * float(random.uniform(-1.0, 1.0))] * (count - cut)
    each = strength * random.uniform(-1.0, 1.0, count)
    if kind == 2:
        each[random.random(count) < 0.7] = 0.0
        each[int(random.integers(count))] = signed
    return each.tolist()
