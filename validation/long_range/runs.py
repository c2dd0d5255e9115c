"""Rates of waves on simulated periodic chains, with nearest neighbours, all pairs and friction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np

from nrchain.theory.rod.reach import KINDS, Direction
from validation.report.periodic_waves import rate_of
from validation.report.uniform_chains import STRENGTHS

WAVES = cast(tuple[tuple[str, Direction], ...], KINDS)
"""Modes, and the directions of the waves on which they have a rate."""


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
