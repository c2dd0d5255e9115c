"""Σ_m m^−s over the images of an endless chain: which flows have one, and which are refused.

The flow of a force falls off as 1/r. Summed over all images of a periodic chain it has no limit,
unless the forces of a period add up to nothing. Felt by a number of neighbours, every flow has a
sum.
"""

from __future__ import annotations

from nrchain.effects.base import Effect
from nrchain.effects.registry import acting
from nrchain.errors import SceneError
from nrchain.scene.scene import Scene

LARGEST_REACH = 100_000
"""Places along a periodic chain that are summed one by one: its images have no last one."""


def net_forces(scene: Scene) -> list[type[Effect]]:
    """What acts on the spheres with forces that do not add up to nothing."""
    forces = (effect for effect in acting(scene) if effect.gives == "wrench")
    return [effect for effect in forces if not effect.balanced(scene)]


def refuse_net_forces(scene: Scene) -> None:
    """Refuse friction between all spheres of a periodic chain that a net force drags along."""
    friction = scene.friction
    pairs = friction.kind == "pairwise" and friction.neighbours == "all"
    if scene.chain.ends != "periodic" or not pairs:
        return
    for effect in net_forces(scene):
        has, otherwise = "has", ""
        if not effect.states_balance():
            has = "may have"
            otherwise = f"; if its forces add up to nothing, let {effect.__name__}.balanced say so"
        allowed = (
            f"{has} a net force, whose flow over all images of a periodic chain has no sum: name a"
            " number for friction.neighbours, or choose friction = 'one-body', or free or clamped"
            f" ends{otherwise}"
        )
        raise SceneError(effect.key, effect.detail(scene), allowed)


def has_sum(scene: Scene, key: str) -> bool:
    """Whether what a key such as ``slip.neighbours`` cuts has a sum without end."""
    if key == "flow.neighbours":  # stresslets, whose flow falls off as 1/r²
        return True
    return scene.slip_has_sum if key == "slip.neighbours" else not net_forces(scene)


def takes_all(scene: Scene) -> bool:
    """Whether the scene may have friction between all its spheres."""
    return scene.chain.ends != "periodic" or not net_forces(scene)


def refuse_reach(scene: Scene, key: str, neighbours: int | str, most: int = LARGEST_REACH) -> None:
    """Refuse more than ``most`` neighbours, to be summed one by one on an endless chain."""
    if neighbours == "all" or int(neighbours) <= most:
        return
    allowed = f"must be at most {most} on a periodic or endless chain, summed one by one"
    if has_sum(scene, key):
        allowed += "; name 'all' for the sum of all"
    raise SceneError(key, neighbours, allowed)
