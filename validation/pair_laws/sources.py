"""The flow of one sphere by a routine of PyStokes, by the adapter and by the native kernels.

The sphere with slip is at the origin; one sphere without slip is at each point.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import nrchain
from nrchain.hydrodynamics.pystokes import COMPONENTS
from validation.report.paper import irreducible

Array = NDArray[np.float64]

RANKS = {"2s": 2, "3a": 2, "3t": 1, "4a": 3}


def released(method: str, points: Array, axis: Array, radius: float = 1.0) -> Array:
    """Result of ``pystokes.unbounded.Rbm.<method>`` at points (M, 3) for unit strength."""
    import pystokes

    count = len(points) + 1
    rank = RANKS[method[-2:]]
    tensor = irreducible(rank, axis)
    slip = np.zeros((len(COMPONENTS[rank]), count))
    slip[:, 0] = [tensor[tuple("xyz".index(i) for i in name)] for name in COMPONENTS[rank]]
    output = np.zeros(3 * count)
    rbm = pystokes.unbounded.Rbm(radius=radius, particles=count, viscosity=1.0)
    getattr(rbm, method)(output, _centres(points).T.ravel().copy(), slip.ravel())
    return output.reshape(3, count).T[1:]


def ours(
    label: str, points: Array, axis: Array, *, backend: Any, radius: float = 1.0, **options: Any
) -> tuple[Array, Array]:
    """u/V and w/V at points (M, 3) from :func:`nrchain.active_wrenches`, by either backend."""
    count = len(points) + 1
    frames = np.broadcast_to(frame_about(axis), (count, 3, 3))
    strength = np.zeros(count)
    strength[0] = 1.0
    forces, torques = nrchain.active_wrenches(
        _centres(points),
        frames,
        {label: strength},
        neighbours="all",
        radius=radius,
        backend=backend,
        **options,
    )
    friction = 6 * np.pi * radius
    return forces[1:] / friction, torques[1:] / (friction * 4 * radius**2 / 3)


def frame_about(axis: Array) -> Array:
    """A right-handed frame (3, 3) whose first row is the axis."""
    second = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    second /= np.linalg.norm(second)
    return np.stack([axis, second, np.cross(axis, second)])


def around(axis: Array, distances: Array, angles: Array, seed: int = 0) -> Array:
    """Points (R A, 3) at all distances and angles to the axis, at random azimuths."""
    _, second, third = frame_about(axis)
    turn = np.random.default_rng(seed).uniform(0, 2 * np.pi, (len(distances), len(angles)))
    sideways = np.cos(turn)[..., None] * second + np.sin(turn)[..., None] * third
    normals = np.cos(angles)[:, None] * axis + np.sin(angles)[:, None] * sideways
    return (distances[:, None, None] * normals).reshape(-1, 3)


def _centres(points: Array) -> Array:
    return np.concatenate([np.zeros((1, 3)), points])


def fit(values: Array, law: Array, points: Array, power: int) -> tuple[float, float]:
    """(k, misfit): the multiple of the law nearest the values, and max |values − k law|/|k law|.

    Both are multiplied by r^power first, to give all distances equal weight.
    """
    v, w = flattened(values, points, power), flattened(law, points, power)
    k = float(np.sum(v * w) / np.sum(w * w))
    return k, float(np.max(np.abs(v - k * w)) / np.max(np.abs(k * w)))


def flattened(values: Array, points: Array, power: int) -> Array:
    """values · r^power."""
    return values * np.linalg.norm(points, axis=1, keepdims=True) ** power


def polar_parts(values: Array, points: Array, axis: Array) -> tuple[Array, Array]:
    """Components (M,) of vectors along n and along θ, the angle from the axis."""
    n = points / np.linalg.norm(points, axis=1, keepdims=True)
    c = (n @ axis)[:, None]
    polar = (c * n - axis) / np.sqrt(1 - c**2)
    return np.sum(values * n, axis=1), np.sum(values * polar, axis=1)
