"""Long chains in several shapes, for sums over all pairs."""

from __future__ import annotations

import numpy as np

PERSISTENCE = 20
"""Links over which a walk forgets its direction."""


def straight(rng, count, spacing):
    """Along x."""
    return spacing * np.arange(count)[:, None] * np.array([1.0, 0.0, 0.0])


def coil(rng, count, spacing):
    """A helix of 60 turns or fewer, whose turns are four spacings apart."""
    radius, rise = 6.0 * spacing, 4.0 * spacing
    angle = spacing * np.arange(count) / np.hypot(radius, rise / (2 * np.pi))
    along = rise * angle / (2 * np.pi)
    return np.stack([along, radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def walk(rng, count, spacing):
    """A random walk whose direction diffuses; it crosses itself."""
    direction, steps = np.array([1.0, 0.0, 0.0]), np.empty((count, 3))
    for step in steps:
        direction = direction + rng.normal(size=3) / np.sqrt(PERSISTENCE)
        direction /= np.linalg.norm(direction)
        step[:] = direction
    return spacing * np.cumsum(steps, axis=0)


def folded(rng, count, spacing):
    """There and back again: sphere i lies beside sphere N − 1 − i."""
    half = np.minimum(np.arange(count), np.arange(count)[::-1])
    positions = spacing * half[:, None] * np.array([0.6, 0.0, 0.8])
    positions[count // 2 :, 1] = spacing
    return positions


SHAPES = {"straight": straight, "coil": coil, "walk": walk, "folded": folded}


def long_chain(shape, count, *, spacing=10.0, seed=0):
    """Positions (N, 3) of a shape, and frames whose e_1 is nearly along the chain."""
    rng = np.random.default_rng(seed)
    positions = SHAPES[shape](rng, count, spacing)
    tangent = np.gradient(positions, axis=0)
    tangent += 0.2 * spacing * rng.normal(size=tangent.shape)
    frames = np.empty((count, 3, 3))
    frames[:, 0] = tangent / np.linalg.norm(tangent, axis=1)[:, None]
    across = np.cross(frames[:, 0], rng.normal(size=(count, 3)))
    frames[:, 1] = across / np.linalg.norm(across, axis=1)[:, None]
    frames[:, 2] = np.cross(frames[:, 0], frames[:, 1])
    return positions, frames
