"""V = Σ_{i<j} φ(|r_i − r_j|): a repulsion between spheres at short distances.

With ε the strength and c the range, the distance of centres at which it begins,

    wca        φ = 4ε[(σ/r)¹² − (σ/r)⁶ + 1/4],  σ = c/2^(1/6)
    harmonic   φ = (ε/2)(1 − r/c)²

for r < c, and 0 beyond; φ and φ′ are continuous there. Forces act along the line of centres,
F_i = −φ′ n with n = (r_i − r_j)/r, and turn nothing.

Weeks, Chandler, Andersen, J. Chem. Phys. 54, 5237 (1971).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import numpy as np

from nrchain._addresses import Term
from nrchain.effects.base import Cost, Effect
from nrchain.effects.registry import register_effect
from nrchain.errors import NOT_GIVEN, SceneError
from nrchain.geometry.near_pairs import DIRECT_SEARCH
from nrchain.inputs.about import About
from nrchain.inputs.rules import Section, choice, number, optional
from nrchain.potential.repulsion import KINDS, SKIN, Repulsion, potential
from nrchain.scene.scene import Scene

Kind = Literal["none", "wca", "harmonic"]


@dataclass(frozen=True, slots=True, kw_only=True)
class StericSpec(Section):
    """A repulsion between spheres that come near each other, along the chain or across it.

    ``strength`` is an energy; ``range`` the distance of centres below which spheres repel each
    other, 2^(1/6) times two radii when it is not given.
    """

    path: ClassVar[str] = "steric"
    kind: Annotated[Kind, choice(Kind)] = "none"
    strength: Annotated[float | None, optional(number(above=0))] = None
    range: Annotated[float | None, optional(number(above=0))] = None
    about: ClassVar[Mapping[str, About]] = {
        "kind": About("", "", '"none", "wca", "harmonic"', "form of the repulsion φ(r)"),
        "strength": About("ε", "F L", "> 0, together with kind", "energy of the repulsion"),
        "range": About(
            "c", "L", "2a < c ≤ d", "distance of centres below which φ acts; 2^(1/6)·2a if not set"
        ),
    }

    @property
    def acts(self) -> bool:
        """Whether a repulsion is named."""
        return self.kind != "none"

    def check(self) -> None:
        if self.acts and self.strength is None:
            raise SceneError("steric.strength", NOT_GIVEN, "must be given along with steric.kind")
        for name in ("strength", "range"):
            if not self.acts and getattr(self, name) is not None:
                allowed = "acts only with a repulsion: name steric.kind, 'wca' or 'harmonic'"
                raise SceneError(f"steric.{name}", getattr(self, name), allowed)


@register_effect
class Steric(Effect):
    """The repulsion of a scene."""

    name = "steric repulsion"
    summary = "spheres that come near each other push each other away"
    absence = "a run stops where spheres touch"
    equation = "V = Σ_{i<j} φ(|r_i − r_j|), for r < c"
    Section = StericSpec
    example = {"steric": {"kind": "harmonic", "strength": 100.0, "range": 4.0}}  # noqa: RUF012
    placed = False
    torque_free = True

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        section = self.section(scene)
        self.whole_term = scene.chain.particles <= DIRECT_SEARCH
        self._repulsion = Repulsion(section.kind, section.strength, self.range(scene), scene.period)

    @classmethod
    def range(cls, scene: Scene) -> float:
        """Distance of centres at which the repulsion begins: as given, or 2^(1/6) · 2a."""
        given = cls.section(scene).range
        return 2 ** (7 / 6) * scene.chain.radius if given is None else given

    @classmethod
    def acts(cls, scene: Scene) -> bool:
        return cls.section(scene).acts

    @classmethod
    def check(cls, scene: Scene) -> None:
        """Refuse a range that acts at the rest distance, or only on overlapping spheres."""
        reach, spacing, radius = cls.range(scene), scene.chain.spacing, scene.chain.radius
        if cls.acts(scene) and not 2 * radius < reach <= spacing:
            allowed = (
                f"must exceed two radii, {2 * radius!r}, and be no more than"
                f" chain.spacing = {spacing!r}, or neighbours at rest push each other apart"
            )
            raise SceneError("steric.range", reach, allowed)

    @classmethod
    def balanced(cls, scene: Scene) -> bool:
        return True

    @classmethod
    def detail(cls, scene: Scene) -> str:
        section = cls.section(scene)
        return f"{section.kind}, strength {section.strength:g}, below {cls.range(scene):.4g}"

    @classmethod
    def cost(cls, scene: Scene) -> Cost:
        """Neighbours along the chain, if the list of pairs includes them."""
        near = scene.chain.spacing < (1.0 + SKIN) * cls.range(scene)
        return Cost(scene.chain.particles if near else 0, "pairs")

    @classmethod
    def scale(cls, scene: Scene) -> float:
        """The velocity at a distance of two radii, or of half the range if that is larger."""
        section, reach = cls.section(scene), cls.range(scene)
        distance = max(2.0 * scene.chain.radius, 0.5 * reach)
        _, slope, _ = potential(KINDS[section.kind], distance, section.strength, reach)
        return float(-slope) / scene.drag.translation

    @classmethod
    def straight(cls, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
        """Zero: repulsion begins at the rest distance or below."""
        return np.zeros(6), np.zeros((6, 6))

    def add_wrenches(self, positions: np.ndarray, frames: np.ndarray, wrenches: np.ndarray) -> None:
        self._repulsion.add_wrenches(positions, wrenches)

    def linearise(self, positions: np.ndarray, frames: np.ndarray) -> None:
        self._repulsion.linearise(positions)

    def add_blocks(self, blocks: np.ndarray) -> None:
        self._repulsion.add_blocks(blocks)

    def add_product(self, poses: np.ndarray, out: np.ndarray) -> None:
        self._repulsion.add_product(poses, out)

    def term(self) -> Term | None:
        """Machine code that searches pair by pair; None for chains searched with a tree."""
        return self._repulsion.term(self.scene.chain.particles) if self.whole_term else None

    def energy(self, positions: np.ndarray, frames: np.ndarray) -> float:
        return self._repulsion.add_wrenches(positions, np.zeros((len(positions), 6)))
