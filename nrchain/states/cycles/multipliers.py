"""Φ x = μ x: how small changes of a cycle have grown after a period.

Two kinds of changes are no changes of the cycle: along its path (Ẋ, μ = 1), and motions of the
chain as a whole (Q). A translation across the axis of a drift that turns by ΩT in a period comes
back turned by it, so that Q has multipliers 1 and exp(±iΩT). Ẋ and Q span a space that Φ maps to
itself. Its multipliers are compared with the expected ones, and all others are those of Φ on what
is orthogonal to it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nrchain.comoving.motions import NAMES, TURN
from nrchain.effects.base import cross_matrix
from nrchain.notebook import record_html
from nrchain.states.cycles.system import Condensed
from nrchain.wording import brief


@dataclass(frozen=True)
class Trivial:
    """The multipliers of a shift in time and of motions of the chain as a whole.

    Attributes
    ----------
    names
        What they belong to: time, and the elementary motions that take part.
    multipliers, expected
        (r + 1,) as computed, and what they are: 1, and exp(±iΩT) on a chain that turns.
    distances
        (r + 1,) between both: the error of multipliers near the unit circle.
    """

    names: tuple[str, ...]
    multipliers: np.ndarray
    expected: np.ndarray
    distances: np.ndarray

    __repr__ = brief
    _repr_html_ = record_html

    @property
    def error(self) -> float:
        """The largest distance."""
        return float(self.distances.max())


def trivial_multipliers(condensed: Condensed) -> tuple[Trivial, np.ndarray]:
    """The trivial multipliers, and an orthonormal basis (n, r + 1) of their changes."""
    system = condensed.system
    columns = _neutral(condensed)
    columns = columns / np.linalg.norm(columns, axis=0)
    image = condensed.monodromy @ columns
    own = np.linalg.eigvals(np.linalg.lstsq(columns, image, rcond=None)[0]).astype(complex)
    expected = np.concatenate([[1.0], _turning(condensed)])
    own = own[_paired(expected, own)]
    taking_part = np.abs(system.motions).max(axis=1, initial=0.0) > 1e-9
    names = [name for name, part in zip(NAMES, taking_part, strict=True) if part]
    trivial = Trivial(("time", *names), own, expected, np.abs(own - expected))
    return trivial, np.linalg.qr(columns)[0]


def _neutral(condensed: Condensed) -> np.ndarray:
    """Ẋ and Q (n, r + 1) at the first pose."""
    system = condensed.system
    last = system.intervals[-1].points[2]
    return np.column_stack([last.residual, last.columns @ system.motions])


def _turning(condensed: Condensed) -> np.ndarray:
    """exp(T ad ξ) on the motions of the chain as a whole: eigenvalues (r,)."""
    system, orbit = condensed.system, condensed.system.orbit
    velocity, rotation, _ = system.chain.motion(orbit.elementary)
    bracket = np.zeros((7, 7))
    turn = cross_matrix(rotation[None])[0]
    bracket[:3, :3] = bracket[3:TURN, 3:TURN] = turn
    bracket[:3, 3:TURN] = cross_matrix(velocity[None])[0] / system.chain.length
    if not system.motions.shape[1]:
        return np.zeros(0, complex)
    own = np.linalg.lstsq(system.motions, bracket @ system.motions, rcond=None)[0]
    # eigenvalues 0 and ±iΩ; those of a screw are defective and split by rounding
    rate = float(np.linalg.norm(rotation))
    signs = np.round(np.linalg.eigvals(own).imag / rate) if rate else np.zeros(len(own))
    return np.exp(1j * orbit.period * rate * signs)


def _paired(expected: np.ndarray, found: np.ndarray) -> np.ndarray:
    """For each expected multiplier, the place of the found one that is closest in all."""
    from scipy.optimize import linear_sum_assignment

    return linear_sum_assignment(np.abs(expected[:, None] - found))[1]


def multipliers(
    condensed: Condensed, neutral: np.ndarray, number: int
) -> tuple[np.ndarray, np.ndarray]:
    """The largest multipliers (k,) beside the trivial ones, and their changes (n, k).

    The changes are those of the shape: without a part along the path or as a whole.
    """
    across = np.linalg.qr(neutral, mode="complete")[0][:, neutral.shape[1] :]
    values, vectors = np.linalg.eig(across.T @ condensed.monodromy @ across)
    order = np.lexsort((-values.imag, -np.abs(values)))[:number]
    return values[order].astype(complex), across @ vectors[:, order]


def largest_difference(one: np.ndarray, other: np.ndarray) -> float:
    """The largest distance between multipliers that belong together."""
    if not one.size:
        return 0.0
    return float(np.abs(one - other[_paired(one, other)]).max())
