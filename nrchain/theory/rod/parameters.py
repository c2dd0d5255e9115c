"""Γ = γ/d, κ_T = λd, κ_R = μd: a uniform chain of the paper's modes, in the paper's notation."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Self

from nrchain.effects.registry import acting
from nrchain.errors import SceneError
from nrchain.hydrodynamics import slip_modes
from nrchain.scene.fluid_sections import SlipSpec
from nrchain.scene.loading import require_scene
from nrchain.scene.scene import Scene

MODES = ("2s", "3a", "3t", "4a")
"""The modes whose continuum theory the paper gives: one of each symmetry."""

LEFT_ASIDE = ("steric",)
"""Sections of effects that do not act on a straight chain."""


@dataclass(frozen=True, kw_only=True)
class Rod:
    """Γ = γ/d, κ_T = λd, κ_R = μd: parameters of a chain and the densities of its rod.

    Parameters
    ----------
    radius, spacing, viscosity
        a, d and η.
    stretch, shear, twist, bend
        λ∥, λ⊥, μ∥ and μ⊥; the paper has λ∥ = λ⊥ = λ and μ∥ = μ⊥ = μ.
    strengths
        V of each mode, about e_1; 0 for modes that are not listed.

    >>> from nrchain import load_scene
    >>> Rod.of(load_scene("buckling")).spacing
    10.0
    """

    radius: float = 1.0
    spacing: float = 10.0
    viscosity: float = 1.0
    stretch: float = 0.0
    shear: float = 0.0
    twist: float = 0.0
    bend: float = 0.0
    strengths: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for label in self.strengths:
            if label not in MODES:
                allowed = f"the continuum theory is that of {', '.join(MODES)}"
                raise SceneError("strengths", label, allowed)

    @classmethod
    def of(cls, scene: Scene) -> Self:
        """The parameters of a scene.

        Raises :class:`~nrchain.errors.SceneError` for modes outside the theory, strengths that
        differ between spheres, axes other than ±e_1, fields, background flows and registered
        effects. The theory has nearest neighbours at leading order in a/d: ``slip.neighbours`` and
        ``slip.finite_size`` have no effect here. For more neighbours see :mod:`nrchain.rod.reach`.
        """
        chain, moduli = require_scene(scene).chain, scene.moduli
        for effect in acting(scene):
            if effect.Section is not None and effect.Section.path not in LEFT_ASIDE:
                allowed = "is not part of the theory of the rod: remove it from the scene"
                raise SceneError(effect.key, effect.value(scene), allowed)
        strengths: dict[str, float] = {}
        for label, slip in scene.slip.modes.items():
            key, given = SlipSpec.key(label), slip.strength
            values = set(given) if isinstance(given, tuple) else {given}
            if label not in MODES:
                raise SceneError(key, slip.strength, f"the theory knows {', '.join(MODES)}")
            if len(values) > 1:
                raise SceneError(key, slip.strength, "must be one number for all spheres")
            if slip.axis[1] or slip.axis[2]:
                raise SceneError(f"{key}.axis", slip.axis, "must lie along e_1")
            flips = slip.axis[0] < 0 and slip_modes.find(label).polar
            strengths[label] = -values.pop() if flips else values.pop()
        return cls(
            radius=chain.radius,
            spacing=chain.spacing,
            viscosity=chain.viscosity,
            stretch=moduli.stretch,
            shear=moduli.shear,
            twist=moduli.twist,
            bend=moduli.bend,
            strengths=strengths,
        )

    @property
    def gamma_T(self) -> float:
        """γ_T = 6πηa."""
        return 6 * math.pi * self.viscosity * self.radius

    @property
    def gamma_R(self) -> float:
        """γ_R = 8πηa³."""
        return 8 * math.pi * self.viscosity * self.radius**3

    @property
    def Gamma_T(self) -> float:
        """Γ^T = γ_T/d."""
        return self.gamma_T / self.spacing

    @property
    def Gamma_R(self) -> float:
        """Γ^R = γ_R/d."""
        return self.gamma_R / self.spacing

    @property
    def kappa_T(self) -> tuple[float, float]:
        """(κ_T∥, κ_T⊥) = (λ∥ d, λ⊥ d)."""
        return self.stretch * self.spacing, self.shear * self.spacing

    @property
    def kappa_R(self) -> tuple[float, float]:
        """(κ_R∥, κ_R⊥) = (μ∥ d, μ⊥ d)."""
        return self.twist * self.spacing, self.bend * self.spacing
