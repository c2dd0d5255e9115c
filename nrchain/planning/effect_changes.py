"""The effects that a scene could drop or add. Each is the scene with that one change.

All else of the two scenes is the same, so that whoever estimates an effect compares two scenes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

from nrchain.effects.registry import acting
from nrchain.errors import SceneError
from nrchain.notebook import record_html
from nrchain.planning.flow_keys import (
    all_pair_keys,
    finite_size_sections,
    flow_sections,
    is_all_pairs,
)
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene
from nrchain.wording import brief

Kind = Literal["drop", "add"]


@dataclass(frozen=True)
class Change:
    """An effect that a scene has and could drop, or lacks and could add.

    ``scene`` is the scene after the change.
    """

    effect: str
    kind: Kind
    scene: Scene

    __repr__ = brief
    _repr_html_ = record_html


@dataclass(frozen=True)
class Refused:
    """An effect that a scene cannot drop or add, and why."""

    effect: str
    kind: Kind
    reason: str


def possible_changes(scene: Scene) -> list[Change]:
    """Every effect of the scene that can be dropped, then those that can be added."""
    return [found for found in _changes(scene) if isinstance(found, Change)]


def refused_changes(scene: Scene) -> list[Refused]:
    """The effects that cannot be dropped or added, because the scene would not be valid."""
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


def _adds(scene: Scene) -> Iterator[tuple[str, dict[str, Any]]]:
    every = all_pair_keys(scene)
    for name, section in flow_sections(scene).items():
        key = f"{section}.neighbours"
        if key in every and not is_all_pairs(scene, getattr(scene, section).neighbours):
            yield f"{name} of all pairs", {key: "all"}
    for name, section in finite_size_sections(scene).items():
        if not getattr(scene, section).finite_size:
            yield name, {f"{section}.finite_size": True}
    if scene.friction.kind == "one-body":
        yield "friction between spheres", {"friction": "pairwise"}
