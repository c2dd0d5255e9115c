"""G(z, p) = 0, what a branch is made of: its solutions, their tangents, and their exponents.

States are one kind of curve (:mod:`nrchain.states.branches.steady`). z lies on a manifold: a small
change is a vector of coordinates at the solution it belongs to, and those at solutions nearby may
be compared. The length of a change (δ, q) of (z, p) is that of :meth:`Curve.inner`.
"""

from __future__ import annotations

from typing import Generic, NamedTuple, Protocol, TypeVar

import numpy as np


class Direction(NamedTuple):
    """(δ, q): a change of z in coordinates, and of p."""

    change: np.ndarray
    value: float

    def times(self, factor: float) -> Direction:
        """This change, ``factor`` times as long."""
        return Direction(factor * self.change, factor * self.value)


class Solution(Protocol):
    """(z, p) with G(z, p) = 0, or close to it."""

    @property
    def value(self) -> float:
        """p."""
        ...


S = TypeVar("S", bound=Solution)


class Corrected(NamedTuple, Generic[S]):
    """A solution, the steps of Newton's method, the size of the last one, and that of their sum."""

    solution: S
    steps: int
    error: float
    away: float


class Curve(Protocol[S]):
    """The solutions of one kind along a line of scenes.

    Methods raise FloatingPointError where a matrix is singular or numbers leave their range.
    """

    def inner(self, first: Direction, second: Direction) -> float:
        """⟨δ₁, δ₂⟩ + q₁ q₂ in units in which a length of 1 is a large change."""
        ...

    def moved(self, solution: S, direction: Direction) -> S:
        """(z ⊕ δ, p + q): a guess."""
        ...

    def corrected(self, guess: S, direction: Direction) -> Corrected[S]:
        """The solution near a guess: no step of Newton's method has a part along ``direction``.

        Raises FloatingPointError if Newton's method does not converge.
        """
        ...

    def tangent(self, solution: S, along: Direction) -> Direction:
        """The direction of the curve, of length 1, on the side of ``along``."""
        ...

    def exponents(self, solution: S) -> np.ndarray:
        """Growth exponents (k,) from the largest real part on, without neutral ones.

        Rates Λ of a state; log μ/T of a cycle, with |Im| ≤ π/T.
        """
        ...

    def is_real(self, solution: S, exponent: complex) -> bool:
        """Whether an exponent on the imaginary axis is zero."""
        ...

    def branching(self, solution: S, exponents: np.ndarray, multiplicity: int) -> str:
        """The kind of a branch point, where so many exponents vanish."""
        ...

    def oscillation(self, solution: S, exponent: complex) -> tuple[str, int]:
        """The kind of a point where exponents with imaginary parts cross, and how many at once."""
        ...

    def distance(self, first: S, second: S) -> float:
        """How far two solutions are apart, in the units of :meth:`inner`."""
        ...

    def noise(self, solution: S) -> float:
        """A real part below this is rounding."""
        ...

    def gone(self, solution: S) -> str:
        """Why a chain does not get to a solution, such as overlap; empty if it may."""
        ...


def unit(curve: Curve[S], direction: Direction) -> Direction:
    """The direction with length 1."""
    return direction.times(1.0 / np.sqrt(curve.inner(direction, direction)))
