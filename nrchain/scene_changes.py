"""Which effects a scene can do without, and which it could have: each is a changed scene.

An effect is a name and two scenes, one with it and one without it; all else is the same. Whoever
estimates or chooses effects knows nothing more of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

from nrchain import slip_modes
from nrchain.effects.registry import acting
from nrchain.effects.slip import active_modes
from nrchain.scene import Scene, load_scene

Kind = Literal["drop", "add"]


@dataclass(frozen=True)
class Change:
    """An effect that a scene has and could drop, or has not and could add.

    ``scene`` is what the change makes of it.
    """

    effect: str
    kind: Kind
    scene: Scene


def changes_of(scene: Scene) -> list[Change]:
    """Every effect of the scene that can be dropped, then those that can be added."""
    drops = [Change(effect.name, "drop", effect.without(scene)) for effect in acting(scene)]
    adds = [Change(name, "add", load_scene(scene, **keys)) for name, keys in _adds(scene)]
    return drops + adds


def has_finite_size(scene: Scene) -> bool:
    """Whether the (a/r)² correction changes the flow of a mode that acts."""
    found = (slip_modes.find(label) for label in active_modes(scene))
    return any(mode.flow(True) != mode.flow(False) for mode in found)


def _adds(scene: Scene) -> Iterator[tuple[str, dict[str, Any]]]:
    near = not reaches_all(scene, scene.slip.neighbours)
    if active_modes(scene) and near and scene.can_reach_all:
        yield "slip of all pairs", {"slip.neighbours": "all"}
    if not scene.slip.finite_size and has_finite_size(scene):
        yield "finite size", {"slip.finite_size": True}
    if scene.friction.kind == "one-body":
        yield "friction between spheres", {"friction": "pairwise"}


def reaches_all(scene: Scene, neighbours: int | str) -> bool:
    """Whether a reach takes in every pair; images of periodic chains have no last one."""
    if neighbours == "all":
        return True
    return scene.chain.ends != "periodic" and int(neighbours) >= scene.chain.particles - 1
