"""V = Σ_links (μ∥/2)(e₂·e₃′)²: links resist turning about e₁; primed frames are the next sphere's.

The kernels are in :mod:`nrchain.potential.twist`.
"""

from __future__ import annotations

from nrchain.effects.registry import register_effect
from nrchain.effects.shared.elasticity import ElasticTerm
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene


@register_effect
class Twist(ElasticTerm):
    """μ∥: T of twisted links."""

    name = "twist"
    key = "elasticity.twist"
    summary = "links resist turning about e₁"
    equation = "V = Σ_links (μ∥/2)(e₂·e₃′)²"

    @classmethod
    def without(cls, scene: Scene) -> Scene:
        return load_scene(scene, **{"elasticity.twist": 0.0})

    @classmethod
    def scale(cls, scene: Scene) -> float:
        """a ω of a link turned by a/d."""
        turned = scene.chain.radius / scene.chain.spacing
        return scene.moduli.twist * turned * scene.chain.radius / scene.drag.rotation
