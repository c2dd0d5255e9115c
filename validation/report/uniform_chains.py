"""Scenes of uniform chains in the paper's units, for studies of plane waves.

a = η = 1 and d = 10 unless changed, μ = γ_T d². In the beam limit λ is 1e14, so far above all other
moduli that bending waves are as if it were infinite, and where only the rate of the slip is asked
for, bend and twist are left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nrchain import Branch, Scene, lattice_rates, load_scene

SPACING = 10.0
STRENGTHS = {"2s": 100.0, "3a": 5000.0, "3t": 1000.0, "4a": 10000.0}
"""V of the paper's snapshots, Appendix D."""

RADIUS_POWERS = {"2s": 2, "3a": 3, "3t": 3, "4a": 4}
"""p of Λ ∝ a^p V/d^(p+1)."""

BENDING = {"elasticity.stretch": 1e14, "elasticity.shear": 1e14}
"""The beam limit."""

LIMP = BENDING | {"elasticity.bend": 0.0, "elasticity.twist": 0.0}
"""The beam limit, without resistance to bending: rates of the slip alone."""

FLUID = {f"elasticity.{name}": 0.0 for name in ("stretch", "shear", "bend", "twist")}
"""No springs at all."""


def uniform_chain(slip: Mapping[str, float], changes: Mapping[str, Any] = BENDING) -> Scene:
    """A chain with slip of these strengths; ``changes`` are dotted keys of the scene."""
    base: dict[str, Any] = {"chain.particles": 10, "run.end": 1.0}
    return load_scene(base | {f"slip.{label}": v for label, v in slip.items()} | dict(changes))


def scaled(label: str, radius: float = 1.0) -> float:
    """The strength at which a mode of spheres of this radius has the rates of a = 1."""
    return STRENGTHS[label] / radius ** RADIUS_POWERS[label]


def branch_rates(
    scene: Scene, phases: NDArray[np.float64], branch: Branch = Branch.BEND_PLUS
) -> NDArray[np.complex128]:
    """Λ of one branch at phases qd."""
    return lattice_rates(scene, np.asarray(phases) / scene.chain.spacing)[..., branch]
