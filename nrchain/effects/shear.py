"""V = Σ_links (λ⊥d²/2) Σ_{a=2,3} (C⁰e_a·C¹r)²: bonds resist leaving the direction of e₁.

The kernels are in :mod:`nrchain.potential.shear`.
"""

from __future__ import annotations

from nrchain.effects.registry import register_effect
from nrchain.effects.shared.elasticity import ElasticTerm
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene


@register_effect
class Shear(ElasticTerm):
    """λ⊥: F and T of bonds that lean away from e₁."""

    name = "shear"
    key = "elasticity.shear"
    summary = "bonds resist leaving the direction of e₁"
    equation = "V = Σ_links (λ⊥d²/2) Σ_{a=2,3} (C⁰e_a·C¹r)²"

    @classmethod
    def without(cls, scene: Scene) -> Scene:
        stretch = scene.moduli.stretch
        changes = {"ratio": None, "stretch": stretch, "shear": 0.0}
        return load_scene(scene, elasticity=changes)

    @classmethod
    def scale(cls, scene: Scene) -> float:
        return scene.moduli.shear * scene.chain.radius / scene.drag.translation
