"""Arrays that public functions are given: numbers of a shape, and frames that are rotations."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from nrchain.errors import SceneError
from nrchain.geometry import lie

ORTHONORMAL = 1e-8
"""How far the products of frame vectors may be from 0 and 1 for frames to be taken as they are."""

SINGLE = 1e-6
"""How far they may be for the nearest rotations to be taken: several roundings of 32 bits."""

Shape = tuple[int | None, ...]
"""Sizes of an array; None stands for any, which messages call N."""


def finite_array(name: str, given: Any, shape: Shape | None = None) -> np.ndarray:
    """The C-contiguous floats of that shape (None: of any), or a SceneError that names them.

    Truth values and text are not numbers here, even where NumPy would make numbers of them.
    """
    words = "numbers" if shape is None else f"numbers of shape {_named(shape)}"
    try:
        array = np.asarray(given)
    except (TypeError, ValueError):
        raise SceneError(name, given, f"must be {words}") from None
    if array.dtype.kind not in "iuf":
        raise SceneError(name, given, f"must be {words}")
    sizes = zip(shape or array.shape, array.shape, strict=False)
    matches = shape is None or array.ndim == len(shape)
    if not matches or any(want not in (None, have) for want, have in sizes):
        raise SceneError(name, array.shape, f"the shape must be {_named(shape or ())}")
    array = np.asarray(array, float, order="C")
    if not np.isfinite(array).all():
        raise SceneError(name, "NaN or inf", "all numbers must be finite")
    return array


def rotations(given: Any, count: int, *, to: float = SINGLE, key: str = "frames") -> np.ndarray:
    """Frames (N, 3, 3) whose rows are orthonormal and right-handed, or a SceneError.

    Frames that are so to :data:`ORTHONORMAL` are returned as they are, and of those that are so
    ``to`` more, by default the rounding of 32 bits, the nearest rotations.
    """
    frames = finite_array(key, given, (count, 3, 3))
    off = _off_rotation(frames)
    worst = float(off.max(initial=0.0))
    if worst <= ORTHONORMAL:
        return frames
    if worst <= to:
        frames = frames.copy()
        lie.orthonormalise(frames)
        return frames
    sphere = int(np.argmax(off))
    far = f"are off by {worst:.2g}" if math.isfinite(worst) else "are left-handed"
    raise SceneError(
        f"{key}[{sphere}]",
        frames[sphere].tolist(),
        f"rows must be orthonormal and right-handed to {to:g}, and {far};"
        " scipy.spatial.transform.Rotation.from_matrix(frames).as_matrix() gives the nearest"
        " rotations of right-handed frames",
    )


def _off_rotation(frames: np.ndarray) -> np.ndarray:
    """(N,) the largest of |e_a·e_b − δ_ab| of each frame, infinite for a left-handed one."""
    with np.errstate(all="ignore"):
        gram = np.einsum("nak,nbk->nab", frames, frames)
        off = np.abs(gram - np.eye(3)).max(axis=(1, 2), initial=0.0)
        mirrored = (off <= 1.0) & (np.linalg.det(frames) < 0.0)
    return np.where(mirrored | np.isnan(off), np.inf, off)


def _named(shape: Shape) -> str:
    return "(" + ", ".join("N" if size is None else str(size) for size in shape) + ")"
