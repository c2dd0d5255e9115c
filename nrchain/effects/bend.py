"""V = Σ_links (μ⊥/2)[(e₁·e₂′)² + (e₃·e₁′)²]: links resist bending; primed frames are the next's.

The kernels are in :mod:`nrchain.potential.bend`.
"""

from __future__ import annotations

from nrchain.effects.registry import register_effect
from nrchain.effects.shared.elasticity import ElasticTerm
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene


@register_effect
class Bend(ElasticTerm):
    """μ⊥: T of bent links."""

    name = "bend"
    key = "elasticity.bend"
    summary = "links resist bending"
    equation = "V = Σ_links (μ⊥/2)[(e₁·e₂′)² + (e₃·e₁′)²]"

    @classmethod
    def without(cls, scene: Scene) -> Scene:
        stretch, shear, twist, _ = scene.moduli
        changes = {"ratio": None, "stretch": stretch, "shear": shear, "twist": twist, "bend": 0.0}
        return load_scene(scene, elasticity=changes)

    @classmethod
    def scale(cls, scene: Scene) -> float:
        """The larger of v and a ω of a link bent by a/d, whose moment bonds of length d carry."""
        a, d = scene.chain.radius, scene.chain.spacing
        moment = scene.moduli.bend * a / d
        return max(moment / (d * scene.drag.translation), moment * a / scene.drag.rotation)
