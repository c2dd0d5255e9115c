"""(F, M) = (F̃, M̃) + C·(ε, τ) and (f⋆, m⋆) = (f̃, m̃) + H·(ε, τ): the constants of a linear rod.

All vectors have components in the moving frame, e₁ along the rod. A 3×3 block K of a transversely
isotropic rod has three constants,

    K·A = K∥ A₁ e₁ + K⊥ (A − A₁ e₁) + K↺ e₁ × A,

and its affine parts lie along e₁: 8 blocks and 4 affine parts make 28 constants. Symbols are the
paper's in ASCII: ``C_perp_F_eps`` for C_⊥^{Fε}, ``odd`` for ↺, ``F_pre`` for F̃∥.

Source: paper, Eqs. (rod_force_strain_const) to (transverse_isotropy). The matrix that the paper
prints for K has −K↺ for K↺; its vector form and all its equations of motion have e₁ × A, as here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from nrchain.inputs.arguments import finite_array
from nrchain.inputs.names import Named, unknown_name

ALONG = np.diag([1.0, 0.0, 0.0])
ACROSS = np.diag([0.0, 1.0, 1.0])
TURN = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""e₁ ×"""

TENSORS = {"par": ALONG, "perp": ACROSS, "odd": TURN}
"""∥, ⊥ and ↺ of a block."""

HALF = {name: slice(3 * n, 3 * n + 3) for n, name in ((0, "F"), (1, "M"), (0, "f"), (1, "m"))}
HALF |= {"eps": slice(0, 3), "tau": slice(3, 6)}
"""Rows of stresses and sources, and columns of strains."""

BLOCKS = tuple(
    (matrix, row, column)
    for matrix, rows in (("C", "FM"), ("H", "fm"))
    for row in rows
    for column in ("eps", "tau")
)
"""The 8 blocks: matrix, row and column."""

AFFINE = {"F_pre": "prestress", "M_pre": "prestress", "f_pre": "presource", "m_pre": "presource"}

SYMBOLS = (
    *AFFINE,
    *(f"{matrix}_{part}_{row}_{column}" for matrix, row, column in BLOCKS for part in TENSORS),
)
"""The 28 constants of a transversely isotropic rod."""


@dataclass(frozen=True, eq=False)
class Constants:
    """C, H (6, 6), (F̃, M̃) and (f̃, m̃) (6,) in the moving frame.

    Rows are (F, M) or (f, m), columns (ε, τ). Forces per length of the rod at rest.
    """

    C: np.ndarray
    H: np.ndarray
    prestress: np.ndarray
    presource: np.ndarray

    def __repr__(self) -> str:
        return f"<Constants: the largest {self.largest():.6g}>"

    @classmethod
    def of(
        cls,
        C: ArrayLike | None = None,
        H: ArrayLike | None = None,
        prestress: ArrayLike | None = None,
        presource: ArrayLike | None = None,
    ) -> Self:
        """Constants from numbers; those that are left out are 0."""
        given = {"C": C, "H": H, "prestress": prestress, "presource": presource}
        shapes = {"C": (6, 6), "H": (6, 6), "prestress": (6,), "presource": (6,)}
        return cls(
            **{
                name: np.zeros(shapes[name])
                if value is None
                else finite_array(name, value, shapes[name]).copy()
                for name, value in given.items()
            }
        )

    @classmethod
    def named(cls, values: Mapping[str, float]) -> Self:
        """The transversely isotropic constants of these symbols; all others are 0.

        Raises :class:`~nrchain.errors.UnknownNameError` for a symbol that is none of
        :data:`SYMBOLS`.
        """
        found = cls.of()
        for symbol, value in values.items():
            if symbol not in SYMBOLS:
                raise unknown_name(symbol, SYMBOLS)
            array, index, tensor = place(symbol)
            getattr(found, array)[index] += float(value) * tensor
        return found

    def symbols(self) -> dict[str, float]:
        """The 28 constants by symbol: the transversely isotropic part of the blocks."""
        values = {}
        for symbol in SYMBOLS:
            array, index, tensor = place(symbol)
            part = getattr(self, array)[index]
            values[symbol] = float(np.sum(part * tensor) / np.sum(tensor * tensor))
        return Named(values)

    def symbol_bounds(self) -> dict[str, float]:
        """Bounds of the errors of :meth:`symbols`, for bounds of the errors of the entries."""
        values = {}
        for symbol in SYMBOLS:
            array, index, tensor = place(symbol)
            size = np.abs(tensor)
            values[symbol] = float(np.sum(getattr(self, array)[index] * size) / np.sum(size))
        return Named(values)

    def map(self, function: Callable[..., Any], *others: Constants) -> Self:
        """``function`` of each array, and of those of ``others``."""
        every: tuple[Constants, ...] = (self, *others)
        return type(self)(*map(function, *map(parts_of, every)))

    def __add__(self, other: Constants) -> Self:
        return self.map(np.add, other)

    def __sub__(self, other: Constants) -> Self:
        return self.map(np.subtract, other)

    def __mul__(self, factor: float) -> Self:
        return self.map(lambda values: factor * values)

    __rmul__ = __mul__

    def largest(self) -> float:
        """The largest absolute value of an entry."""
        return max(float(np.abs(values).max()) for values in parts_of(self))


def parts_of(constants: Constants) -> tuple[np.ndarray, ...]:
    """C, H, (F̃, M̃) and (f̃, m̃)."""
    return constants.C, constants.H, constants.prestress, constants.presource


def place(symbol: str) -> tuple[str, Any, np.ndarray]:
    """Array, index and tensor of a symbol: the array has value · tensor at the index."""
    if symbol in AFFINE:
        return AFFINE[symbol], HALF[symbol[0]], np.array([1.0, 0.0, 0.0])
    matrix, part, row, column = symbol.split("_")
    return matrix, (HALF[row], HALF[column]), TENSORS[part]


def cross(vector: ArrayLike) -> np.ndarray:
    """The matrix of A ↦ v × A."""
    x, y, z = np.asarray(vector, float)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
