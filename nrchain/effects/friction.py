"""(v, ω)_i += Σ_{j≠i} μ_ij · (F, T)_j: wrenches move other spheres through the fluid.

The mobilities are those of Rotne, Prager and Yamakawa (:mod:`nrchain.hydrodynamics.friction`).
Without this effect every sphere has the drag of a single sphere.
"""

from __future__ import annotations

from nrchain.effects.base import Cost, Effect
from nrchain.effects.registry import acting, register_effect
from nrchain.effects.shared.image_sums import refuse_net_forces, refuse_reach
from nrchain.effects.shared.slip_flow import pairs_within, reach_text
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene


@register_effect
class FrictionBetweenSpheres(Effect):
    """The mobility between different spheres."""

    name = "friction between spheres"
    key = "friction.kind"
    summary = "wrenches move other spheres too: Rotne–Prager–Yamakawa mobilities"
    equation = "(v, ω)_i += Σ_{j≠i} μ_ij·(F, T)_j"
    gives = "mobility"
    example = {"friction.kind": "pairwise"}  # noqa: RUF012
    fused = True

    @classmethod
    def acts(cls, scene: Scene) -> bool:
        return scene.friction.kind == "pairwise"

    @classmethod
    def check(cls, scene: Scene) -> None:
        """Refuse net forces and reaches without a sum over the images of a periodic chain."""
        refuse_net_forces(scene)
        if scene.chain.ends == "periodic":
            refuse_reach(scene, "friction.neighbours", scene.friction.neighbours)

    @classmethod
    def without(cls, scene: Scene) -> Scene:
        return load_scene(scene, friction="one-body")

    @classmethod
    def detail(cls, scene: Scene) -> str:
        return f"pairwise, {reach_text(scene.friction.neighbours)}"

    @classmethod
    def cost(cls, scene: Scene) -> Cost:
        return Cost(pairs_within(scene, scene.friction.neighbours), "pairs")

    @classmethod
    def scale(cls, scene: Scene) -> float:
        """3a/2d, the mobility of neighbours over a sphere's own, times the wrench velocity."""
        wrenches = [other.scale(scene) for other in acting(scene) if other.gives == "wrench"]
        return 1.5 * scene.chain.radius / scene.chain.spacing * max(wrenches, default=0.0)
