"""value ± error: an estimate, and the least-squares line whose slope it is."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nrchain.analysis.measured_chain import Array, MeasurementError, real_number

FEWEST = 4
"""Snapshots that a fit of a line needs for its error to mean anything."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """value ± error, the error being one standard error."""

    value: float
    error: float

    def __str__(self) -> str:
        return f"{self.value:.6g} ± {self.error:.1g}"


def first_snapshot(time: Array, start: float | None) -> int:
    """Index of the first snapshot at or after ``start``; None stands for the first of all.

    Raises :class:`~nrchain.analysis.measured_chain.MeasurementError` if fewer than :data:`FEWEST`
    remain.
    """
    first = 0 if start is None else int(np.searchsorted(time, real_number("start", start)))
    if len(time) - first < FEWEST:
        when = "" if start is None else f" from t = {start:g} on"
        raise MeasurementError(f"{len(time) - first} snapshots{when}: at least {FEWEST} are needed")
    return first


def slope(t: Array, y: Array, systematic: float = 0.0) -> Estimate:
    """The slope of a line through y(t), with its standard error and a ``systematic`` one.

    The two errors are added in quadrature. Residuals with correlation ρ from one snapshot to the
    next count as n (1 − ρ)/(1 + ρ) independent ones.
    """
    n, x = len(t), t - t.mean()
    found = float(x @ y / (x @ x))
    rest = y - y.mean() - found * x
    square = float(rest @ rest)
    if square == 0.0:
        return Estimate(found, systematic)
    rho = min(max(float(rest[1:] @ rest[:-1]) / square, 0.0), 1.0)
    independent = max(n * (1.0 - rho) / (1.0 + rho), 3.0)
    scatter = math.sqrt(square / (independent - 2.0) / float(x @ x))
    return Estimate(found, math.hypot(scatter, systematic))
