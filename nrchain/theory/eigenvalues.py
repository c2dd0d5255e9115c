"""Eigenvalues of the operators of plane waves, each under the name of its branch."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]

APART = 1e-9
"""Values nearer than this, relative to the largest, count as equal: their order does not matter."""

HALVINGS = 8
"""A step of :func:`follow` is halved at most so often."""


def two_branches(
    a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues of [[a, b], [c, d]], the one nearer to a first, without cancellation."""
    half = (a - d) / 2.0
    root = np.sqrt(half * half + b * c)
    root = np.where((half.conj() * root).real < 0.0, -root, root)
    denominator = half + root
    apart = denominator != 0.0
    shift = np.divide(b * c, denominator, out=np.zeros_like(root), where=apart)
    return a + shift, d - shift


def matched_eigenvalues(reduced: Complex) -> Complex:
    """Eigenvalues of the reduced operator, each in the column where its vector is largest."""
    from scipy.optimize import linear_sum_assignment

    values, vectors = np.linalg.eig(reduced)
    rates = np.empty(values.shape, complex)
    for index in np.ndindex(values.shape[:-1]):
        rows, columns = linear_sum_assignment(-(np.abs(vectors[index]) ** 2))
        rates[index][rows] = values[index][columns]
    return rates


def follow(values: Callable[[complex], Complex], path: NDArray[np.complex128]) -> Complex:
    """The values (n, k) of a set of k along a path, each column continuous.

    ``values`` gives the set (k,) at a point, in any order but at the first point, which sets the
    columns. Each is found from its linear extrapolation. A step is halved while a value lies more
    than half as far from its extrapolation as from another value.
    """
    found = np.array(values(path[0]), complex)
    rows, slope = [found], np.zeros_like(found)
    for start, end in itertools.pairwise(path):
        place, step = start, end - start
        while place != end:
            step = end - place if abs(step) >= abs(end - place) else step
            new, sure = _match(found + slope * step, values(place + step))
            if not sure and abs(step) > abs(end - start) / 2**HALVINGS:
                step = step / 2
                continue
            if step:
                slope = (new - found) / step
            place = end if step == end - place else place + step
            found, step = new, 2 * step
        rows.append(found)
    return np.array(rows)


def joined(rows: Complex) -> Complex:
    """Sets (n, k) at points in a row, each column continuous: see :func:`follow`."""
    found = rows.copy()
    for n in range(1, len(rows)):
        slope = found[n - 1] - found[n - 2] if n > 1 else 0.0
        found[n] = _match(found[n - 1] + slope, rows[n])[0]
    return found


def _match(expected: Complex, values: Complex) -> tuple[Complex, bool]:
    """The values in the order of those expected, and whether none could be another."""
    from scipy.optimize import linear_sum_assignment

    distance = np.abs(expected[:, None] - values)
    columns = linear_sum_assignment(distance)[1]
    ordered = values[columns]
    between = np.abs(ordered[:, None] - ordered)
    between[between <= APART * np.abs(values).max()] = np.inf
    return ordered, bool(np.all(np.diagonal(distance[:, columns]) <= between.min(axis=1) / 2))
