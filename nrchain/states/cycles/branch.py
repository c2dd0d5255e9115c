"""Branches of cycles: what a user gets of the cycles along a number of a scene."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from nrchain.comoving.relative import RelativeChain
from nrchain.notebook import record_html
from nrchain.states.cycles.cycle import MODES, TOLERANCE, Cycle, cycle_near
from nrchain.states.cycles.orbit import Orbit
from nrchain.states.varied import Line
from nrchain.wording import brief

COLUMNS = "values", "periods", "amplitudes", "multipliers", "unstable", "errors"
"""What a branch has of every cycle beside its orbit."""


@dataclass(frozen=True)
class SpecialCycle:
    """Where the stability of a branch of cycles changes, or where it turns back.

    Attributes
    ----------
    kind
        "fold", "pitchfork" or "transcritical" where a multiplier is 1; "period doubling" where it
        is −1; "Neimark–Sacker" where a pair crosses the unit circle.
    value, error
        p, and an estimate of its error.
    angle
        Of the multiplier on the unit circle, in radians.
    multiplicity
        How many multipliers, or pairs, cross at once.
    index
        It lies between the cycles ``index`` and ``index + 1`` of its branch.
    orbit
        The orbit next to it.
    """

    kind: str
    value: float
    error: float
    angle: float
    multiplicity: int
    index: int
    orbit: Orbit = field(repr=False)

    __repr__ = brief
    _repr_html_ = record_html


@dataclass(frozen=True)
class CycleBranch:
    """Cycles along a line of scenes, in order of the arclength.

    Attributes
    ----------
    line
        The scene and the ranges of its keys.
    values, periods, amplitudes
        (m,): p, T, and the largest distance of a sphere from its mean position.
    multipliers
        (m, k): the leading ones, without trivial ones.
    unstable
        (m,): how many multipliers are outside the unit circle.
    errors
        (m,): the largest distance of trivial multipliers from what they are.
    special
        Points where the stability changes.
    reasons
        Why the branch ends at its first and at its last cycle.
    origin, orbits
        o (3,), and the poses of all cycles.
    """

    line: Line
    values: np.ndarray
    periods: np.ndarray
    amplitudes: np.ndarray
    multipliers: np.ndarray
    unstable: np.ndarray
    errors: np.ndarray
    special: tuple[SpecialCycle, ...]
    reasons: tuple[str, str]
    origin: np.ndarray = field(repr=False)
    orbits: tuple[Orbit, ...] = field(repr=False)

    __repr__ = brief
    _repr_html_ = record_html

    def __len__(self) -> int:
        return len(self.values)

    @property
    def is_stable(self) -> np.ndarray:
        """(m,): whether no multiplier is outside the unit circle."""
        return self.unstable == 0

    def cycle(self, index: int, *, tolerance: float = TOLERANCE, modes: int = MODES) -> Cycle:
        """A cycle of the branch with its errors."""
        orbit, scene = self.orbits[index], self.line.at(float(self.values[index]))
        chain = RelativeChain(scene, orbit.base(0), self.origin)
        return cycle_near(chain, orbit, tolerance, modes)
