"""u = −(4a⁵/3) ∇(x·E·x/r⁵), w = 0: finite size of spheres in a strain.

The correction by (1 + a²∇²/6)(1 + a²∇²/10) to the flow of the effect ``strain``: the second factor
turns a stresslet into the flow about a sphere, the first is Faxén's, for the sphere that feels it.
It is smaller by (a/r)². It is a potential flow and rotates no sphere.
"""

from __future__ import annotations

from nrchain.effects.flow import Flow
from nrchain.effects.registry import register_effect
from nrchain.effects.strain import DisturbanceEffect, Strain
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene


@register_effect
class FiniteSizeOfStrain(DisturbanceEffect):
    """The finite-size correction of the disturbance of a background flow."""

    name = "finite size of strain"
    key = "flow.finite_size"
    summary = "(a/r)² in the velocity by which rigid spheres disturb a background flow"
    equation = "u = −(4a⁵/3) ∇(x·E·x/r⁵), w = 0"
    part = "finite size"
    example = Flow.example | {"flow.finite_size": True}

    @classmethod
    def acts(cls, scene: Scene) -> bool:
        return Flow.section(scene).finite_size and Strain.acts(scene)

    @classmethod
    def without(cls, scene: Scene) -> Scene:
        return load_scene(scene, **{cls.key: False})

    @classmethod
    def scale(cls, scene: Scene) -> float:
        """One neighbour at d, along the line: 4 (a/d)⁵ |E| d."""
        return cls.at_spacing(scene, 4.0, 5)
