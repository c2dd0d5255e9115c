"""Σ_{|i−j| > 1} (u, w)(r_i − r_j, e_j): the slip flows of spheres beyond the nearest neighbours."""

from __future__ import annotations

from nrchain.effects.base import Cost
from nrchain.effects.registry import register_effect
from nrchain.effects.shared.image_sums import refuse_reach
from nrchain.effects.shared.slip_flow import (
    FlowEffect,
    active_modes,
    make_flow,
    mode_scale,
    pairs_within,
    reach_text,
)
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene


@register_effect
class Reach(FlowEffect):
    """The slip flows of second and farther neighbours, with their finite size."""

    name = "reach"
    key = "slip.neighbours"
    summary = "slip flows of spheres beyond the nearest neighbours"
    equation = "Σ_{|i−j| > 1} (u, w)(r_i − r_j, e_j)"
    example = {"slip.2s": 100.0, "slip.neighbours": 3}  # noqa: RUF012

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self._set(lambda: make_flow(scene), lambda: make_flow(scene, 1))

    @classmethod
    def acts(cls, scene: Scene) -> bool:
        chain, neighbours = scene.chain, scene.slip.neighbours
        exist = chain.particles > 2 or chain.ends == "periodic"
        return neighbours != 1 and exist and bool(active_modes(scene))

    @classmethod
    def check(cls, scene: Scene) -> None:
        if scene.chain.ends == "periodic":
            refuse_reach(scene, cls.key, scene.slip.neighbours)

    @classmethod
    def without(cls, scene: Scene) -> Scene:
        return load_scene(scene, **{cls.key: 1})

    @classmethod
    def detail(cls, scene: Scene) -> str:
        return f"slip flows of {reach_text(scene.slip.neighbours)}"

    @classmethod
    def cost(cls, scene: Scene) -> Cost:
        return Cost(pairs_within(scene, scene.slip.neighbours) - pairs_within(scene, 1), "pairs")

    @classmethod
    def scale(cls, scene: Scene) -> float:
        """Second neighbours of the straight chain, on both sides."""
        d = 2.0 * scene.chain.spacing
        return 2.0 * sum(mode_scale(scene, label, d) for label in active_modes(scene))
