"""P J P − s Q Qᵀ: all eigenvalues of the shape of a chain, its motions as a whole set apart.

P = 1 − Q Qᵀ projects on changes of shape, and s, larger than any rate, takes the motions Q away
from all others. Parts of the matrix that do not couple are treated one by one: along and across a
straight chain, in and out of the plane of a planar one.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nrchain.comoving.relative import Point

EPSILON = float(np.finfo(float).eps)


def shape_matrix(point: Point) -> np.ndarray:
    """P J P − s Q Qᵀ (n, n), dense."""
    matrix: Any = point.matrix
    dense = matrix.toarray() if not isinstance(matrix, np.ndarray) else matrix.copy()
    basis = point.neutral
    if basis.shape[1]:
        dense -= basis @ (basis.T @ dense)
        dense -= (dense @ basis) @ basis.T
        dense -= far_rate(dense) * (basis @ basis.T)
    return dense


def far_rate(matrix: np.ndarray) -> float:
    """s: twice a bound on the size of all eigenvalues."""
    return 2.0 * float(np.abs(matrix).sum(axis=0).max(initial=0.0)) + 1.0


def parts(matrix: np.ndarray) -> list[np.ndarray]:
    """Indices of the parts that do not couple, to rounding."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    size = float(np.abs(matrix).max(initial=0.0))
    count, labels = connected_components(csr_array(np.abs(matrix) > EPSILON * size))
    return [np.flatnonzero(labels == label) for label in range(count)]


def all_rates(point: Point) -> np.ndarray:
    """All eigenvalues of J but those of the motions as a whole, from the largest real part on."""
    from scipy.linalg import eigvals

    matrix = shape_matrix(point)
    found = [eigvals(matrix[np.ix_(part, part)], check_finite=False) for part in parts(matrix)]
    rates = np.concatenate(found) if found else np.zeros(0, complex)
    rates = rates[np.argsort(-np.abs(rates), kind="stable")][point.neutral.shape[1] :]
    return in_order(rates)


def all_modes(point: Point) -> tuple[np.ndarray, np.ndarray]:
    """All rates of the shape (m,), in any order, and their right modes (n, m)."""
    from scipy.linalg import eig

    matrix = shape_matrix(point)
    count, motions = len(matrix), point.neutral.shape[1]
    rates, modes, found = np.empty(count, complex), np.zeros((count, count), complex), 0
    for part in parts(matrix):
        columns = slice(found, found + len(part))
        rates[columns], modes[part, columns] = eig(matrix[np.ix_(part, part)], check_finite=False)
        found += len(part)
    # the motions as a whole are farthest from 0
    shape = np.argsort(-np.abs(rates), kind="stable")[motions:]
    return rates[shape], modes[:, shape]


def in_order(rates: np.ndarray) -> np.ndarray:
    """From the largest real part on, and of a pair the positive frequency first."""
    return rates[np.lexsort((-rates.imag, -rates.real))]
