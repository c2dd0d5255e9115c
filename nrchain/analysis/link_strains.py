"""Stretch, shear, bend and twist of every link of a chain, as the elastic energy measures them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from nrchain.scene.scene import Scene
from nrchain.scene.unwrapping import unwrapped_chain

_WIDE, _NARROW = (-1 / 16, 9 / 16, 1 / 24, 27 / 24), (0.0, 0.5, 0.0, 1.0)
"""Weights of four spheres and of two: frames of outer and inner, tangents of outer and inner."""


class LinkStrains(NamedTuple):
    """The strains of every link, (…, L) each.

    Attributes
    ----------
    stretch
        C⁰e₁·C¹r − 1, signed, without unit.
    shear
        √((C⁰e₂·C¹r)² + (C⁰e₃·C¹r)²), without unit.
    bend, twist
        The angle by which the frame turns over the link across e₁, and, signed, about e₁; over d,
        in 1/length.
    """

    stretch: np.ndarray
    shear: np.ndarray
    bend: np.ndarray
    twist: np.ndarray


def link_strains(scene: Scene, positions: np.ndarray, frames: np.ndarray) -> LinkStrains:
    """The strains of the links between positions (…, N, 3) with frames (…, N, 3, 3).

    C⁰ and C¹ are the stencils of the elastic energy (paper, Appendix B): over four spheres, and
    over two at the ends of an open chain. The last link of a periodic chain closes it.
    """
    spacing = scene.chain.spacing
    r, e = unwrapped_chain(scene, positions), np.asarray(frames)
    if periodic := scene.chain.ends == "periodic":
        period = np.array([scene.length, 0.0, 0.0])
        r = np.concatenate([r[..., -1:, :] - period, r, r[..., :2, :] + period], axis=-2)
        e = np.concatenate([e[..., -1:, :, :], e, e[..., :2, :, :]], axis=-3)
    middle, tangent = _stencil(r, e, spacing, _NARROW)
    if r.shape[-2] >= 4:
        middle[..., 1:-1, :, :], tangent[..., 1:-1, :] = _stencil(r, e, spacing, _WIDE)
    along = np.einsum("...ak,...k->...a", middle, tangent)
    first, second = e[..., :-1, :, :], e[..., 1:, :, :]
    turn = np.einsum("...ak,...bk->...ab", first, second)
    shape = turn.shape[:-2]
    angle = Rotation.from_matrix(turn.reshape(-1, 3, 3)).as_rotvec().reshape(*shape, 3) / spacing
    found = (
        along[..., 0] - 1.0,
        np.hypot(along[..., 1], along[..., 2]),
        np.hypot(angle[..., 1], angle[..., 2]),
        angle[..., 0],
    )
    return LinkStrains(*((one[..., 1:-1] if periodic else one) for one in found))


def _stencil(
    r: np.ndarray, e: np.ndarray, spacing: float, weights: tuple[float, float, float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """C⁰e (…, L, 3, 3) and C¹r (…, L, 3) of the links that have all spheres of the stencil."""
    outer, inner, far, near = weights
    middle = inner * (e[..., :-1, :, :] + e[..., 1:, :, :])
    tangent = near * np.diff(r, axis=-2) / spacing
    if not outer:
        return middle, tangent
    middle, tangent = middle[..., 1:-1, :, :], tangent[..., 1:-1, :]
    middle = middle + outer * (e[..., :-3, :, :] + e[..., 3:, :, :])
    return middle, tangent - far * (r[..., 3:, :] - r[..., :-3, :]) / spacing
