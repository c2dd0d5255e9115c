"""Poses for the check of an effect, and a wrapper that names the method that fails."""

from __future__ import annotations

from typing import Any

import numpy as np

from nrchain.effects.base import Effect
from nrchain.errors import SceneError
from nrchain.inputs.arguments import finite_array, rotations
from nrchain.scene.scene import Scene
from nrchain.scene.unwrapping import unwrapped_chain
from nrchain.types import Poses


def given_poses(scene: Scene, positions: Any, frames: Any) -> Poses:
    points = finite_array("positions", positions, (scene.chain.particles, 3))
    points = unwrapped_chain(scene, points)
    return points, rotations(frames, len(points))


def bent_poses(scene: Scene) -> Poses:
    """The straight chain with displaced spheres and rotated frames, from a fixed seed."""
    from scipy.spatial.transform import Rotation

    count, d = scene.chain.particles, scene.chain.spacing
    random = np.random.default_rng(0)
    positions = 0.05 * d * random.standard_normal((count, 3))
    positions[:, 0] += d * np.arange(count)
    turns = Rotation.from_rotvec(0.5 * random.standard_normal((count, 3))).as_matrix()
    return positions, np.ascontiguousarray(turns.transpose(0, 2, 1))


def moved_poses(poses: Poses, sphere: int, component: int, by: float) -> Poses:
    """Displace one sphere (components 0 to 2) or rotate it in the lab (3 to 5)."""
    from scipy.spatial.transform import Rotation

    positions, frames = poses[0].copy(), poses[1].copy()
    if component < 3:
        positions[sphere, component] += by
    else:
        turn = Rotation.from_rotvec(by * np.eye(3)[component - 3])
        frames[sphere] = turn.apply(frames[sphere])
    return positions, frames


class WatchedEffect:
    """An effect whose errors name the method that fails or changes its input."""

    def __init__(self, effect: Effect, name: str) -> None:
        self._effect, self._name = effect, name

    def __getattr__(self, method: str) -> Any:
        found = getattr(self._effect, method)
        if not callable(found):
            return found

        def call(*arrays: np.ndarray) -> Any:
            given = arrays if method in ("linearise", "energy") else arrays[:-1]
            before = [array.copy() for array in given]
            key = f"effect {self._name}.{method}"
            try:
                answer = found(*arrays)
            except Exception as error:
                shapes = ", ".join(str(array.shape) for array in arrays)
                allowed = f"fails with arrays of shapes {shapes}: {error}"
                raise SceneError(key, type(error).__name__, allowed) from error
            if not all(map(np.array_equal, before, given)):
                raise SceneError(key, "changed poses", "must not change the given poses")
            return answer

        return call
