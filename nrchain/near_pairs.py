"""|r_i − r_j| < c: the pairs of spheres near each other in space, wherever they are on the chain.

Short chains are searched pair by pair, long ones with a tree. A chain that repeats along x is
taken with the nearest image of every sphere: c must stay below half the period.
"""

from __future__ import annotations

import numpy as np

from nrchain._compile import kernel

DIRECT_SEARCH = 1024
"""Chains up to this length are searched pair by pair, longer ones with a tree."""


@kernel
def _list_pairs(positions, cutoff, period, pairs):
    """Fill ``pairs`` (M, 2) as far as it goes; return how many there are."""
    count, found = positions.shape[0], 0
    for i in range(count):
        for j in range(i + 1, count):
            x = positions[i, 0] - positions[j, 0]
            if period > 0.0:
                x -= period * np.round(x / period)
            y, z = positions[i, 1] - positions[j, 1], positions[i, 2] - positions[j, 2]
            if x * x + y * y + z * z < cutoff * cutoff:
                if found < pairs.shape[0]:
                    pairs[found, 0], pairs[found, 1] = i, j
                found += 1
    return found


def near_pairs(positions: np.ndarray, cutoff: float, period: float = 0.0) -> np.ndarray:
    """The pairs (M, 2) with i < j that are closer than ``cutoff``, in lexical order."""
    count = len(positions)
    if count <= DIRECT_SEARCH:
        pairs = np.empty((4 * count, 2), np.int64)
        found = _list_pairs(positions, cutoff, period, pairs)
        if found > len(pairs):
            pairs = np.empty((found, 2), np.int64)
            _list_pairs(positions, cutoff, period, pairs)
        return pairs[:found]
    from scipy.spatial import cKDTree

    points, spheres = positions, np.arange(count)
    if period > 0.0:
        # every sphere once within the period, and those near its ends again beyond them
        points = positions.copy()
        points[:, 0] -= period * np.floor(points[:, 0] / period)
        low, high = points[:, 0] < cutoff, points[:, 0] > period - cutoff
        shift = np.array([period, 0.0, 0.0])
        spheres = np.concatenate([spheres, spheres[low], spheres[high]])
        points = np.concatenate([points, points[low] + shift, points[high] - shift])
    found = cKDTree(points).query_pairs(cutoff, output_type="ndarray")
    pairs = np.sort(spheres[found], axis=1)
    return np.unique(pairs, axis=0)


def separations(positions: np.ndarray, pairs: np.ndarray, period: float = 0.0) -> np.ndarray:
    """r_i − r_j (M, 3) of each pair, to the nearest image."""
    vectors = positions[pairs[:, 0]] - positions[pairs[:, 1]]
    if period > 0.0:
        vectors[:, 0] -= period * np.round(vectors[:, 0] / period)
    return vectors
