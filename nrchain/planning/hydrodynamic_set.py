"""Which of the hydrodynamics between spheres a scene simulates: what ``effects = "auto"`` sets."""

from __future__ import annotations

import math
from typing import Any, NamedTuple, Self

from nrchain.planning.flow_keys import finite_size_sections, flow_sections
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene


class HydrodynamicSet(NamedTuple):
    """How far the flows between spheres reach, and whether they have a finite size.

    ``friction``, ``slip`` and ``strain`` are the reaches, in neighbours on each side, of friction
    between spheres, of the slip flows and of the disturbance of a background flow: infinite for all
    pairs, 0 for none. ``finite_size`` is whether any of the flows has its (a/r)² correction.
    """

    friction: float
    slip: float
    strain: float
    finite_size: bool

    @classmethod
    def of_scene(cls, scene: Scene) -> Self:
        """The set that a scene simulates."""
        friction = scene.friction
        places = _number(friction.neighbours) if friction.kind == "pairwise" else 0.0
        reaches = {
            name: _number(getattr(scene, section).neighbours)
            for name, section in flow_sections(scene).items()
        }
        size = any(
            getattr(scene, section).finite_size for section in finite_size_sections(scene).values()
        )
        return cls(places, reaches.get("slip", 0.0), reaches.get("strain", 0.0), size)

    def contains(self, other: HydrodynamicSet) -> bool:
        """Whether this set simulates all that ``other`` does."""
        return all(a >= b for a, b in zip(self, other, strict=True))

    def apply_to(self, scene: Scene) -> Scene:
        """The scene with this set in place of its own."""
        changes: dict[str, Any] = {
            "friction.kind": "pairwise" if self.friction else "one-body",
            "friction.neighbours": _neighbours(self.friction or math.inf),
        }
        for name, section in flow_sections(scene).items():
            changes[f"{section}.neighbours"] = _neighbours(getattr(self, name))
        for section in finite_size_sections(scene).values():
            changes[f"{section}.finite_size"] = self.finite_size
        return load_scene(scene, **changes)


def _number(neighbours: int | str) -> float:
    return math.inf if neighbours == "all" else float(neighbours)


def _neighbours(number: float) -> int | str:
    return "all" if math.isinf(number) else int(number)
