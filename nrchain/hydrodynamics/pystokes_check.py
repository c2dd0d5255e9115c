"""|PyStokes − closed form| ≤ 10⁻¹² |closed form|: the self-check of the PyStokes backend."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np

from nrchain.errors import BackendError
from nrchain.hydrodynamics import slip_modes
from nrchain.hydrodynamics.pystokes import (
    MOBILITIES,
    PI,
    RELEASES,
    Array,
    ModeRoutines,
    Routine,
    irreducible_tensor,
    library,
    radius_power,
    sum_flow,
    sum_mobility,
)

TOLERANCE = 1e-12
"""The largest error, relative to the closed form, that passes the check."""


def check(version: str | None = None) -> None:
    """|PyStokes − closed form| ≤ 10⁻¹² |closed form| for each routine of the tables, on one pair.

    ``version`` is the release whose table is checked, by default that of the installed PyStokes.
    Raises :class:`~nrchain.errors.BackendError`, with the ratios and misfits measured, when there
    is no such table or the installed PyStokes does not follow it.
    """
    version = library().__version__ if version is None else version
    latest = list(RELEASES)[-1]
    known = version if version in RELEASES else latest
    measured = [
        _measure(label, mode, quantity)
        for label, mode in RELEASES[known].items()
        for quantity in ("velocity", "finite_size", "spin")
        if getattr(mode, quantity) is not None
    ]
    measured += [_measure_mobility(method, PI[known]) for method in MOBILITIES]
    if version not in RELEASES:
        verdict = f"is a release whose factors are unknown (known: {', '.join(RELEASES)})"
    elif not all(agrees for agrees, _ in measured):
        verdict = "does not follow the factors known for that release"
    else:
        return
    rows = "; ".join(text for _, text in measured)
    raise BackendError(
        f"PyStokes {version} {verdict}; use the native backend, or install pystokes=={latest}. "
        f"Measured on one pair, as a multiple of the closed form: {rows}"
    )


def _measure(label: str, mode: ModeRoutines, quantity: str) -> tuple[bool, str]:
    """Whether a row of the table holds on one pair at two radii, and the result in words."""
    routine: Routine = getattr(mode, quantity)
    name = f"{label} {quantity.replace('_', '-')} by {routine.method}"
    centres = np.array([[0.0, 0.0, 0.0], [1.7, -2.1, 1.3]])
    axes = np.array([[2.0, 3.0, 6.0], [6.0, -2.0, 3.0]]) / 7.0
    strengths = np.array([1.1, -0.7])
    tensor = irreducible_tensor(mode.rank, axes, strengths)
    outputs, laws = [], []
    for radius in (1.0, 0.6):
        try:
            output = sum_flow(routine, centres.T, tensor, "all", radius, viscosity=1.0)
        except (AttributeError, TypeError, ValueError) as error:
            return False, f"{name} fails: {error}"
        outputs.append(output.T * radius ** radius_power(label))
        for i, j in ((0, 1), (1, 0)):
            law = _closed_form(label, quantity, centres[i] - centres[j], axes[j], radius)
            laws.append(strengths[j] * law)
    return _compare(name, outputs, laws, routine.ratio)


def _measure_mobility(method: str, pi: float) -> tuple[bool, str]:
    """Whether a mobility routine returns μ at two radii, and the result in words."""
    centres = np.array([[0.0, 0.0, 0.0], [1.7, -2.1, 1.3]])
    causes = np.array([[1.1, -0.7, 0.4], [0.3, 0.9, -1.2]])
    outputs, laws = [], []
    for radius in (1.0, 0.6):
        try:
            output = sum_mobility(method, centres.T, causes.T, "all", radius, viscosity=1.3)
        except (AttributeError, TypeError, ValueError) as error:
            return False, f"{method} fails: {error}"
        outputs.append(output.T * (pi / np.pi))
        for i, j in ((0, 1), (1, 0)):
            own, pair = _mobility_of_a_pair(method, centres[i] - centres[j], radius, 1.3)
            laws.append(own * causes[i] + pair @ causes[j])
    return _compare(method, outputs, laws, Fraction(1))


def _compare(name: str, outputs: Any, laws: Any, known: Fraction) -> tuple[bool, str]:
    """Whether outputs are ``known`` times the laws, and the result in words."""
    found, expected = np.ravel(outputs), np.ravel(laws)
    ratio, scale = found @ expected / (expected @ expected), np.max(np.abs(expected))
    misfit = np.max(np.abs(found - ratio * expected)) / scale
    deviation = np.max(np.abs(found - float(known) * expected)) / scale
    text = f"{name} {ratio:.6g} where {known} is known, misfit {misfit:.0e}"
    return bool(deviation <= TOLERANCE * abs(known)), text


def _mobility_of_a_pair(
    method: str, separation: Array, radius: float, viscosity: float
) -> tuple[float, Array]:
    """A sphere's own mobility and the matrix of a pair: Rotne, Prager and Yamakawa, apart."""
    r = float(np.linalg.norm(separation))
    n, a = separation / r, radius
    nn, unit = np.outer(n, n), np.eye(3)
    scale = 1.0 / (8 * np.pi * viscosity)
    if method == "mobilityTT":
        pair = ((1 + 2 * a**2 / (3 * r**2)) * unit + (1 - 2 * a**2 / r**2) * nn) / r
        return 4 * scale / (3 * a), scale * pair
    if method == "mobilityRR":
        return scale / a**3, scale * (3 * nn - unit) / (2 * r**3)
    return 0.0, scale * np.cross(unit, n).T / r**2


def _closed_form(label: str, quantity: str, separation: Array, axis: Array, radius: float) -> Array:
    """Σ (a/r)^k P(c) b: the law of a mode of unit strength, at ``separation`` from its sphere."""
    mode = slip_modes.find(label)
    if quantity == "spin":
        table, unit = mode.spin(), 1.0 / radius
    else:
        table, unit = mode.flow(finite_size=quantity == "finite_size"), 1.0
    r = float(np.linalg.norm(separation))
    n = separation / r
    basis = {"n": n, "e": axis, "x": np.cross(axis, n)}
    result = np.zeros(3)
    for (b, k), row in table.items():
        polynomial = np.polynomial.Polynomial([float(p) for p in row])
        result += unit * (radius / r) ** k * polynomial(axis @ n) * basis[b]
    return result
