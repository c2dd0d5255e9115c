"""Poses from which runs start: as in the scene, random, in a plane, or wound.

Several starts at a point show whether more than one attractor is stable there.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from nrchain.errors import SceneError
from nrchain.scene.loading import load_scene
from nrchain.scene.poses import frames_along, initial_poses
from nrchain.scene.scene import Scene
from nrchain.types import Poses

STARTS = ("random", "planar", "helix-right")
"""The starts of a diagram, unless others are asked for."""

SEEDED, PLAIN = ("random", "planar"), ("scene", "helix-left", "helix-right")

OUT_OF_PLANE = 1e-3
"""What is left of z in a planar start."""


def read_starts(given: Any) -> tuple[str, ...]:
    """The names of starts; raise :class:`~nrchain.errors.SceneError` for others."""
    if isinstance(given, str):
        given = (given,)
    names = tuple(given) if isinstance(given, Iterable) else ()
    if not names or len(set(names)) < len(names):
        raise SceneError("starts", given, "must be one start or several different ones")
    for name in names:
        _split(name)
    return names


def _split(name: Any) -> tuple[str, int]:
    """The shape of a start and its seed."""
    if isinstance(name, str):
        shape, colon, seed = name.partition(":")
        if shape in PLAIN and not colon:
            return shape, 0
        if shape in SEEDED and (not colon or seed.isdecimal()):
            return shape, int(seed or 0)
    allowed = f"must be among {', '.join((*SEEDED, *PLAIN))}; a seed follows, as in random:3"
    raise SceneError("starts", name, allowed)


def start_poses(scene: Scene, name: str) -> Poses:
    """Positions (N, 3) and frames (N, 3, 3) of a start; its size is ``start.amplitude``.

    ``random`` is the random shape of a scene. ``planar`` is the same with z a thousandth as large:
    a chain that grows out of the plane can leave it. A helix winds once along the chain; that of a
    clamped chain fades out at both ends, like sin²(πs/L).
    """
    shape, seed = _split(name)
    if shape == "scene":
        return initial_poses(scene)
    if shape in SEEDED:
        start = {"shape": "random", "seed": seed, "amplitude": abs(scene.start.amplitude)}
        none = {"positions": None, "frames": None}
        positions, frames = initial_poses(load_scene(scene, start=start | none))
        if shape == "random":
            return positions, frames
        positions[:, 2] *= OUT_OF_PLANE
        return positions, frames_along(_unit(frames[:, 0] * [1.0, 1.0, OUT_OF_PLANE]))
    return _helix(scene, 1.0 if shape == "helix-right" else -1.0)


def _helix(scene: Scene, hand: float) -> Poses:
    """A helix of one turn along the chain."""
    count, spacing = scene.chain.particles, scene.chain.spacing
    x = spacing * np.arange(count)
    angle = 2.0 * math.pi * x / scene.length
    envelope = scene.start.amplitude * np.ones(count)
    slope = np.zeros(count)
    if scene.chain.ends == "clamped":
        envelope = scene.start.amplitude * np.sin(0.5 * angle) ** 2
        slope = scene.start.amplitude * math.pi / scene.length * np.sin(angle)
        envelope[-1] = slope[-1] = 0.0
    wave = np.stack([np.cos(angle), hand * np.sin(angle)], axis=1)
    turned = np.stack([-np.sin(angle), hand * np.cos(angle)], axis=1)
    rate = 2.0 * math.pi / scene.length
    slopes = slope[:, None] * wave + rate * envelope[:, None] * turned
    tangents = _unit(np.column_stack([np.ones(count), slopes]))
    return np.column_stack([x, envelope[:, None] * wave]), frames_along(tangents)


def _unit(vectors: np.ndarray) -> np.ndarray:
    scaled: np.ndarray = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    return scaled
