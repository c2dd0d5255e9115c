"""V = Σ_links (λ∥d²/2)(C⁰e₁·C¹r − 1)²: bonds resist being longer or shorter than d along e₁.

Source: paper, Appendix B; C⁰ and C¹ in :mod:`nrchain.effects.link`.
"""

from __future__ import annotations

from nrchain._compile import kernel
from nrchain.effects.elasticity import ElasticTerm
from nrchain.effects.link import dot
from nrchain.effects.registry import register_effect
from nrchain.scene import Scene, load_scene


@kernel
def strain(e, tangent):
    """C⁰e₁·C¹r − 1."""
    return dot(e, tangent) - 1.0


@register_effect
class Stretch(ElasticTerm):
    """λ∥: F and T of stretched bonds."""

    name = "stretch"
    key = "elasticity.stretch"
    summary = "bonds resist being longer or shorter than d along e₁"
    equation = "V = Σ_links (λ∥d²/2)(C⁰e₁·C¹r − 1)²"

    @classmethod
    def without(cls, scene: Scene) -> Scene:
        shear = scene.moduli.shear
        changes = {"ratio": None, "stretch": 0.0, "shear": shear}
        return load_scene(scene, elasticity=changes)

    @classmethod
    def scale(cls, scene: Scene) -> float:
        return scene.moduli.stretch * scene.chain.radius / scene.drag.translation
