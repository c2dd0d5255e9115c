"""V = Σ_links (λ⊥d²/2) Σ_{a=2,3} (C⁰e_a·C¹r)²: bonds resist leaving the direction of e₁.

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
    """C⁰e_a·C¹r, a = 2 or 3."""
    return dot(e, tangent)


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
