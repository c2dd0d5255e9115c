"""r′ = h, e_a′ = Π × e_a: the helix of a uniform strain, and wrenches carried along it.

With h and Π constant in the moving frame, the frame turns by θ = |Π| s about Π:

    R(s) = 1 + A s Π^ + B (s Π^)²,     r(s) = s [1 + B s Π^ + C (s Π^)²] h,

with A = sin θ/θ, B = (1 − cos θ)/θ², C = (θ − sin θ)/θ³. At rest h = e₁ and Π = 0; the strains are
ε = h − e₁ and τ = Π. Source: paper, Eqs. (spatial_def), (tr_rod_strain) and (rot_rod_strain).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from nrchain.theory.rod.constants import cross

SMALL = 0.5
"""Angle below which C is summed as a series: the difference θ − sin θ would lose digits."""

TERMS = 12

NODES = 16
"""Gauss–Legendre points of an average over a stretch that turns little; one more per radian."""


class Helix:
    """The poses of a uniform state of strain (ε, τ) (6,), from the origin at s = 0."""

    def __init__(self, strain: np.ndarray) -> None:
        self.h = strain[:3] + np.array([1.0, 0.0, 0.0])
        self.pi = strain[3:]
        self._turn = cross(self.pi)
        self._rate = float(np.linalg.norm(self.pi))

    def at(self, places: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """r (N, 3) and the matrices R (N, 3, 3), whose columns are e₁, e₂ and e₃, at s (N,)."""
        s = np.atleast_1d(np.asarray(places, float))[:, None, None]
        theta = self._rate * s
        first, second = s * self._turn, s**2 * (self._turn @ self._turn)
        bent = 0.5 * np.sinc(theta / math.tau) ** 2
        rotations = np.eye(3) + np.sinc(theta / math.pi) * first + bent * second
        positions = s[:, 0] * ((np.eye(3) + bent * first + _third(theta) * second) @ self.h)
        return positions, rotations

    def poses(self, places: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Positions (N, 3) and frames (N, 3, 3), with rows e_a, of spheres at s (N,)."""
        positions, rotations = self.at(places)
        return positions, np.ascontiguousarray(rotations.swapaxes(1, 2))

    def carry(self, wrenches: np.ndarray, places: ArrayLike) -> np.ndarray:
        """(F, M) (N, 6) about r(s) in the frame there, of (F, M) about the origin in the lab.

        ``wrenches`` is (6,), or (N, 6) with one for each place.
        """
        positions, rotations = self.at(places)
        forces = np.broadcast_to(wrenches[..., :3], positions.shape)
        moments = wrenches[..., 3:] - np.cross(positions, forces)
        carried = [np.einsum("nij,ni->nj", rotations, part) for part in (forces, moments)]
        return np.concatenate(carried, axis=1)

    def integral(self, wrench: np.ndarray, first: float, last: float) -> np.ndarray:
        """∫ (F, M) ds of :meth:`carry` from ``first`` to ``last``."""
        count = NODES + math.ceil(self._rate * abs(last - first))
        nodes, weights = np.polynomial.legendre.leggauss(count)
        half, middle = 0.5 * (last - first), 0.5 * (last + first)
        return half * weights @ self.carry(wrench, middle + half * nodes)


def _third(theta: np.ndarray) -> np.ndarray:
    """(θ − sin θ)/θ³."""
    small = np.abs(theta) <= SMALL
    series = sum((-(theta**2)) ** n / math.factorial(2 * n + 3) for n in range(TERMS))
    safe = np.where(small, 1.0, theta)
    return np.where(small, series, (safe - np.sin(safe)) / safe**3)
