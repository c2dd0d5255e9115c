"""|r_i − r_j| < c: the pairs of spheres near each other in space.

Short chains are searched pair by pair, long chains with a tree. On a periodic chain the nearest
image of every sphere counts: c must be below half the period.
"""

from __future__ import annotations

import numpy as np

from nrchain._compile import kernel

DIRECT_SEARCH = 1024
"""Chains up to this length are searched pair by pair, longer ones with a tree."""


@kernel
def list_pairs(positions, cutoff, period, pairs):
    """Fill ``pairs`` (M, 2) up to its size; return the number of pairs found."""
    count, found = positions.shape[0], 0
    for i in range(count):
        for j in range(i + 1, count):
            x = positions[i, 0] - positions[j, 0]
            if period > 0.0:
                x -= period * np.rint(x / period)
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
        found = list_pairs(positions, cutoff, period, pairs)
        if found > len(pairs):
            pairs = np.empty((found, 2), np.int64)
            list_pairs(positions, cutoff, period, pairs)
        return pairs[:found]
    from scipy.spatial import cKDTree

    points, spheres = positions, np.arange(count)
    if period > 0.0:
        # every sphere once within the period, and images of those near its ends beyond them
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


@kernel
def least_distance(positions, period):
    """(distance, i, j) of the two spheres nearest each other, pair by pair."""
    count = positions.shape[0]
    least, first, second = np.inf, -1, -1
    for i in range(count):
        for j in range(i + 1, count):
            x = positions[i, 0] - positions[j, 0]
            if period > 0.0:
                x -= period * np.rint(x / period)
            y, z = positions[i, 1] - positions[j, 1], positions[i, 2] - positions[j, 2]
            square = x * x + y * y + z * z
            if square < least:
                least, first, second = square, i, j
    return np.sqrt(least), first, second


def closest_pair(positions: np.ndarray, period: float = 0.0) -> tuple[float, int, int]:
    """(distance, i, j) of the two spheres nearest each other, images along x included."""
    if len(positions) <= DIRECT_SEARCH:
        distance, i, j = least_distance(positions, period)
        return float(distance), int(i), int(j)
    from scipy.spatial import cKDTree

    inside = points = positions
    if period > 0.0:
        # every sphere, moved into one period
        shift = np.array([period, 0.0, 0.0])
        inside = positions - np.floor(positions[:, :1] / period) * shift
        points = np.concatenate([inside, inside + shift, inside - shift])
    distances, neighbours = cKDTree(points).query(inside, k=2)
    i = int(np.argmin(distances[:, 1]))
    return float(distances[i, 1]), i, int(neighbours[i, 1]) % len(positions)
