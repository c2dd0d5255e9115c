"""Σ_m m^−s over the images of an infinite chain: which flows have a sum.

The flow of a force decays as 1/r. Its sum over all images of a periodic chain diverges unless the
forces of a period sum to zero. Cut at a number of neighbours, every flow has a sum.
"""

from __future__ import annotations

from nrchain.effects.base import Effect
from nrchain.effects.registry import acting
from nrchain.errors import SceneError
from nrchain.scene.scene import Scene

LARGEST_REACH = 100_000
"""Largest number of neighbours that are summed one by one on a periodic chain."""


def net_forces(scene: Scene) -> list[type[Effect]]:
    """The acting effects whose forces do not sum to zero."""
    forces = (effect for effect in acting(scene) if effect.gives == "wrench")
    return [effect for effect in forces if not effect.balanced(scene)]


def refuse_net_forces(scene: Scene) -> None:
    """Refuse friction between all spheres of a periodic chain under a net force."""
    friction = scene.friction
    pairs = friction.kind == "pairwise" and friction.neighbours == "all"
    if scene.chain.ends != "periodic" or not pairs:
        return
    for effect in net_forces(scene):
        has, otherwise = "has", ""
        if not effect.states_balance():
            has = "may have"
            otherwise = f"; if its forces sum to zero, define {effect.__name__}.balanced"
        allowed = (
            f"{has} a net force, whose flow over all images of a periodic chain has no sum: name a"
            " number for friction.neighbours, or choose friction = 'one-body', or free or clamped"
            f" ends{otherwise}"
        )
        raise SceneError(effect.key, effect.value(scene), allowed)


def has_sum(scene: Scene, key: str) -> bool:
    """Whether the sum that a key such as ``slip.neighbours`` cuts converges over all pairs."""
    if key == "flow.neighbours":  # stresslets: their flow decays as 1/r²
        return True
    return scene.slip_has_sum if key == "slip.neighbours" else not net_forces(scene)


def takes_all(scene: Scene) -> bool:
    """Whether friction between all spheres has a sum in this scene."""
    return scene.chain.ends != "periodic" or not net_forces(scene)


def refuse_reach(scene: Scene, key: str, neighbours: int | str, most: int = LARGEST_REACH) -> None:
    """Refuse more than ``most`` neighbours on a periodic or infinite chain."""
    if neighbours == "all" or int(neighbours) <= most:
        return
    allowed = f"must be at most {most} on a periodic or infinite chain, summed one by one"
    if has_sum(scene, key):
        allowed += "; use 'all' for the sum over all pairs"
    raise SceneError(key, neighbours, allowed)
