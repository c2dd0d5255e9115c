"""Whether a step is clear of contacts and of turned links, by bounds that cost little.

A step is clear if the closest pair is farther apart than the spheres moved in it, with a margin,
and no link has turned by a quarter turn at its end. A step that is not clear has to be looked at:
see :mod:`nrchain.watch.guard`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nrchain._compile import kernel, part
from nrchain.geometry.near_pairs import DIRECT_SEARCH, least_distance
from nrchain.motion.contact import PoseLimits, least_aligned

EXCURSION = 2.0
"""Largest deviation of a path within a step, over the displacement of the step."""


class Clearance(NamedTuple):
    """The closest pair of a chain, and where the spheres were when it was sought.

    Attributes
    ----------
    searched
        Positions (N, 3) at that time.
    closest
        (1,), the distance of the closest pair.
    limits
        (3,): the distance at which spheres touch, the length after which the chain repeats or 0,
        and 1 if links resist twist or bend.
    """

    searched: np.ndarray
    closest: np.ndarray
    limits: np.ndarray

    @classmethod
    def of(cls, limits: PoseLimits, count: int) -> Clearance:
        """That of ``count`` spheres, before the first search."""
        numbers = np.array([limits.contact, limits.period, float(limits.rotational_springs)])
        return cls(np.zeros((count, 3)), np.zeros(1), numbers)


@kernel
def largest_move(before, after):
    """How far a sphere has moved at most, beside the motion of all."""
    count = before.shape[0]
    mean = np.empty(3)
    mean[:] = 0.0
    for i in range(count):
        for k in range(3):
            mean[k] += (after[i, k] - before[i, k]) / count
    largest = 0.0
    for i in range(count):
        square = 0.0
        for k in range(3):
            square += (after[i, k] - before[i, k] - mean[k]) ** 2
        largest = max(largest, square)
    return np.sqrt(largest)


@kernel(alone=True)
def margin(clearance, before, after):
    """How much farther apart than at contact all pairs are in a step, at least."""
    moved = 2.0 * EXCURSION * largest_move(before, after)
    since = 2.0 * largest_move(clearance.searched, after)
    return clearance.closest[0] - since - moved - clearance.limits[0]


@part
def is_clear(clearance, before, after, frames):
    """Whether the step from positions ``before`` to ``after`` and ``frames`` is clear."""
    if not margin(clearance, before, after) > 0.0:
        if after.shape[0] > DIRECT_SEARCH:
            return False
        for i in range(after.shape[0]):
            for k in range(3):
                clearance.searched[i, k] = after[i, k]
        clearance.closest[0] = least_distance(after, clearance.limits[1])[0]
        if not margin(clearance, before, after) > 0.0:
            return False
    if not clearance.limits[2]:
        return True
    return least_aligned(frames, clearance.limits[1] > 0.0)[0] >= 0.0
