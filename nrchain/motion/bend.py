"""max (|offset|/a, |e₁ × axis|): the bend of a chain, and whether it is too large for a look.

A chain that is nearly straight is watched at every step, see :mod:`nrchain.watch.growth`. One that
is bent by :data:`LARGEST` need not be: compiled code finds that out by itself, every
:data:`BENT` steps.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nrchain._compile import kernel, part

LARGEST = 1e-2
"""Bends of this many radii or radians no longer grow linearly: until then the largest wins."""

BENT = 8
"""Steps until a chain that was found bent is checked again."""


class BendCheck(NamedTuple):
    """Which steps of a chain need no look at its bend.

    Attributes
    ----------
    pause
        (1,) integers, the steps that need not be looked at, whatever the bend.
    farthest
        (6N,), the largest |y| of every coordinate at the end of a step that was checked; y is that
        of the integrator, for all spheres in their order along the chain.
    lengths
        (2,): the radius of the spheres, and the length after which the chain repeats or 0.
    """

    pause: np.ndarray
    farthest: np.ndarray
    lengths: np.ndarray

    @classmethod
    def of(cls, count: int, radius: float, period: float) -> BendCheck:
        """That of ``count`` spheres, before the first step."""
        return cls(np.zeros(1, np.int64), np.zeros(6 * count), np.array([radius, period]))


@kernel
def bend_of(positions, frames, radius, periodic, limit):
    """max |offset|/a and max |e₁ × axis|, up to the first sphere at which one reaches ``limit``.

    The axis is x for a periodic chain and joins the ends of an open one.
    """
    count = positions.shape[0]
    axis = np.zeros(3)
    axis[0] = 1.0
    if not periodic:
        square = 0.0
        for k in range(3):
            axis[k] = positions[count - 1, k] - positions[0, k]
            square += axis[k] * axis[k]
        if square == 0.0:
            return limit, limit
        axis /= np.sqrt(square)
    farthest, most_tilted = 0.0, 0.0
    for i in range(count):
        offset, tilt = 0.0, 0.0
        for k in range(3):
            k1, k2 = (k + 1) % 3, (k + 2) % 3
            first, second = positions[i, k1] - positions[0, k1], positions[i, k2] - positions[0, k2]
            offset += ((first * axis[k2] - second * axis[k1]) / radius) ** 2
            tilt += (frames[i, 0, k1] * axis[k2] - frames[i, 0, k2] * axis[k1]) ** 2
        farthest, most_tilted = max(farthest, np.sqrt(offset)), max(most_tilted, np.sqrt(tilt))
        if max(farthest, most_tilted) >= limit:
            break
    return farthest, most_tilted


@part
def is_bent(check, positions, frames, y):
    """Whether the step that reached ``y`` needs no look; notes the step if so."""
    if check.pause[0] > 0:
        check.pause[0] -= 1
        return True
    radius, period = check.lengths[0], check.lengths[1]
    if max(bend_of(positions, frames, radius, period > 0.0, LARGEST)) < LARGEST:
        return False
    for m in range(y.shape[0]):
        check.farthest[m] = max(check.farthest[m], abs(y[m]))
    check.pause[0] = BENT - 1
    return True
