"""R(q) = I + 2 (w v^ + v^²): unit quaternions q = (w, v), the scalar first, and frames.

q turns the axes of the lab into those of the sphere: e_k = R(q) x_k. q and −q are one rotation; the
scalar is taken to be positive or 0. HOOMD has the same convention.
"""

from __future__ import annotations

import numpy as np


def quaternions_of(frames: np.ndarray) -> np.ndarray:
    """Unit quaternions (..., 4), scalar first, of frames (..., 3, 3) with rows e₁, e₂, e₃.

    Each is the largest column of 4 q qᵀ, which the rotation gives without cancellation (S. W.
    Shepperd, J. Guid. Control 1, 223 (1978)).

    >>> quaternions_of(np.eye(3))
    array([1., 0., 0., 0.])
    """
    turn = np.swapaxes(frames, -1, -2)
    products = np.empty((*turn.shape[:-2], 4, 4))
    diagonal = np.einsum("...kk->...k", turn)
    trace = diagonal.sum(axis=-1)
    products[..., 0, 0] = 1.0 + trace
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        products[..., k + 1, k + 1] = 1.0 - trace + 2.0 * diagonal[..., k]
        products[..., 0, k + 1] = products[..., k + 1, 0] = turn[..., j, i] - turn[..., i, j]
        products[..., i + 1, j + 1] = products[..., j + 1, i + 1] = (
            turn[..., i, j] + turn[..., j, i]
        )
    largest = np.einsum("...kk->...k", products).argmax(axis=-1)
    found = np.take_along_axis(products, largest[..., None, None], axis=-1)[..., 0]
    found /= np.linalg.norm(found, axis=-1, keepdims=True)
    # adding 0 turns −0 into 0
    return np.where(found[..., :1] < 0.0, -found, found) + 0.0


def frames_of(quaternions: np.ndarray) -> np.ndarray:
    """Frames (..., 3, 3) with rows e₁, e₂, e₃ of quaternions (..., 4), scalar first.

    Quaternions of any length but 0 will do: they are normalised in double precision, so that the
    frames are rotations even if the quaternions are rounded to 32 bits.

    >>> frames_of(np.array([0.5, 0.5, 0.5, 0.5]))[0]
    array([0., 1., 0.])
    """
    unit = np.asarray(quaternions, float)
    unit = unit / np.linalg.norm(unit, axis=-1, keepdims=True)
    w, v = unit[..., :1, None], unit[..., 1:]
    cross = np.zeros((*unit.shape[:-1], 3, 3))
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        cross[..., j, i], cross[..., i, j] = v[..., k], -v[..., k]
    turn = np.eye(3) + 2.0 * (w * cross + cross @ cross)
    return np.swapaxes(turn, -1, -2).copy()
