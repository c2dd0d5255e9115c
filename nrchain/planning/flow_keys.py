"""The scene keys that set the reach and the finite size of the flows between spheres."""

from __future__ import annotations

from typing import Any

from nrchain.effects.shared.slip_flow import active_modes
from nrchain.effects.strain import Strain
from nrchain.hydrodynamics import slip_modes
from nrchain.scene.scene import Scene


def has_finite_size(scene: Scene) -> bool:
    """Whether the (a/r)² correction changes the flow of a mode that acts."""
    found = (slip_modes.find(label) for label in active_modes(scene))
    return any(mode.flow(True) != mode.flow(False) for mode in found)


def flow_sections(scene: Scene) -> dict[str, str]:
    """The flows between spheres in a scene, by name, with the section that sets their reach."""
    found = {"slip": "slip"} if active_modes(scene) else {}
    return found | ({"strain": "flow"} if Strain.acts(scene) else {})


def finite_size_sections(scene: Scene) -> dict[str, str]:
    """The (a/r)² corrections that its flows may have, by name, with the section that sets them."""
    found = {"finite size": "slip"} if has_finite_size(scene) else {}
    return found | ({"finite size of strain": "flow"} if Strain.acts(scene) else {})


def reach_keys(scene: Scene) -> list[str]:
    """The keys that set the reach of each flow of a scene."""
    return [f"{section}.neighbours" for section in flow_sections(scene).values()]


def all_pair_keys(scene: Scene) -> dict[str, Any]:
    """The keys by which every flow of a scene acts between all pairs, if it has such a sum."""
    keys = reach_keys(scene)
    return {key: "all" for key in keys if key != "slip.neighbours" or scene.can_reach_all}


def finite_size_keys(scene: Scene) -> dict[str, Any]:
    """The keys that give every flow of a scene its finite size."""
    return {f"{section}.finite_size": True for section in finite_size_sections(scene).values()}


def differing_keys(scene: Scene, other: Scene) -> list[tuple[str, Any, Any]]:
    """(key, old, new value) of the keys set by effects = "auto" in which two scenes differ."""
    paths = dict.fromkeys(("slip", *scene.further, *other.further, "friction"))
    sections = ((getattr(scene, path), getattr(other, path)) for path in paths)
    return [
        (old.key(name), getattr(old, name), getattr(new, name))
        for old, new in sections
        for name in old.set_by_auto
        if getattr(old, name) != getattr(new, name)
    ]


def is_all_pairs(scene: Scene, neighbours: int | str) -> bool:
    """Whether a reach includes every pair. On a periodic chain only 'all' does."""
    if neighbours == "all":
        return True
    return scene.chain.ends != "periodic" and int(neighbours) >= scene.chain.particles - 1
