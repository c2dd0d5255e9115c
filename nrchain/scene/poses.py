"""r_i = (i d, y(i d), z(i d)): the positions and frames of each shape of a start.

Frames follow the curve: e₁ is its tangent. e₂ and e₃ are turned from the lab axes by the smallest
rotation that takes x to e₁, so that a start of small slope carries no twist. (The Frenet–Serret
frame that the paper names flips at the inflections of a sine and turns about e₁ along a helix.)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from nrchain.scene.scene import Scene


def initial_poses(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Positions (N, 3) and frames (N, 3, 3) that the scene starts from."""
    positions, frames = _shaped_poses(scene)
    start = scene.start
    if start.positions is not None:
        positions = start.positions.values.copy()
    if start.frames is not None:
        frames = start.frames.values.copy()
    return positions, frames


def _shaped_poses(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """The poses of the shape; those of the straight chain if the shape is ``given``."""
    count = scene.chain.particles
    x = scene.chain.spacing * np.arange(count)
    amplitude, q = scene.start.amplitude, scene.wavevector
    offsets, slopes = np.zeros((count, 2)), np.zeros((count, 2))
    shape = scene.start.shape
    if shape == "sine":
        offsets[:, 0], slopes[:, 0] = amplitude * np.sin(q * x), amplitude * q * np.cos(q * x)
    elif shape in ("helix-right", "helix-left"):
        hand = 1.0 if shape == "helix-right" else -1.0
        offsets[:] = amplitude * np.stack([np.cos(q * x), hand * np.sin(q * x)], axis=1)
        slopes[:] = amplitude * q * np.stack([-np.sin(q * x), hand * np.cos(q * x)], axis=1)
    elif shape == "random":
        offsets, slopes = _random_offsets(scene, count)
    tangents = np.column_stack([np.ones(count), slopes])
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    return np.column_stack([x, offsets]), frames_along(tangents)


def _random_offsets(scene: Scene, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Independent normal offsets of that amplitude, and their slopes by centred differences."""
    rng = np.random.default_rng(scene.start.seed)
    offsets = scene.start.amplitude * rng.standard_normal((count, 2))
    if scene.chain.ends == "periodic":
        neighbours = np.roll(offsets, -1, axis=0) - np.roll(offsets, 1, axis=0)
        return offsets, neighbours / (2.0 * scene.chain.spacing)
    if scene.chain.ends == "clamped":
        offsets[0] = offsets[-1] = 0.0
    slopes, spacing = np.empty_like(offsets), scene.chain.spacing
    slopes[1:-1] = (offsets[2:] - offsets[:-2]) / (2.0 * spacing)
    slopes[0] = (offsets[1] - offsets[0]) / spacing
    slopes[-1] = (offsets[-1] - offsets[-2]) / spacing
    if scene.chain.ends == "clamped":
        slopes[0] = slopes[-1] = 0.0
    return offsets, slopes


def frames_along(tangents: np.ndarray) -> np.ndarray:
    """Frames (N, 3, 3) with e₁ = ``tangents`` (N, 3): the smallest rotations of the lab axes.

    With a unit tangent t, e₂ = (−t_y, 1 − t_y²/(1 + t_x), −t_y t_z/(1 + t_x)), and e₃ likewise.
    They are singular only for a tangent against x.
    """
    x, y, z = np.transpose(tangents)
    frames = np.empty((len(tangents), 3, 3))
    frames[:, 0] = tangents
    frames[:, 1, 0], frames[:, 2, 0] = -y, -z
    frames[:, 1, 1], frames[:, 2, 2] = 1.0 - y * y / (1.0 + x), 1.0 - z * z / (1.0 + x)
    frames[:, 1, 2] = frames[:, 2, 1] = -y * z / (1.0 + x)
    return frames
