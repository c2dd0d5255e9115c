"""u = −(5a³/2) x (x·E·x)/r⁵, w = −(5a³/2)(E·x) × x/r⁵: rigid spheres resist a strain.

E is the symmetric part of the gradient of a background flow. A rigid sphere does not deform with
the fluid: it disturbs the flow by its stresslet S = (20/3)πηa³E, which moves and rotates the other
spheres. This is the leading order in a/r; the next order is the effect ``finite size of strain``.
Both extend over ``flow.neighbours``, by default all pairs, independently of friction and slip.
Nearest neighbours alone would miss a third of a flow that decays as 1/r².
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from nrchain._addresses import Term
from nrchain.effects.base import Cost, Effect
from nrchain.effects.flow import Flow
from nrchain.effects.registry import register_effect
from nrchain.effects.shared.image_sums import refuse_reach
from nrchain.effects.shared.slip_flow import pairs_within, reach_text
from nrchain.errors import SceneError
from nrchain.hydrodynamics.disturbance import Disturbance, Part
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene


class DisturbanceEffect(Effect):
    """One part of the disturbance of a background flow by rigid spheres."""

    part: ClassVar[Part]
    gives = "twist"
    covariant = False
    placed = False

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        chain, flow = scene.chain, Flow.section(scene)
        self.disturbance = Disturbance(
            self.part,
            flow.matrix,
            count=chain.particles,
            radius=chain.radius,
            reach=flow.neighbours if isinstance(flow.neighbours, int) else None,
            period=scene.period,
            accuracy=scene.pair_accuracy,
        )
        self.places = self.disturbance.near

    @classmethod
    def check(cls, scene: Scene) -> None:
        if scene.chain.ends == "periodic":
            reach = Flow.section(scene).neighbours
            refuse_reach(scene, "flow.neighbours", reach)

    @classmethod
    def detail(cls, scene: Scene) -> str:
        return f"{cls.part}, {reach_text(Flow.section(scene).neighbours)}"

    @classmethod
    def cost(cls, scene: Scene) -> Cost:
        return Cost(pairs_within(scene, Flow.section(scene).neighbours), "pairs")

    @classmethod
    def at_spacing(cls, scene: Scene, factor: float, power: int) -> float:
        """factor (a/d)^power |E| d: the velocity of one neighbour at d."""
        gradient, d = Flow.section(scene).matrix, scene.chain.spacing
        strain = 0.5 * float(np.linalg.norm(gradient + gradient.T, 2))
        return factor * (scene.chain.radius / d) ** power * strain * d

    @classmethod
    def straight(cls, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
        """Raises SceneError: the theory of the infinite straight chain does not include it."""
        allowed = (
            "is not part of the theory of the infinite straight chain: set flow.disturbance = false"
        )
        raise SceneError("flow.disturbance", True, allowed)

    def add_twists(self, positions: np.ndarray, frames: np.ndarray, twists: np.ndarray) -> None:
        self.disturbance.add_twists(positions, twists)

    def term(self) -> Term | None:
        return self.disturbance.term()

    def linearise(self, positions: np.ndarray, frames: np.ndarray) -> None:
        self.disturbance.linearise(positions)

    def add_blocks(self, blocks: np.ndarray) -> None:
        self.disturbance.add_blocks(blocks)

    def add_product(self, poses: np.ndarray, out: np.ndarray) -> None:
        self.disturbance.add_product(poses, out)


@register_effect
class Strain(DisturbanceEffect):
    """The stresslets by which rigid spheres disturb a background flow."""

    name = "strain"
    key = "flow.disturbance"
    summary = "rigid spheres in a background flow disturb it: their stresslets"
    absence = "spheres disturb no background flow"
    equation = "u = −(5a³/2) x (x·E·x)/r⁵, w = ½ curl u"
    part = "stresslet"
    example = Flow.example

    @classmethod
    def acts(cls, scene: Scene) -> bool:
        gradient = Flow.section(scene).matrix
        return Flow.section(scene).disturbance and bool((gradient + gradient.T).any())

    @classmethod
    def without(cls, scene: Scene) -> Scene:
        return load_scene(scene, **{cls.key: False})

    @classmethod
    def scale(cls, scene: Scene) -> float:
        """One neighbour at d: (5/2)(a/d)³ |E| d."""
        return cls.at_spacing(scene, 5 / 2, 3)
