"""Which effects a scene can do without, and which it could have: each is a changed scene.

An effect is a name and two scenes, one with it and one without it; all else is the same. Whoever
estimates or chooses effects knows nothing more of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

from nrchain.effects.registry import acting
from nrchain.effects.shared.slip_flow import active_modes
from nrchain.effects.strain import Strain
from nrchain.errors import SceneError
from nrchain.hydrodynamics import slip_modes
from nrchain.scene.scene import CHOSEN, Scene, load_scene
from nrchain.wording import brief

Kind = Literal["drop", "add"]


@dataclass(frozen=True)
class Change:
    """An effect that a scene has and could drop, or has not and could add.

    ``scene`` is what the change makes of it.
    """

    effect: str
    kind: Kind
    scene: Scene

    __repr__ = brief


@dataclass(frozen=True)
class Refused:
    """An effect that a scene cannot drop or add, and why."""

    effect: str
    kind: Kind
    reason: str


def changes_of(scene: Scene) -> list[Change]:
    """Every effect of the scene that can be dropped, then those that can be added."""
    return [found for found in _changes(scene) if isinstance(found, Change)]


def refused_changes(scene: Scene) -> list[Refused]:
    """The effects that could be dropped or added, were the scene not refused then."""
    return [found for found in _changes(scene) if isinstance(found, Refused)]


def _changes(scene: Scene) -> Iterator[Change | Refused]:
    for effect in acting(scene):
        yield _changed(effect.name, "drop", partial(effect.without, scene))
    for name, keys in _adds(scene):
        yield _changed(name, "add", partial(load_scene, scene, **keys))


def _changed(effect: str, kind: Kind, make: Callable[[], Scene]) -> Change | Refused:
    try:
        return Change(effect, kind, make())
    except SceneError as error:
        return Refused(effect, kind, str(error))


def has_finite_size(scene: Scene) -> bool:
    """Whether the (a/r)² correction changes the flow of a mode that acts."""
    found = (slip_modes.find(label) for label in active_modes(scene))
    return any(mode.flow(True) != mode.flow(False) for mode in found)


def reaching(scene: Scene) -> dict[str, str]:
    """The flows between spheres that a scene has, by name, and the section that has their reach."""
    found = {"slip": "slip"} if active_modes(scene) else {}
    return found | ({"strain": "flow"} if Strain.acts(scene) else {})


def sized(scene: Scene) -> dict[str, str]:
    """Those of them that (a/r)² corrects, by the name of the correction, and its section."""
    found = {"finite size": "slip"} if has_finite_size(scene) else {}
    return found | ({"finite size of strain": "flow"} if Strain.acts(scene) else {})


def reach_keys(scene: Scene) -> list[str]:
    """The keys of the reaches of a scene's flows."""
    return [f"{section}.neighbours" for section in reaching(scene).values()]


def all_pairs(scene: Scene) -> dict[str, Any]:
    """The keys that give every flow of a scene all pairs; without a flow that has no such sum."""
    keys = reach_keys(scene)
    return {key: "all" for key in keys if key != "slip.neighbours" or scene.can_reach_all}


def all_sizes(scene: Scene) -> dict[str, Any]:
    """The keys that give every flow of a scene its finite size."""
    return {f"{section}.finite_size": True for section in sized(scene).values()}


def keys_that_differ(scene: Scene, other: Scene) -> list[tuple[str, Any, Any]]:
    """The keys that effects = "auto" decides and in which two scenes differ: key, old, new."""
    sections = ((getattr(scene, path), getattr(other, path), path) for path in CHOSEN)
    return [
        (old.key(name), getattr(old, name), getattr(new, name))
        for old, new, path in sections
        for name in CHOSEN[path]
        if getattr(old, name) != getattr(new, name)
    ]


def _adds(scene: Scene) -> Iterator[tuple[str, dict[str, Any]]]:
    every = all_pairs(scene)
    for name, section in reaching(scene).items():
        key = f"{section}.neighbours"
        if key in every and not reaches_all(scene, getattr(scene, section).neighbours):
            yield f"{name} of all pairs", {key: "all"}
    for name, section in sized(scene).items():
        if not getattr(scene, section).finite_size:
            yield name, {f"{section}.finite_size": True}
    if scene.friction.kind == "one-body":
        yield "friction between spheres", {"friction": "pairwise"}


def reaches_all(scene: Scene, neighbours: int | str) -> bool:
    """Whether a reach takes in every pair; images of periodic chains have no last one."""
    if neighbours == "all":
        return True
    return scene.chain.ends != "periodic" and int(neighbours) >= scene.chain.particles - 1
