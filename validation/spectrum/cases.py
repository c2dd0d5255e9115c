"""The chains whose critical strengths are compared: modes, loads and what happens there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import nrchain
from validation.spectrum import laws

STIFFNESS = 1e3
LINKS = {
    "elasticity.ratio": None,
    "elasticity.stretch": STIFFNESS,
    "elasticity.shear": STIFFNESS,
}
"""Links of one stiffness at every N: ε = μ/λd² = 0.019, and the rod is its limit."""

FAR = {"slip.neighbours": "all", "friction": "pairwise"}

BUCKLED = 1.28
"""p of the chains that 3t straightens, over Euler's."""

PUSHED = 200.0
"""f̂ of the coil that travels."""


@dataclass(frozen=True)
class Case:
    """A clamped chain, the mode that is varied, and a bracket of its load.

    Attributes
    ----------
    label, load
        The mode whose strength is varied, and its load: ``"p"``, ``"m"`` or ``"f"``.
    between
        Loads between which the chain changes its stability.
    fixed
        Loads of the other modes, by mode.
    far
        Whether slip and friction act over all pairs; the law of the rod does not hold then.
    """

    title: str
    label: str
    load: str
    between: tuple[float, float]
    fixed: Mapping[str, float] = field(default_factory=dict)
    far: bool = False

    @property
    def key(self) -> str:
        return f"slip.{self.label}"

    def scene(self, count: int) -> nrchain.Scene:
        """The chain of N spheres, with the varied strength at 1."""
        table: dict[str, Any] = {
            "chain": {"particles": count, "ends": "clamped"},
            "start.shape": "straight",
            "run": {"end": 1.0},
            self.key: 1.0,
        }
        scene = nrchain.load_scene(table | LINKS | (FAR if self.far else {}))
        strengths = {
            f"slip.{label}": value / laws.per_strength(scene, label)
            for label, value in self.fixed.items()
        }
        return nrchain.load_scene(scene, **strengths)

    def unit(self, count: int) -> float:
        """The load of V = 1."""
        return laws.per_strength(self.scene(count), self.label)

    def law(self) -> tuple[float, float]:
        """Load and frequency · ΓL⁴/κ of the rod at the threshold."""
        names = {"2s": "p", "3a": "m", "3t": "f"}
        given = {names[label]: value for label, value in self.fixed.items()}
        return laws.critical(laws.Loads(**given), self.load, *self.between)

    def found(self, count: int) -> nrchain.CriticalStrength:
        """The threshold by the spectrum of the chain."""
        unit = self.unit(count)
        low, high = (load / unit for load in self.between)
        return nrchain.critical_strength(self.scene(count), self.key, (low, high))


def settling_time(scene: nrchain.Scene) -> float:
    """ΓL⁴/κ, the time of bending of the whole chain."""
    stiffness = scene.moduli.bend * scene.chain.spacing
    return scene.drag.translation / scene.chain.spacing * scene.length**4 / stiffness


NEAR = (
    Case("2s buckles", "2s", "p", (20.0, 60.0)),
    Case("3a coils", "3a", "m", (5.0, 14.0)),
    Case("3t straightens 2s", "3t", "f", (100.0, 310.0), {"2s": BUCKLED * laws.EULER}),
    Case("2s with 3t flutters", "3t", "f", (310.0, 700.0), {"2s": BUCKLED * laws.EULER}),
    Case("3a with 3t coils and travels", "3a", "m", (4.0, 14.0), {"3t": PUSHED}),
)

DISTANT = (
    Case("2s buckles, all pairs", "2s", "p", (5.0, 60.0), far=True),
    Case("3a coils, all pairs", "3a", "m", (3.0, 14.0), far=True),
    Case("2s with 3t flutters, all pairs", "3t", "f", (450.0, 900.0), {"2s": 24.0}, far=True),
)
