"""Rates of waves on simulated periodic chains, with nearest neighbours, all pairs and friction.

One wavelength on N spheres, qd = 2π/N. A period that cannot shorten puts a wave of amplitude A
under the tension λd(Aq)²/2: A is such that this is a millionth of the bending. A run ends before
the wave has changed by a third, and before rounding has grown e⁵-fold on any other wave.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

import nrchain
from nrchain import Scene, measure
from nrchain.theory.lattice import Branch, lattice_rates
from nrchain.theory.rod.reach import KINDS, Direction
from validation.report.uniform_chains import SPACING, STRENGTHS

WAVES = cast(tuple[tuple[str, Direction], ...], KINDS)
"""Modes, and the direction of waves on which they have a rate."""

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


@dataclass(frozen=True)
class Run:
    """Λ with nearest neighbours and with all pairs, of a mode and of the chain without it."""

    label: str
    direction: Direction
    phase: float
    passive: complex
    nearest: complex
    all: complex
    lattice_passive: complex
    lattice_nearest: complex
    lattice_all: complex

    @property
    def active(self) -> complex:
        """Simulated Λ_all − Λ_passive."""
        return self.all - self.passive

    @property
    def ratio(self) -> float:
        """Simulated (Λ_all − Λ_passive)/(Λ_nearest − Λ_passive)."""
        return (self.active / (self.nearest - self.passive)).real

    @property
    def lattice_ratio(self) -> float:
        """The same from the lattice operator of the chain."""
        active = self.lattice_all - self.lattice_passive
        return (active / (self.lattice_nearest - self.lattice_passive)).real


def simulated_rate(label: str, count: int, direction: Direction = "transverse") -> Run:
    """Simulate the wave of a mode at qd = 2π/``count``."""
    found = [
        rate_of(count, direction, slip | reach)
        for slip, reach in (
            ({}, {}),
            ({f"slip.{label}": STRENGTHS[label]}, {}),
            ({f"slip.{label}": STRENGTHS[label]}, {"slip.neighbours": "all"}),
        )
    ]
    measured, lattice = zip(*found, strict=True)
    return Run(label, direction, 2 * np.pi / count, *measured, *lattice)


def rate_of(
    count: int, direction: Direction = "transverse", changes: dict[str, Any] | None = None
) -> tuple[complex, complex]:
    """Λ of the longest wave of a periodic chain, simulated and from its lattice operator."""
    along = direction == "longitudinal"
    base = PERIODIC | (SOFT if along else {}) | {"chain.particles": count} | (changes or {})
    scene = nrchain.load_scene(base)
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
    scene = nrchain.load_scene(base, **run)
    trajectory = nrchain.simulate(scene, positions=_stretched(scene) if along else None)
    wave = measure.wave(trajectory, kind="x" if along else "right")
    return measure.rate(wave).value, complex(expected)


def _stretched(scene: Scene) -> np.ndarray:
    """Positions of a wave along x; frames are those of the straight chain."""
    s = scene.chain.spacing * np.arange(scene.chain.particles)
    positions = np.zeros((len(s), 3))
    positions[:, 0] = s + scene.start.amplitude * np.cos(scene.wavevector * s)
    return positions
