"""n_{i+1} − n_i = round((x_{i+1} − x_i − d)/P): positions of a periodic chain, unwrapped.

Programs that keep a chain in a box of period P = N d move spheres by whole periods along x. In
nrchain springs, slip and friction act between the given positions of neighbours along the chain.
Each function that takes positions of an elastic periodic chain therefore unwraps them first. A link
takes the image in which it is nearest to its rest length d along x. Where the next image is about
as near, the link is strained by half a period and its image is not clear: such positions raise an
error.

If neither stretch nor shear holds neighbours together, spheres may drift apart by any distance.
Positions are then taken as they are given.
"""

from __future__ import annotations

import numpy as np

from nrchain.errors import SceneError
from nrchain.scene.scene import Scene

CLEAR = 0.4
"""Largest distance of a link from its rest length, in periods; the next image is at 0.6 or more."""

ROUNDING = 1e-9
"""Largest rounding error of wrapped coordinates, in rest lengths of a link."""


def unwrapped(positions: np.ndarray, spacing: float, key: str = "positions") -> np.ndarray:
    """x_i − n_i P: positions (..., N, 3) of a periodic chain of rest spacing d, unwrapped.

    Spheres move by whole periods N d along x. The image with most spheres stays in place. Positions
    that are not wrapped are returned unchanged.

    Raises :class:`~nrchain.errors.SceneError`, with the sphere, if a link is more than
    :data:`CLEAR` periods off its rest length in every image, if the links do not close after one
    period, or if wrapped coordinates are so large that their rounding matters.

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
        # NaN, from numbers beyond the range of floating point, is not clear
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
    """(...) whether :func:`unwrapped` moves any sphere of each chain (..., N, 3)."""
    return (unwrapped(positions, spacing) != positions).any(axis=(-2, -1))


def unwrapped_chain(scene: Scene, positions: np.ndarray, key: str = "positions") -> np.ndarray:
    """The positions (..., N, 3) of the chain of a scene, unwrapped if it is periodic and elastic.

    Errors as for :func:`unwrapped`.
    """
    return unwrapped(positions, scene.chain.spacing, key) if has_images(scene) else positions


def has_images(scene: Scene) -> bool:
    """Whether the chain is periodic and has springs along its links, so that images matter."""
    return scene.chain.ends == "periodic" and bool(scene.moduli.stretch or scene.moduli.shear)


def _most_common(images: np.ndarray) -> np.ndarray:
    """(...) the image, of those (..., N) of the spheres, that holds most spheres of each chain."""
    flat = images.reshape(-1, images.shape[-1])
    found = []
    for row in flat:
        values, counts = np.unique(row, return_counts=True)
        found.append(values[np.argmax(counts)])
    return np.array(found).reshape(images.shape[:-1])


def _too_far(key: str, x: np.ndarray, spacing: float) -> SceneError:
    sphere = int(np.argmax(np.abs(x)))
    allowed = (
        f"is wrapped, at x = {x[sphere]:.4g}, where coordinates are rounded to"
        f" {np.spacing(abs(x[sphere])):.2g} and the rest length is {spacing:g}; give the positions"
        " of the unwrapped chain"
    )
    return SceneError(key, f"sphere {sphere}", allowed)


def _not_clear(key: str, strains: np.ndarray, off: np.ndarray, spacing: float) -> SceneError:
    count = len(strains)
    link = int(np.argmax(np.nan_to_num(off, nan=np.inf)))
    length = strains[link] * count * spacing + spacing
    allowed = (
        f"is wrapped or torn off: along x it is {length:.4g} ahead of sphere {link}, while the rest"
        f" length is {spacing:g} and the period {count * spacing:g}, and which image belongs to the"
        " chain is not clear; give the positions of the unwrapped chain"
    )
    return SceneError(key, f"sphere {(link + 1) % count}", allowed)
