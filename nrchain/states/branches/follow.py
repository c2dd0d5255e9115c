"""z ← z ⊕ h t, then Newton's method across t: a curve of solutions by pseudo-arclength.

A step is taken again with half its length if Newton's method needs too many steps, if the curve
turns by too much, or if the solution is not near the guess, which may lie on another curve. It is
made longer where steps are easy. The last step of a curve ends on the limit of p.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Generic

import numpy as np

from nrchain.states.branches.curve import Curve, Direction, S

END = "the end of the range is reached"

FIRST, LARGEST, LEAST = 0.01, 0.05, 1e-7
"""First, largest and least length of a step."""

LONGER, SHORTER = 1.5, 0.5
"""Ratios of a step to the one before, after an easy and a failed one."""

EASY, HARD = 3, 6
"""Steps of Newton's method up to which a step is easy, and above which it fails."""

TURN, STRAIGHT = math.cos(0.35), math.cos(0.12)
"""Cosines of the angle between tangents below which a step fails, and above which it is easy."""

AWAY = 0.3
"""Farthest that a solution may be from its guess, as a part of the step."""


@dataclass(frozen=True, eq=False)
class Place(Generic[S]):
    """A solution on a curve.

    Attributes
    ----------
    solution
        (z, p).
    tangent
        The direction of the curve there, along which it goes on.
    exponents
        Its growth exponents, from the largest real part on.
    unstable
        How many of them grow.
    length
        Arclength from the place before.
    steps, error
        Steps of Newton's method, and the last correction.
    """

    solution: S
    tangent: Direction
    exponents: np.ndarray
    unstable: int
    length: float
    steps: int
    error: float


@dataclass(frozen=True)
class Limits:
    """p between ``low`` and ``high``, and at most so many steps of at most this length."""

    low: float
    high: float
    steps: int
    largest: float = LARGEST


class Follower(Generic[S]):
    """Goes along a curve from a solution; ``reason`` says why it has ended."""

    def __init__(self, curve: Curve[S], limits: Limits) -> None:
        self.curve, self._limits = curve, limits
        self.reason = ""

    def place(
        self,
        solution: S,
        along: Direction,
        *,
        length: float = 0.0,
        steps: int = 0,
        error: float = 0.0,
    ) -> Place[S]:
        """The place of a solution."""
        exponents = self.curve.exponents(solution)
        unstable = int((exponents.real > self.curve.noise(solution)).sum())
        tangent = self.curve.tangent(solution, along)
        return Place(solution, tangent, exponents, unstable, length, steps, error)

    def places(self, begin: Place[S]) -> Iterator[Place[S]]:
        """The places after ``begin``, until the curve leaves its limits or closes."""
        place, length = begin, min(FIRST, self._limits.largest)
        for _ in range(self._limits.steps):
            found = None
            while found is None:
                length_taken, end = self._to_limit(place, length)
                found = self._step(place, length_taken, end)
                if found is None:
                    length = SHORTER * length_taken
                    if length < LEAST:
                        self.reason = "steps have become too small"
                        return
            easy = found.steps <= EASY and self._cosine(place, found) >= STRAIGHT
            length = min(length * (LONGER if easy else 1.0), self._limits.largest)
            self.reason = self.curve.gone(found.solution)
            if self.reason:
                return
            place = found
            yield place
            if end is not None:
                self.reason = END
                return
            if self._is_back(begin, place):
                self.reason = "the branch is closed"
                return
        self.reason = f"{self._limits.steps} steps are taken"

    def between(self, before: Place[S], length: float) -> Place[S]:
        """The place at an arclength within a step that succeeded."""
        guess = self.curve.moved(before.solution, before.tangent.times(length))
        solution, steps, error, _ = self.curve.corrected(guess, before.tangent)
        return self.place(solution, before.tangent, length=length, steps=steps, error=error)

    def _to_limit(self, place: Place[S], length: float) -> tuple[float, float | None]:
        """The length of a step, and the limit of p on which it ends if it would leave the range."""
        value, rate = place.solution.value, place.tangent.value
        low, high = self._limits.low, self._limits.high
        reached = value + length * rate
        if low <= reached <= high or not rate:
            return length, None
        limit = high if rate > 0.0 else low
        return (limit - value) / rate, limit

    def _step(self, place: Place[S], length: float, limit: float | None) -> Place[S] | None:
        """The next place; None if the step is too long."""
        curve, tangent = self.curve, place.tangent
        if length == 0.0:
            return None
        across = tangent if limit is None else Direction(np.zeros_like(tangent.change), 1.0)
        step = tangent.times(length)
        if limit is not None:
            step = Direction(step.change, limit - place.solution.value)
        try:
            guess = curve.moved(place.solution, step)
            solution, steps, error, away = curve.corrected(guess, across)
            if steps > HARD or away > AWAY * length:
                return None
            found = self.place(solution, tangent, length=length, steps=steps, error=error)
        except (FloatingPointError, np.linalg.LinAlgError):
            return None
        return found if self._cosine(place, found) >= TURN else None

    def _is_back(self, begin: Place[S], place: Place[S]) -> bool:
        """Whether the next step leads to where the branch began, in the same direction."""
        near = self.curve.distance(begin.solution, place.solution) <= 0.5 * place.length
        return near and self._cosine(begin, place) >= TURN

    def _cosine(self, before: Place[S], after: Place[S]) -> float:
        return self.curve.inner(before.tangent, after.tangent)
