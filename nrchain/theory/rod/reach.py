"""Λ_k/Λ_1: the active rate of a chain with k neighbours over that with nearest neighbours.

The flow of a mode at distance m d is that at d with its strength divided by a power of m and θ = qd
replaced by mθ. In the beam limit φ = x̂ × u′, and at leading order in a/d only the active force
contributes. With Σ over m = 1 … k, or to infinity, and κ(θ) = d C¹/i C⁰ = θ + 3θ⁵/160 + … the slope
of an unsheared chain,

    2s            Σ (1 − cos mθ)/m³
    3a            Σ κ cos(mθ)/m³ − sin(mθ)/m⁴
    3t            Σ 3 sin(mθ)/m⁴ − κ cos(mθ)/m³
    4a            Σ κ sin(mθ)/m⁴ − (1 − cos mθ)/m⁵
    2s along x    Σ (1 − cos mθ)/m³
    3t along x    Σ sin(mθ)/m⁴

each over its first term. All pairs are polylogarithms, from :mod:`nrchain.theory.lattice_sums`.

For θ → 0 the sums of all pairs over the first terms tend to

    2s  3/2 − ln θ      3t  ζ(3) − θ²/12
    3a  4/3 − ln θ      4a  ζ(3) + θ² (ln θ − 7/4 + ζ(3))/4

and along x to 3/2 − ln θ for 2s and ζ(3) for 3t. The third order of 3t, which vanishes for every
single distance, does not vanish for the sum of all: the terms of higher order in mθ sum to
−(1/6) θ³, beside 2ζ(3) θ. The limits θ → 0 and k → ∞ do not commute.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nrchain.errors import SceneError
from nrchain.theory.lattice_sums import (
    MOST_TERMS,
    Reach,
    cosine_defect,
    cosine_sum,
    power_sum,
    sine_sum,
)
from nrchain.theory.rod.linear import differences

Real = NDArray[np.float64]
Direction = Literal["transverse", "longitudinal"]

KINDS = (
    ("2s", "transverse"),
    ("3a", "transverse"),
    ("3t", "transverse"),
    ("4a", "transverse"),
    ("2s", "longitudinal"),
    ("3t", "longitudinal"),
)
"""The waves with an active rate."""


def reach_sum(
    mode: str, phases: ArrayLike, reach: Reach = "all", direction: Direction = "transverse"
) -> Real:
    """The sum of a mode over ``reach`` neighbours at phases θ = qd, in the shape of ``phases``."""
    _check(mode, direction)
    theta = np.asarray(phases, float)
    if mode == "2s":
        return cosine_defect(3, theta, reach)
    if direction == "longitudinal":
        return sine_sum(4, theta, reach)
    first, mean = differences(theta)
    slope = first.imag / mean
    if mode == "4a":
        return slope * sine_sum(4, theta, reach) - cosine_defect(5, theta, reach)
    if mode == "3a":
        return slope * cosine_sum(3, theta, reach) - sine_sum(4, theta, reach)
    return 3.0 * sine_sum(4, theta, reach) - slope * cosine_sum(3, theta, reach)


def reach_ratio(
    mode: str, phases: ArrayLike, reach: Reach = "all", direction: Direction = "transverse"
) -> Real:
    """Λ_k/Λ_1, the active rate with k neighbours over that with the nearest, at phases θ = qd."""
    return reach_sum(mode, phases, reach, direction) / reach_sum(mode, phases, 1, direction)


def reach_limit(mode: str, phases: ArrayLike, direction: Direction = "transverse") -> Real:
    """The limit θ → 0 of :func:`reach_ratio` for all pairs: see the module."""
    _check(mode, direction)
    theta = np.abs(np.asarray(phases, float))
    logarithm, zeta = np.log(theta), power_sum(3)
    if mode == "2s":
        return 1.5 - logarithm
    if mode == "3a":
        return 4.0 / 3.0 - logarithm
    if direction == "longitudinal":
        return np.full(theta.shape, zeta)
    if mode == "3t":
        return zeta - theta**2 / 12.0
    return zeta + theta**2 * (logarithm - 1.75 + zeta) / 4.0


def neighbours_needed(
    mode: str, phase: float, error: float, direction: Direction = "transverse"
) -> int:
    """The least k from which on the rate stays within a relative ``error`` of that of all pairs."""
    _check(mode, direction)
    if not 0.0 < error < 1.0:
        raise SceneError("error", error, "must lie between 0 and 1")
    target = float(reach_sum(mode, phase, "all", direction))
    reach = 64
    while reach <= MOST_TERMS:
        sums = _partial_sums(mode, phase, reach, direction)
        outside = np.flatnonzero(np.abs(sums / target - 1.0) >= error)
        last = outside[-1] + 1 if len(outside) else 0
        # the sums oscillate with the phase: accept the last crossing only well inside the range
        if last < reach // 2 and reach * abs(phase) > 2.0 * math.pi:
            return int(last) + 1
        reach *= 2
    raise SceneError("error", error, f"takes more than {MOST_TERMS} neighbours at this phase")


def _partial_sums(mode: str, phase: float, reach: int, direction: Direction) -> Real:
    """:func:`reach_sum` for 1, 2, … ``reach`` neighbours."""
    m = np.arange(1.0, reach + 1)
    first, mean = differences(np.asarray(phase))
    slope = float(first.imag / mean)
    defect = 2.0 * np.sin(m * phase / 2.0) ** 2
    cosine, sine = np.cos(m * phase), np.sin(m * phase)
    if mode == "2s":
        terms = defect / m**3
    elif direction == "longitudinal":
        terms = sine / m**4
    elif mode == "3a":
        terms = slope * cosine / m**3 - sine / m**4
    elif mode == "3t":
        terms = 3.0 * sine / m**4 - slope * cosine / m**3
    else:
        terms = slope * sine / m**4 - defect / m**5
    return np.cumsum(terms)


def _check(mode: str, direction: Direction) -> None:
    if (mode, direction) not in KINDS:
        known = ", ".join(f"{m} {d}" for m, d in KINDS)
        raise SceneError("mode", f"{mode} {direction}", f"active rates are those of {known}")
