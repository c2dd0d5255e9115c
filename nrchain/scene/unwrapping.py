"""n_{i+1} − n_i = round((x_{i+1} − x_i − d)/P): a periodic chain put together from wrapped spheres.

Programs that keep a chain in a box of period P = N d move spheres by whole periods along x. Here
springs, slip and friction act between neighbours along the chain where they are given, so every
function that takes the positions of an elastic periodic chain unwraps them first. A link takes the
image in which it is nearest to its rest length d along x. Where the next image is about as near,
links are strained by half a period, and which image is meant cannot be told: such positions are
refused.

Where neither stretch nor shear holds neighbours together there are no links to go by, and spheres
may drift apart by any distance: positions are then taken as they are given, unwrapped.
"""

from __future__ import annotations

import numpy as np

from nrchain.errors import SceneError
from nrchain.scene.scene import Scene

CLEAR = 0.4
"""Periods that a link may be off its rest length: the next image is half as far again, or more."""

ROUNDING = 1e-9
"""What the rounding of wrapped coordinates may be, in rest lengths of a link."""


def unwrapped(positions: np.ndarray, spacing: float, key: str = "positions") -> np.ndarray:
    """x_i − n_i P: positions (..., N, 3) of a periodic chain of rest spacing d, put together.

    Spheres are moved by whole periods N d along x. The image that most spheres are in stays where
    it is. Positions that are not wrapped are returned as they are given.

    Raises :class:`~nrchain.errors.SceneError`, with the sphere, where a link is more than
    :data:`CLEAR` periods off its rest length in every image, where the links do not close after one
    period, and where wrapped coordinates are so large that their rounding shows.

    >>> unwrapped(np.array([[0.0, 0, 0], [10.0, 0, 0], [-10.0, 0, 0]]), 10.0)[:, 0]
    array([ 0., 10., 20.])
    """
    x = positions[..., 0]
    period = x.shape[-1] * spacing
    with np.errstate(all="ignore"):
        strains = (np.diff(x, append=x[..., :1] + period) - spacing) / period
        jumps = np.rint(strains)
        if not jumps.any() and np.abs(strains).max(initial=0.0) <= CLEAR:
            return positions
        rounding = np.spacing(np.abs(x).max(axis=-1)) > ROUNDING * spacing
        off = np.abs(strains - jumps)
        # NaN, from numbers beyond the range of floats, is not clear
        clear = (off.max(axis=-1) <= CLEAR) & (jumps.sum(axis=-1) == 0.0) & ~rounding
    if not clear.all():
        chain = np.unravel_index(np.argmin(clear), clear.shape)
        named = key + "".join(f"[{place}]" for place in chain)
        if rounding[chain]:
            raise _too_far(named, x[chain], spacing)
        raise _not_clear(named, strains[chain], off[chain], spacing)
    images = np.cumsum(np.roll(jumps, 1, axis=-1), axis=-1)
    images -= images[..., :1]
    images -= _most_common(images)[..., None]
    moved = positions.copy()
    moved[..., 0] -= images * period
    return moved


def is_wrapped(positions: np.ndarray, spacing: float) -> np.ndarray:
    """(...) whether any sphere of each chain (..., N, 3) is moved by :func:`unwrapped`."""
    return (unwrapped(positions, spacing) != positions).any(axis=(-2, -1))


def unwrapped_chain(scene: Scene, positions: np.ndarray, key: str = "positions") -> np.ndarray:
    """The positions (..., N, 3) of a scene's chain, put together if it is periodic and elastic.

    Errors as for :func:`unwrapped`.
    """
    return unwrapped(positions, scene.chain.spacing, key) if has_images(scene) else positions


def has_images(scene: Scene) -> bool:
    """Whether springs act along the links of a periodic chain, so that its images matter."""
    return scene.chain.ends == "periodic" and bool(scene.moduli.stretch or scene.moduli.shear)


def _most_common(images: np.ndarray) -> np.ndarray:
    """(...) the image (..., N) that most spheres of each chain are in."""
    flat = images.reshape(-1, images.shape[-1])
    found = []
    for row in flat:
        values, counts = np.unique(row, return_counts=True)
        found.append(values[np.argmax(counts)])
    return np.array(found).reshape(images.shape[:-1])


def _too_far(key: str, x: np.ndarray, spacing: float) -> SceneError:
    sphere = int(np.argmax(np.abs(x)))
    allowed = (
        f"wrapped, at x = {x[sphere]:.4g}, where coordinates are rounded to"
        f" {np.spacing(abs(x[sphere])):.2g} and the rest length is {spacing:g}; give the positions"
        " of the unwrapped chain"
    )
    return SceneError(key, f"sphere {sphere}", allowed)


def _not_clear(key: str, strains: np.ndarray, off: np.ndarray, spacing: float) -> SceneError:
    count = len(strains)
    link = int(np.argmax(np.nan_to_num(off, nan=np.inf)))
    length = strains[link] * count * spacing + spacing
    allowed = (
        f"wrapped, or torn off: along x it is {length:.4g} ahead of sphere {link}, where the rest"
        f" length is {spacing:g} and the period {count * spacing:g}; which of its images belongs to"
        " the chain is not clear; give the positions of the unwrapped chain"
    )
    return SceneError(key, f"sphere {(link + 1) % count}", allowed)
