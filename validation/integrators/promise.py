"""error ≤ 10 · rtol on nine scenes of ten: what a tolerance says of the error at the end of a run.

The steps of an integrator have the tolerance ``share`` · rtol. If it were c times as large, its
error at a given rtol would be that measured at c · rtol. Between two measured tolerances, the
logarithm of the error is interpolated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from validation.integrators.runs import Mapped, Run

FACTOR = 10.0
PART = 0.9
"""The bar: errors are at most ten times the tolerance on nine scenes of ten."""

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.9, 0.95)
FINEST_CALIBRATION, GRID = -4.0, 4
"""Smallest calibration as a power of ten, and calibrations in a decade."""


@dataclass(frozen=True)
class Calibrated:
    """Fractions of scenes and tolerances whose error is at most 10 · rtol, and within 10 of it.

    ``count`` is how many (scene, rtol) these are of.
    """

    factor: float
    below: float
    within: float
    count: int


def ratios(scenes: Sequence[Mapped], integrator: str, tolerance: float | None = None) -> np.ndarray:
    """error / tolerance of the completed runs, at one tolerance or at all."""
    runs = [run for one in scenes for run in one.completed(integrator)]
    return np.array([r.error / r.tolerance for r in runs if tolerance in (None, r.tolerance)])


def relative_ratios(scenes: Sequence[Mapped], integrator: str) -> np.ndarray:
    """As :func:`ratios`, but positions over atol + rtol · (the longest displacement in radii)."""
    return np.array(
        [
            max(run.position / (1.0 + one.path), run.frame) / run.tolerance
            for one in scenes
            for run in one.completed(integrator)
        ]
    )


def below(found: np.ndarray) -> float:
    """Part of the ratios that are at most :data:`FACTOR`."""
    return float(np.mean(found <= FACTOR)) if len(found) else np.nan


def within(found: np.ndarray) -> float:
    """Part of the ratios between 1/:data:`FACTOR` and :data:`FACTOR`."""
    return float(np.mean((found <= FACTOR) & (found >= 1.0 / FACTOR))) if len(found) else np.nan


def calibrate(scenes: Sequence[Mapped], integrator: str, factor: float) -> Calibrated:
    """What a calibration c keeps of the bar, over all rtol of whole decades that were measured."""
    found = []
    for one in scenes:
        runs = one.completed(integrator)
        found += _calibrated_ratios(runs, factor)
    values = np.array(found)
    return Calibrated(factor, below(values), within(values), len(values))


def _calibrated_ratios(runs: Sequence[Run], factor: float) -> list[float]:
    """error(c · rtol) / rtol for the rtol from 1e-1 to 1e-12 with a measured c · rtol."""
    if not runs:
        return []
    at = np.log10([run.tolerance for run in runs])[::-1]
    errors = np.log10([max(run.error, 1e-300) for run in runs])[::-1]
    wanted = np.arange(-12.0, 0.0)
    inner = wanted + np.log10(factor)
    kept = (inner >= at[0] - 1e-9) & (inner <= at[-1] + 1e-9)
    return list(10.0 ** (np.interp(inner[kept], at, errors) - wanted[kept]))


def largest_calibration(scenes: Sequence[Mapped], integrator: str) -> Calibrated | None:
    """The largest c with an error of at most 10 · rtol on nine scenes of ten; None if there is
    none above 1e-4."""
    for factor in _factors():
        found = calibrate(scenes, integrator, factor)
        if found.below >= PART:
            return found
    return None


def closest_calibration(scenes: Sequence[Mapped], integrator: str) -> Calibrated:
    """The c with which most scenes have an error within a factor of 10 of rtol, either way."""
    return max(
        (calibrate(scenes, integrator, factor) for factor in _factors()),
        key=lambda found: found.within,
    )


def _factors() -> np.ndarray:
    return 10.0 ** np.arange(1.0, FINEST_CALIBRATION - 1e-9, -1.0 / GRID)


def seconds_at(runs: Sequence[Run], error: float) -> float:
    """Processor time of an integrator at an error, interpolated; NaN if it does not get there.

    Where its loosest run has a smaller error, the time of that run.
    """
    for looser, tighter in zip((None, *runs), runs, strict=False):
        if tighter.error <= error:
            if looser is None:
                return tighter.seconds
            ends = np.log([tighter.error, looser.error])
            times = np.log([tighter.seconds, looser.seconds])
            return float(np.exp(np.interp(np.log(error), ends, times)))
    return np.nan


def speed(scenes: Sequence[Mapped], integrator: str, other: str, error: float) -> tuple[float, int]:
    """Time over that of another integrator at an error: geometric mean, and number of scenes."""
    pairs = [
        [seconds_at(one.completed(name), error) for name in (integrator, other)] for one in scenes
    ]
    logs = [np.log(mine / theirs) for mine, theirs in pairs]
    logs = [value for value in logs if np.isfinite(value)]
    return (float(np.exp(np.mean(logs))) if logs else np.nan), len(logs)
