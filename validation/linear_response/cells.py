"""Cells of a linear operator, such as force per displacement, and their orders in qd."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from nrchain.theory.rod.linear import ACROSS, ALONG, DISCRETE, Term, X

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

ROWS = {"force": slice(0, 3), "torque": slice(3, 6)}
COLUMNS = {"u": slice(0, 3), "φ": slice(3, 6)}
CELLS = [(row, column) for row in ROWS for column in COLUMNS]
TENSORS = {"I-3xx": np.eye(3) - 3 * ALONG, "x×": X, "⊥": ACROSS}


class Leftover(NamedTuple):
    """(rod − lattice)/lattice of a cell: coefficient · (qd)^order."""

    coefficient: float
    order: int
    written: str
    source: str


_SECOND = Leftover(1 / 12, 2, "1/12", "2(1 − cos θ) = θ² − θ⁴/12 + …")
_DIFFERENCE = Leftover(1 / 6, 2, "1/6", "2 sin θ = 2θ − θ³/3 + …")
_SUM = Leftover(1 / 24, 4, "1/24", "2 cos θ = 2 − θ² + θ⁴/12 − …, the second order being kept")
_SUM_AND_SPIN = Leftover(1 / 40, 4, "1/40", "(2·1089/20)/(2·1089/20 + 363/5) of that of a sum")

CONTINUUM_CELLS = {
    ("2s", "force", "u"): _SECOND,
    ("2s", "torque", "u"): _DIFFERENCE,
    ("2s", "torque", "φ"): _SUM,
    ("3a", "force", "u"): _DIFFERENCE,
    ("3a", "force", "φ"): _SUM,
    ("3a", "torque", "u"): _SECOND,
    ("3a", "torque", "φ"): _DIFFERENCE,
    ("3t", "force", "u"): _DIFFERENCE,
    ("3t", "force", "φ"): _SUM,
    ("4a", "force", "u"): _SECOND,
    ("4a", "force", "φ"): _DIFFERENCE,
    ("4a", "torque", "u"): _DIFFERENCE,
    ("4a", "torque", "φ"): _SUM_AND_SPIN,
}
"""Truncation error of the second-order rod in each cell."""


def cell(operator: Complex, row: str, column: str) -> Complex:
    """The (..., 3, 3) part of an operator (..., 6, 6)."""
    return operator[..., ROWS[row], COLUMNS[column]]


def stencil(name: str, phases: Array) -> Complex:
    """Factor of exp(iqx) under a difference of neighbours, at qd."""
    waves = {
        "second": -2.0 * (1.0 - np.cos(phases)),
        "difference": 2j * np.sin(phases),
        "sum": 2.0 * np.cos(phases),
        "self": np.ones_like(phases),
    }
    return waves[name].astype(complex)


def coefficient(operator: Complex, label: str, term: Term, phases: Array) -> float:
    """The coefficient of a term in its cell, by least squares over all phases and components."""
    beside = [t for t in DISCRETE[label] if (t.row, t.of) == (term.row, term.of)]
    basis = [stencil(t.stencil, phases)[:, None, None] * TENSORS[t.tensor] for t in beside]
    columns = np.stack([part.ravel() for part in basis], axis=1)
    target = cell(operator, term.row, term.of).ravel()
    found = np.linalg.lstsq(columns, target, rcond=None)[0]
    return float(found[beside.index(term)].real)


def order_of(phases: Array, difference: Array, order: int) -> tuple[float, float]:
    """The slope of ln |difference| between two phases, and the limit of difference/θ^order.

    The limit is extrapolated to θ = 0 from both phases; the next order is two higher.
    """
    slope = np.diff(np.log(np.abs(difference)))[0] / np.diff(np.log(phases))[0]
    share = np.asarray(difference) / phases**order
    squares = phases**2
    limit = (share[0] * squares[1] - share[1] * squares[0]) / (squares[1] - squares[0])
    return float(slope), float(limit)
