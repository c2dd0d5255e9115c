"""X(s), 0 ≤ s ≤ 1: the poses of a chain over a period, in axes that go along with it.

The period is divided into M intervals. Each begins with the last pose of the one before, and the
first with the last pose of all: the orbit is closed. Within an interval (u, θ) about its first pose
is the cubic through the three stages of Radau IIA.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nrchain.comoving.motions import moved
from nrchain.motion.integrators.radau_tableau import NODES, RUNGE_KUTTA, cubics
from nrchain.states.cycles.charts import chart
from nrchain.types import Poses, PosesAt

CUBICS = cubics(NODES)

FIRST = 16
"""Intervals of a guess."""


@dataclass(frozen=True)
class Orbit:
    """A closed orbit of shapes.

    Attributes
    ----------
    period
        T.
    elementary
        (7,) rates of the elementary motions of the axes (:mod:`nrchain.comoving.motions`).
    widths
        (M,) of the intervals, as fractions of T.
    positions, frames
        (M, 3, N, 3) and (M, 3, N, 3, 3) at the stages, in axes that coincide with those of the lab
        at the start.
    """

    period: float
    elementary: np.ndarray
    widths: np.ndarray
    positions: np.ndarray
    frames: np.ndarray

    @property
    def count(self) -> int:
        """M."""
        return len(self.widths)

    @property
    def starts(self) -> np.ndarray:
        """(M,) where intervals begin, as fractions of T."""
        return np.concatenate([[0.0], np.cumsum(self.widths)[:-1]])

    @property
    def excursions(self) -> np.ndarray:
        """(M, 3, N, 3): positions less their mean over the period."""
        weights = self.widths[:, None] * RUNGE_KUTTA[2]
        return self.positions - np.einsum("kj,kjnp->np", weights, self.positions)

    @property
    def amplitude(self) -> float:
        """Largest distance of a sphere from its mean position."""
        return float(np.linalg.norm(self.excursions, axis=-1).max())

    def base(self, k: int) -> Poses:
        """The first pose of an interval."""
        return self.positions[k - 1, 2], self.frames[k - 1, 2]

    def bases(self) -> Poses:
        """The first poses of all intervals: (M, N, 3) and (M, N, 3, 3)."""
        return np.roll(self.positions[:, 2], 1, axis=0), np.roll(self.frames[:, 2], 1, axis=0)

    def cubic(self, k: int) -> np.ndarray:
        """c (3, N, 6): (u, θ) = Σ_m c_m x^(m+1) at the fraction x of an interval."""
        y = chart(self.positions[k], self.frames[k], self.base(k))
        return np.einsum("jm,jnp->mnp", CUBICS, y)

    def at(self, fraction: float) -> Poses:
        """Poses at a fraction of the period."""
        within = fraction % 1.0
        k = int(np.searchsorted(self.starts, within, side="right")) - 1
        x = (within - self.starts[k]) / self.widths[k]
        return moved(*self.base(k), np.einsum("mnp,m->np", self.cubic(k), x ** np.arange(1, 4)))

    def remeshed(self, widths: np.ndarray) -> Orbit:
        """The same orbit at the stages of other intervals."""
        return orbit_of(self.at, self.period, self.elementary, widths)


def orbit_of(at: PosesAt, period: float, elementary: np.ndarray, widths: np.ndarray) -> Orbit:
    """The orbit with the poses ``at`` every fraction of the period."""
    starts = np.concatenate([[0.0], np.cumsum(widths)[:-1]])
    fractions = starts[:, None] + widths[:, None] * NODES
    found = [[at(float(fraction)) for fraction in row] for row in fractions]
    positions = np.array([[pose[0] for pose in row] for row in found])
    frames = np.array([[pose[1] for pose in row] for row in found])
    return Orbit(period, elementary, widths, positions, frames)
