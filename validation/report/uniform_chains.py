"""Scenes of uniform chains in the paper's units, for studies of plane waves.

a = η = 1 and d = 10 unless changed, μ = γ_T d². In the beam limit λ = 1e14, which is effectively
infinite for bending waves. Scenes that measure the rate of the slip alone have no bend and twist
modulus.
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
"""The beam limit without bending and twisting stiffness: rates of the slip alone."""

FLUID = {f"elasticity.{name}": 0.0 for name in ("stretch", "shear", "bend", "twist")}
"""No elasticity."""


def uniform_chain(slip: Mapping[str, float], changes: Mapping[str, Any] = BENDING) -> Scene:
    """A chain with slip of these strengths; ``changes`` are dotted keys of the scene."""
    base: dict[str, Any] = {"chain.particles": 10, "run.end": 1.0}
    return load_scene(base | {f"slip.{label}": v for label, v in slip.items()} | dict(changes))


def scaled(label: str, radius: float = 1.0) -> float:
    """The strength that gives a mode the same rates at this radius as at a = 1."""
    return STRENGTHS[label] / radius ** RADIUS_POWERS[label]


def branch_rates(
    scene: Scene, phases: NDArray[np.float64], branch: Branch = Branch.BEND_PLUS
) -> NDArray[np.complex128]:
    """Λ of one branch at phases qd."""
    return lattice_rates(scene, np.asarray(phases) / scene.chain.spacing)[..., branch]
