"""∫ f ds ≈ Σ_k w_k f(s_k), f′(s_k) = Σ_l D_kl f(s_l): spectral elements on Gauss–Lobatto points.

Each of E elements of equal length has p + 1 Gauss–Legendre–Lobatto points, its ends among them.
Neighbours share the point between them: a rod has E p + 1 nodes, a closed one E p. Functions are
polynomials of degree p in each element and continuous. For smooth functions the error falls
exponentially with p.

Source: C. Canuto et al., *Spectral Methods* (Springer, 2006), Sec. 2.3.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.polynomial import legendre

from nrchain.notebook import record_html
from nrchain.wording import brief


@dataclass(frozen=True, eq=False)
class Elements:
    """Nodes, weights and derivatives along a rod.

    Attributes
    ----------
    length
        L; of a closed rod, its period.
    count, degree
        E and p.
    closed
        Whether the last element ends at the first node.
    places
        s (N,) of the nodes, 0 at the first.
    weights
        w (p + 1,) of one element.
    slopes
        D (p + 1, p + 1) of one element.
    """

    length: float
    count: int
    degree: int
    closed: bool
    places: np.ndarray
    weights: np.ndarray
    slopes: np.ndarray

    __repr__ = brief
    _repr_html_ = record_html

    @classmethod
    def of(cls, length: float, count: int, degree: int, closed: bool) -> Self:
        """Equal elements."""
        points, weights = lobatto(degree)
        size = length / count
        own = 0.5 * size * (points + 1.0)
        places = (size * np.arange(count)[:, None] + own[:-1]).ravel()
        if not closed:
            places = np.append(places, length)
        slopes = differentiation(points) / (0.5 * size)
        return cls(length, count, degree, closed, places, 0.5 * size * weights, slopes)

    @property
    def nodes(self) -> np.ndarray:
        """Nodes (E, p + 1) of each element."""
        index = self.degree * np.arange(self.count)[:, None] + np.arange(self.degree + 1)
        return np.asarray(index % len(self.places))

    def lumped(self) -> np.ndarray:
        """Σ w (N,) of each node over the elements that share it."""
        total = np.zeros(len(self.places))
        np.add.at(total, self.nodes.ravel(), np.tile(self.weights, self.count))
        return total

    def interpolation(self, places: np.ndarray) -> np.ndarray:
        """The matrix (M, N) that gives values at ``places`` in [0, L] from those at the nodes."""
        size = self.length / self.count
        element = np.clip((places / size).astype(int), 0, self.count - 1)
        inside = 2.0 * (places - size * element) / size - 1.0
        values = lagrange(lobatto(self.degree)[0], inside)
        matrix = np.zeros((len(places), len(self.places)))
        np.add.at(matrix, (np.arange(len(places))[:, None], self.nodes[element]), values)
        return matrix


def lobatto(degree: int) -> tuple[np.ndarray, np.ndarray]:
    """The p + 1 points of Gauss–Legendre–Lobatto in [−1, 1], and their weights."""
    series = np.zeros(degree + 1)
    series[degree] = 1.0
    inner = legendre.legroots(legendre.legder(series))
    slope, curvature = legendre.legder(series), legendre.legder(series, 2)
    for _ in range(3):
        inner = inner - legendre.legval(inner, slope) / legendre.legval(inner, curvature)
    points = np.concatenate([[-1.0], inner, [1.0]])
    weights = 2.0 / (degree * (degree + 1) * legendre.legval(points, series) ** 2)
    return points, weights


def differentiation(points: np.ndarray) -> np.ndarray:
    """D with f′(x_k) = Σ_l D_kl f(x_l) for polynomials through the points; its rows sum to 0."""
    apart = points[:, None] - points
    np.fill_diagonal(apart, 1.0)
    products = apart.prod(axis=1)
    matrix = products[:, None] / products / apart
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    return matrix


def lagrange(points: np.ndarray, at: np.ndarray) -> np.ndarray:
    """(M, n) values of the polynomials that are 1 at one of n points and 0 at the others."""
    apart = at[:, None] - points
    differences = points[:, None] - points
    np.fill_diagonal(differences, 1.0)
    values = np.empty_like(apart)
    for k in range(len(points)):
        others = np.delete(apart, k, axis=1)
        values[:, k] = others.prod(axis=1) / differences[k].prod()
    return values
