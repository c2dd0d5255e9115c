"""The scenes of the map and their classes: shipped scenes, gallery, random scenes."""

from __future__ import annotations

from typing import Any

from nrchain import Scene, load_scene, scene_names
from nrchain.motion.model import Model
from validation.report.gallery import COMPLETED, GALLERY
from validation.report.random_scenes import random_scene

SNAPSHOTS = 21
RANDOM = 40

SHORTENED: dict[str, dict[str, float]] = {
    "a bent chain turns through 10⁴ rad": {"run.end": 50.0},
    "far past buckling": {"run.end": 2000.0},
}
"""Scenes that run to an earlier time than their own."""

LEFT_OUT = (
    "N = 10⁴",  # too large
    "N = 10⁵",
    "tolerances of 1e-13",  # another case, at tolerances of its own
    "a loaded column, bent by 1e-5 a, at 1e-10",  # refused at larger tolerances
    "frames turn through 10⁴ rad",  # a straight chain in charts that turn with it: no error
    "amplitude 1e-12 a",  # moves by less than every tolerance
)
"""Cases of the gallery that are not in the map."""

QUICK = (
    "buckling",
    "wave",
    "N = 3",
    "all four modes",
    *(f"random {k}" for k in (0, 3, 9, 17, 23)),
)
"""Scenes of a quick run."""

NEAR, FAR = "near neighbours", "all pairs"
CLASSES = (
    "all scenes",
    NEAR,
    FAR,
    "free",
    "clamped",
    "periodic",
    "one-body friction",
    "pairwise friction",
    "background flow",
)


def scenes() -> dict[str, Scene]:
    """All scenes by name; they differ from their sources in snapshots, and in some ends."""
    found = {name: load_scene(name) for name in scene_names()}
    for case in GALLERY:
        if case.ends == (COMPLETED,) and case.name not in LEFT_OUT:
            scene = case.scene()
            positions, frames = case.start(scene)
            start = {"shape": "given", "positions": positions, "frames": frames}
            found[case.name] = load_scene(scene, start=start)
    found |= {f"random {seed}": random_scene(seed) for seed in range(RANDOM)}
    return {name: _shortened(name, scene) for name, scene in found.items()}


def _shortened(name: str, scene: Scene) -> Scene:
    changes: dict[str, Any] = {"run.snapshots": SNAPSHOTS, **SHORTENED.get(name, {})}
    return load_scene(scene, **changes)


def classes(scene: Scene) -> tuple[str, ...]:
    """The classes that a scene belongs to: by reach, ends, friction and flow."""
    found = [
        CLASSES[0],
        NEAR if is_near(scene) else FAR,
        scene.chain.ends,
        f"{scene.friction.kind} friction",
    ]
    if any(any(row) for row in scene.flow.gradient):
        found.append("background flow")
    return tuple(found)


def is_near(scene: Scene) -> bool:
    """Whether every sum over pairs has a finite reach, so that the Jacobian is banded."""
    return Model(scene).is_near
