"""Random bent and twisted chains, and small moves of one sphere, for difference quotients."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation


def random_chain(
    count: int, *, spacing: float = 2.5, bend: float = 0.5, noise: float = 0.2, seed: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """A chain along x with displaced spheres and turned frames."""
    rng = np.random.default_rng(seed)
    positions = noise * rng.standard_normal((count, 3))
    positions[:, 0] += spacing * np.arange(count)
    turns = Rotation.from_rotvec(bend * rng.standard_normal((count, 3)))
    return positions, np.ascontiguousarray(turns.as_matrix().transpose(0, 2, 1))


def moved(
    positions: np.ndarray, frames: np.ndarray, sphere: int, component: int, by: float
) -> tuple[np.ndarray, np.ndarray]:
    """The chain with one sphere displaced (components 0 to 2) or rotated in the lab (3 to 5)."""
    positions, frames = positions.copy(), frames.copy()
    if component < 3:
        positions[sphere, component] += by
    else:
        turn = np.zeros(3)
        turn[component - 3] = by
        frames[sphere] = Rotation.from_rotvec(turn).apply(frames[sphere])
    return positions, frames


def pose_derivative(function, positions: np.ndarray, frames: np.ndarray, step: float = 1e-5):
    """∂ function / ∂ (u, φ) by centred differences: shape of the function + (N, 6)."""
    columns = []
    for sphere in range(len(positions)):
        for component in range(6):
            ahead, behind = (
                np.asarray(function(*moved(positions, frames, sphere, component, sign * step)))
                for sign in (1.0, -1.0)
            )
            columns.append((ahead - behind) / (2 * step))
    stacked = np.stack(columns, axis=-1)
    return stacked.reshape(*stacked.shape[:-1], len(positions), 6)


def rigid_motion(
    positions: np.ndarray, frames: np.ndarray, seed: int = 0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The chain moved as a whole, and the rotation matrix it was turned by."""
    rng = np.random.default_rng(seed)
    turn = Rotation.from_rotvec(rng.standard_normal(3)).as_matrix()
    shift = rng.standard_normal(3)
    return positions @ turn.T + shift, np.ascontiguousarray(frames @ turn.T), turn


def dense(blocks: np.ndarray, periodic: bool) -> np.ndarray:
    """(N, 6, N, 6) from blocks (N, 2w + 1, 6, 6); blocks beyond open ends must be empty."""
    count, width = blocks.shape[:2]
    matrix = np.zeros((count, 6, count, 6))
    for i in range(count):
        for m in range(width):
            j = i + m - width // 2
            if periodic or 0 <= j < count:
                matrix[i, :, j % count] += blocks[i, m]
            else:
                assert not blocks[i, m].any()
    return matrix
