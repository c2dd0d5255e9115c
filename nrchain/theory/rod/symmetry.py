"""A → ± S·A: how symmetry operations act on strains, stresses and sources, and what they allow.

S maps the line of the rod to itself: S e₁ = σ e₁ with σ = ±1. An axial vector changes sign with
det S, and a polarity-dependent one with σ, because it is a derivative along the rod or acts
between its two sides (paper, Table signs). Each of the 28 constants of a transversely isotropic rod
then stays the same or changes sign under Rot, a half turn about an axis across the rod, and under
Ref, a mirror that contains the rod. A constant that changes sign under Rot is polar, one that
changes sign under Ref is chiral (paper, Sec. "Material symmetries" and Table syms). By Curie's
principle a rod with such a symmetry has none of these constants.

What breaks the symmetry of a chain is in :mod:`nrchain.theory.rod.slip_symmetry`; symmetries of
given constants are found in :mod:`nrchain.theory.rod.measured_symmetry`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from nrchain.notebook import record_html
from nrchain.theory.rod.constants import SYMBOLS, Constants
from nrchain.wording import brief

Matrix = NDArray[np.float64]


class Kind(NamedTuple):
    """How a vector changes: with the orientation of the rod, and as an axial vector."""

    polarity_dependent: bool
    axial: bool


STRAINS = Kind(True, False), Kind(True, True)
STRESSES = Kind(True, False), Kind(True, True)
SOURCES = Kind(False, False), Kind(False, True)
"""(ε, τ), (F, M) and (f, m): Table signs of the paper."""

QUARTER = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""A quarter turn about e₁. Blocks that it leaves unchanged are transversely isotropic."""

SAME = 1e-9
"""Relative error at which an axis counts as the image of another."""


class Class(NamedTuple):
    """Whether a constant changes sign under Rot (polar), and under Ref (chiral)."""

    polar: bool
    chiral: bool

    def __str__(self) -> str:
        return f"{'polar' if self.polar else 'apolar'}, {'chiral' if self.chiral else 'achiral'}"


def rot(angle: float = 0.0) -> Matrix:
    """The half turn about cos θ e₂ + sin θ e₃."""
    c, s = math.cos(2.0 * angle), math.sin(2.0 * angle)
    return np.array([[-1.0, 0.0, 0.0], [0.0, c, s], [0.0, s, -c]])


def ref(angle: float = 0.0) -> Matrix:
    """The mirror across the plane normal to cos θ e₂ + sin θ e₃, which contains the rod."""
    return -rot(angle)


def act(operation: Matrix, kinds: tuple[Kind, Kind]) -> Matrix:
    """The matrix (6, 6) by which S changes a pair of vectors: ± S for each."""
    along, handed = operation[0, 0], np.linalg.det(operation)
    pair = np.zeros((6, 6))
    for n, kind in enumerate(kinds):
        sign = (along if kind.polarity_dependent else 1.0) * (handed if kind.axial else 1.0)
        pair[3 * n : 3 * n + 3, 3 * n : 3 * n + 3] = sign * operation
    return pair


def transform(constants: Constants, operation: Matrix) -> Constants:
    """The constants of the material after an operation S on it."""
    return move(constants, *(act(operation, kinds) for kinds in (STRAINS, STRESSES, SOURCES)))


def move(constants: Constants, strain: Matrix, stress: Matrix, source: Matrix) -> Constants:
    """The constants after these matrices (6, 6) act on strains, stresses and sources."""
    return Constants(
        stress @ constants.C @ strain.T,
        source @ constants.H @ strain.T,
        stress @ constants.prestress,
        source @ constants.presource,
    )


def classes() -> dict[str, Class]:
    """The class of each of the 28 constants, from the action of Rot and Ref on its block."""
    return {
        symbol: Class(*(_sign(symbol, operation) < 0.0 for operation in (rot(), ref())))
        for symbol in SYMBOLS
    }


def _sign(symbol: str, operation: Matrix) -> float:
    """The factor ±1 by which an operation changes a constant."""
    return transform(Constants.named({symbol: 1.0}), operation).symbols()[symbol]


@dataclass(frozen=True)
class Symmetry:
    """The operations that leave a material unchanged.

    Attributes
    ----------
    isotropic
        Whether they include every rotation about e₁.
    operations
        Matrices (3, 3), one of each coset of those rotations if ``isotropic``, and otherwise all.
    """

    isotropic: bool
    operations: tuple[Matrix, ...]

    __repr__ = brief
    _repr_html_ = record_html

    @property
    def apolar(self) -> bool:
        """Whether a half turn about an axis across e₁ is a symmetry."""
        return self._has(along=-1.0, handed=1.0)

    @property
    def achiral(self) -> bool:
        """Whether a mirror that contains e₁ is a symmetry."""
        return self._has(along=1.0, handed=-1.0)

    @property
    def centred(self) -> bool:
        """Whether an operation that reverses both e₁ and hands is one: Rot and Ref together."""
        return self._has(along=-1.0, handed=-1.0)

    def _has(self, along: float, handed: float) -> bool:
        return any(
            S[0, 0] == along and math.isclose(np.linalg.det(S), handed) for S in self.operations
        )

    def group(self) -> tuple[Matrix, ...]:
        """All operations; of the rotations about e₁ the quarter turns, which are enough here."""
        if not self.isotropic:
            return self.operations
        turns = [np.linalg.matrix_power(QUARTER, n) for n in range(4)]
        return tuple(S @ turn for S in self.operations for turn in turns)

    def average(self, constants: Constants) -> Constants:
        """The part of the constants that all operations leave unchanged."""
        group = self.group()
        total = Constants.of()
        for operation in group:
            total = total + transform(constants, operation)
        return total * (1.0 / len(group))

    def allowed(self) -> Constants:
        """Which entries of C, H, (F̃, M̃) and (f̃, m̃) may differ from 0: arrays of booleans."""
        group = self.group()
        pairs = [[act(S, kinds) for S in group] for kinds in (STRAINS, STRESSES, SOURCES)]
        strain, stress, source = (np.array(matrices) for matrices in pairs)
        return Constants(
            _reached(np.einsum("gij,gkl->ikjl", stress, strain).reshape(36, 36)).reshape(6, 6),
            _reached(np.einsum("gij,gkl->ikjl", source, strain).reshape(36, 36)).reshape(6, 6),
            _reached(stress.sum(axis=0)),
            _reached(source.sum(axis=0)),
        )

    def symbols(self) -> tuple[str, ...]:
        """The constants that a transversely isotropic rod with this symmetry may have."""
        return tuple(s for s in SYMBOLS if all(_sign(s, S) > 0.0 for S in self.operations))

    def __str__(self) -> str:
        words = [
            "transversely isotropic" if self.isotropic else "not transversely isotropic",
            "apolar" if self.apolar else "polar",
            "achiral" if self.achiral else "chiral",
        ]
        if self.centred and not (self.apolar or self.achiral):
            words.append("unchanged by a mirror across e₁")
        return ", ".join(words)


def _reached(projector: Matrix) -> NDArray[np.bool_]:
    """Rows of a sum over the group that are not 0: entries that some invariant has."""
    return np.abs(projector).max(axis=1) > SAME * len(projector)
