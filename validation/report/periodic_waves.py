"""Λ of one wave around a periodic chain: simulated, and from the lattice operator.

One wavelength on N spheres, qd = 2π/N. The period cannot shorten, so a wave of amplitude A is under
the tension λd(Aq)²/2; A is so small that this is a millionth of the bending. A run ends before the
wave changes by a third, and before rounding errors grow e⁵-fold on any other wave.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from nrchain import Branch, Scene, lattice_rates, load_scene, measure, simulate
from nrchain.theory.rod.reach import Direction
from validation.report.uniform_chains import SPACING

TENSION = 1e-6
"""λA²/2μ."""

ACCURACY = 1e-7
"""Relative tolerance per step; the absolute one is that times A."""

PERIODIC: dict[str, Any] = {
    "chain.ends": "periodic",
    "elasticity.stretch": 1e5,
    "elasticity.shear": 1e5,
    "start.shape": "helix-right",
    "run.end": 1.0,
    "run.snapshots": 61,
    "run.rtol": ACCURACY,
}
SOFT = {"elasticity.stretch": 0.5, "elasticity.shear": 500.0}
"""For waves along x: λ∥ small enough for the slip to show beside it."""


def rate_of(
    count: int, direction: Direction = "transverse", changes: dict[str, Any] | None = None
) -> tuple[complex, complex]:
    """Λ of the longest wave of a periodic chain, simulated and from its lattice operator."""
    along = direction == "longitudinal"
    base = PERIODIC | (SOFT if along else {}) | {"chain.particles": count} | (changes or {})
    scene = load_scene(base)
    wavenumbers = 2 * np.pi * np.arange(1, count // 2 + 1) / (count * SPACING)
    rates = lattice_rates(scene, wavenumbers)
    expected = rates[0, Branch.STRETCH if along else Branch.BEND_PLUS]
    growth = max(float(rates.real.max()), 1e-300)
    moduli = scene.moduli
    height = math.sqrt(2 * TENSION * moduli.bend / max(moduli.stretch, moduli.shear))
    run = {
        "start.amplitude": height,
        "run.end": min(0.3 / abs(expected), 5.0 / growth),
        "run.atol": ACCURACY * height,
    }
    scene = load_scene(base, **run)
    trajectory = simulate(scene, positions=_stretched(scene) if along else None)
    wave = measure.wave(trajectory, kind="x" if along else "right")
    return measure.rate(wave).value, complex(expected)


def _stretched(scene: Scene) -> np.ndarray:
    """Positions of a wave along x; frames are those of the straight chain."""
    s = scene.chain.spacing * np.arange(scene.chain.particles)
    positions = np.zeros((len(s), 3))
    positions[:, 0] = s + scene.start.amplitude * np.cos(scene.wavevector * s)
    return positions
