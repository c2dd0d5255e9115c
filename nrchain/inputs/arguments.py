"""Array arguments of public functions: numbers of a given shape, and frames."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from nrchain.errors import SceneError
from nrchain.geometry import lie

ORTHONORMAL = 1e-8
"""Largest error of e_a·e_b at which frames are used unchanged."""

SINGLE = 1e-6
"""Largest error of e_a·e_b that is corrected: several roundings of 32-bit floats."""

Shape = tuple[int | None, ...]
"""Sizes of an array; None is any size, N in messages."""


def finite_array(name: str, given: Any, shape: Shape | None = None) -> np.ndarray:
    """C-contiguous finite floats of a shape (None: of any shape); SceneError names the argument.

    Booleans and text are refused, even if NumPy can convert them to numbers.
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
    """Frames (N, 3, 3) with orthonormal, right-handed rows; SceneError for others.

    Frames with errors up to :data:`ORTHONORMAL` are returned unchanged. Errors up to ``to``, by
    default the rounding of 32-bit floats, are corrected to the nearest rotations.
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
    """(N,) max |e_a·e_b − δ_ab| of each frame; infinite for a left-handed frame."""
    with np.errstate(all="ignore"):
        gram = np.einsum("nak,nbk->nab", frames, frames)
        off = np.abs(gram - np.eye(3)).max(axis=(1, 2), initial=0.0)
        mirrored = (off <= 1.0) & (np.linalg.det(frames) < 0.0)
    return np.where(mirrored | np.isnan(off), np.inf, off)


def _named(shape: Shape) -> str:
    return "(" + ", ".join("N" if size is None else str(size) for size in shape) + ")"
