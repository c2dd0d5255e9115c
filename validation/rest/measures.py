"""Stress and velocity of a straight chain: the paper's equations, and two ways to measure them."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Literal

import numpy as np
from numpy.typing import NDArray

import nrchain

Array = NDArray[np.float64]
Reach = int | Literal["all"]

SPACING = 10.0
"""d of the simulated chains, with a = η = 1."""
HALF = 100
"""Spheres on each side of where the straight chain is measured."""
COUNT = 16
"""Spheres of the simulated chains."""


@dataclass(frozen=True)
class Resting:
    """A quantity of the chain at rest: number · γ V a^p / d^n, for nearest neighbours.

    ``stress``: True for what one side of the chain exerts on the other, False for the total on one
    sphere over d. ``turning``: True for torques, False for forces. ``power`` is p. With k
    neighbours on each side the quantity is multiplied by Σ_{m ≤ k} m^−``decay``. The sign is that
    of the pair laws; a stress is what the side at larger x exerts.
    """

    name: str
    number: float
    power: int
    decay: int
    stress: bool
    turning: bool
    equation: str
    formula: str

    @property
    def pair_decay(self) -> int:
        """k of the pair law's 1/r^k; m pairs of m-th neighbours reach across a cut."""
        return self.decay + self.stress

    def nearest(
        self, radius: float = 1.0, spacing: float = SPACING, viscosity: float = 1.0
    ) -> float:
        """The quantity over V for nearest neighbours."""
        friction = 8 * pi * radius**3 if self.turning else 6 * pi * radius
        scale = radius**self.power / spacing ** (self.pair_decay + (not self.stress))
        return self.number * viscosity * friction * scale

    @property
    def seen(self) -> str:
        """Symbol of the quantity that a simulated chain shows: the stress, V₀ or Ω₀."""
        return self.name if self.stress else "Ω₀" if self.turning else "V₀"

    @property
    def drag(self) -> float:
        """The quantity divided by the one that a simulated chain shows: 1, Γ_T or Γ_R."""
        return 1.0 if self.stress else (8 * pi if self.turning else 6 * pi) / SPACING

    def factor(self, reach: int) -> float:
        """Σ_{m ≤ k} m^−s: k neighbours on each side of a long chain, over nearest neighbours."""
        return float(np.sum(np.arange(1.0, reach + 1) ** -self.decay))

    def across(self, half: int) -> float:
        """Σ (j − i)^−k over the pairs across the middle of a chain of 2 · ``half`` spheres."""
        gaps = np.add.outer(np.arange(half), np.arange(half)) + 1.0
        return float(np.sum(gaps**-self.pair_decay))


RESTING = {
    "2s": Resting("prestress", -7 / 3, 2, 1, True, False, "2s_prestress", "−7a²γ_T V/3d²"),
    "3a": Resting("pre-moment", -13 / 12, 3, 3, True, True, "3a_pretorque", "13a³γ_R V/12d⁴"),
    "3t": Resting("pre-force", 4 / 5, 3, 3, False, False, "3t_pre_force", "4a³γ_T V/5d⁴"),
    "4a": Resting("pre-torque", -363 / 5, 4, 5, False, True, "4a_pre_torque", "−363a⁴γ_R V/5d⁶"),
}


def exerted(
    label: str,
    *,
    reach: Reach = 1,
    half: int = HALF,
    radius: float = 1.0,
    spacing: float = SPACING,
    viscosity: float = 1.0,
) -> float:
    """The resting quantity of a straight chain over V, from the pair forces.

    A stress is the sum, over one half of the chain, of what the slip of the other half exerts.
    A total is that on the middle sphere, over d.
    """
    law = RESTING[label]
    count = 2 * half + (not law.stress)
    strength = np.ones(count)
    if law.stress:
        strength[:half] = 0.0
    wrenches = nrchain.active_wrenches(
        spacing * np.arange(count)[:, None] * np.array([1.0, 0.0, 0.0]),
        np.broadcast_to(np.eye(3), (count, 3, 3)),
        {label: strength},
        neighbours=reach,
        radius=radius,
        viscosity=viscosity,
    )
    along = wrenches[int(law.turning)][:, 0]
    return float(np.sum(along[:half])) if law.stress else float(along[half]) / spacing


def _run(label: str, strength: float, reach: Reach, ends: str, end: float) -> nrchain.Trajectory:
    trajectory = nrchain.simulate(
        nrchain.load_scene(
            {
                "chain": {"particles": COUNT, "ends": ends, "spacing": SPACING},
                "elasticity": {"ratio": 1e12},
                "slip": {label: strength, "neighbours": reach},
                "run": {"end": end, "snapshots": 101, "rtol": 1e-9, "atol": 1e-12},
            }
        )
    )
    if trajectory.status != "completed":
        raise RuntimeError(f"the run stopped {trajectory.reason}")
    return trajectory


def sprung(label: str, strength: float, reach: Reach) -> float:
    """Minus the elastic force or torque across the middle of a free chain at rest."""
    law = RESTING[label]
    trajectory = _run(label, strength, reach, "free", 20.0 if law.turning else 1.0)
    moduli = trajectory.scene.moduli
    wrenches = nrchain.elastic_wrenches(
        trajectory.positions[-1],
        trajectory.frames[-1],
        spacing=SPACING,
        stretch=moduli.stretch,
        shear=moduli.shear,
        twist=moduli.twist,
        bend=moduli.bend,
    )
    return -float(np.sum(wrenches[int(law.turning)][: COUNT // 2, 0]))


def steady(label: str, strength: float, reach: Reach, ends: str) -> float:
    """Velocity or angular velocity of the chain along x over the second half of a run."""
    trajectory = _run(label, strength, reach, ends, 10.0)
    if RESTING[label].turning:
        second = trajectory.frames[:, :, 1]
        along = np.unwrap(np.arctan2(second[..., 2], second[..., 1]), axis=0)
    else:
        along = trajectory.positions[..., 0]
    half, mean = len(trajectory.time) // 2, along.mean(axis=1)
    return float((mean[-1] - mean[half]) / (trajectory.time[-1] - trajectory.time[half]))
