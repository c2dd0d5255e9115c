"""V = Σ_links (λ∥d²/2)(C⁰e₁·C¹r − 1)²: bonds resist being longer or shorter than d along e₁.

The kernels are in :mod:`nrchain.potential.stretch`.
"""

from __future__ import annotations

from nrchain.effects.registry import register_effect
from nrchain.effects.shared.elasticity import ElasticTerm
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene


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
