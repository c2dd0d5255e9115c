"""w(s, t) = A exp(iqs + Λ(t − t₀)): one fit of a wave to all snapshots."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nrchain.analysis.measure.line_fit import Estimate
from nrchain.analysis.measure.rates import LARGEST_MISFIT, Rate, rate
from nrchain.analysis.measure.waves import Kind, component, wave
from nrchain.analysis.measured_chain import (
    Array,
    MeasurementError,
    real_number,
    require_trajectory,
)
from nrchain.notebook import record_html
from nrchain.trajectory.trajectory import Trajectory
from nrchain.wording import brief


@dataclass(frozen=True, slots=True)
class ShapeFit:
    """A exp(iqs + Λ(t − start)) fitted to all snapshots at once.

    ``misfit`` is the root mean square of the residual, relative to that of the shape: 0 for a
    perfect wave, near 1 where there is none.
    """

    rate: Rate
    amplitude: complex
    misfit: float

    __repr__ = brief
    _repr_html_ = record_html


def fit_shape(
    trajectory: Trajectory,
    wavenumber: float | None = None,
    kind: Kind = "right",
    *,
    start: float | None = None,
    most_misfit: float = LARGEST_MISFIT,
) -> ShapeFit:
    """w(s, t) = A exp(iqs + Λ(t − t₀)): a growing, decaying, travelling or rotating wave.

    One nonlinear least-squares fit of A and Λ to the shape at all snapshots from ``start`` on (for
    "x", "y" and "z" to the real part), as the paper reads its open chains (Appendix D). Rigid
    motions stay in, and the largest snapshots weigh most. ``start`` as in :func:`rate`.

    Errors are those of the fit, as if the residuals of spheres and snapshots were independent. The
    ends of an open chain leave residuals that are not: look at ``misfit``.

    Raises :class:`~nrchain.analysis.measured_chain.MeasurementError` for a misfit above
    ``most_misfit``, and as :func:`rate`.
    """
    chain = require_trajectory(trajectory).scene.chain
    real_number("most_misfit", most_misfit, most=math.inf)
    first_guess = wave(trajectory, wavenumber, kind, rigid=kind == "x")
    guess = rate(first_guess, start, most_misfit=math.inf)
    s = chain.spacing * np.arange(chain.particles)
    field = component(trajectory, kind, "displacement", s)
    if kind == "x":
        field = field - field.mean(axis=1, keepdims=True)
    used = trajectory.time >= guess.start
    amplitude, growth, frequency, misfit = _fit_wave(
        field[used],
        np.exp(1j * guess.wavenumber * s),
        trajectory.time[used] - guess.start,
        (first_guess.amplitude[used][0], guess.value),
    )
    if misfit > most_misfit:
        raise MeasurementError(
            f"the misfit of the best wave of wavenumber {guess.wavenumber:.6g} is {misfit:.2g} of "
            f"the shape; above {most_misfit:g} the fit says nothing about it: fit another kind of "
            "wave or other times, or raise most_misfit"
        )
    fitted = Rate(
        growth, frequency, guess.wavenumber, guess.start, misfit, float(trajectory.time[-1])
    )
    return ShapeFit(fitted, amplitude, misfit)


def _fit_wave(
    field: NDArray[Any], carrier: NDArray[Any], t: Array, guess: tuple[complex, complex]
) -> tuple[complex, Estimate, Estimate, float]:
    """A, Re Λ, Im Λ and the misfit of A e^{Λt} carrier, the best fit to ``field`` (T, N).

    ``carrier`` (N,) is exp(iqs), ``t`` (T,) begins at 0, and ``guess`` is (A, Λ). The misfit is
    relative to the field.
    """
    from scipy.optimize import curve_fit

    data = _as_real_row(field)
    span, size = t[-1], math.sqrt(np.mean(data**2))

    def shape_of(p: Sequence[float], factor: complex | NDArray[Any]) -> Array:
        history = factor * np.exp((p[2] + 1j * p[3]) * t / span)
        shape = history[:, None] * carrier
        return _as_real_row(shape if np.iscomplexobj(field) else shape.real)

    def model(_: object, *p: float) -> Array:
        return shape_of(p, p[0] + 1j * p[1])

    def derivative(_: object, *p: float) -> Array:
        size_and_phase = (p[0] + 1j * p[1]) * t / span
        factors = (1.0, 1j, size_and_phase, 1j * size_and_phase)
        return np.stack([shape_of(p, factor + 0.0 * t) for factor in factors], axis=1)

    amplitude, rate_guess = guess[0] / size, guess[1]
    p0 = [amplitude.real, amplitude.imag, rate_guess.real * span, rate_guess.imag * span]
    found, covariance = curve_fit(model, None, data / size, p0=p0, jac=derivative)
    errors = np.sqrt(np.diag(covariance)) / span
    misfit = math.sqrt(np.mean((data / size - model(None, *found)) ** 2))
    growth, frequency = (Estimate(float(found[k] / span), float(errors[k])) for k in (2, 3))
    return complex(found[0], found[1]) * size, growth, frequency, misfit


def _as_real_row(values: NDArray[Any]) -> Array:
    """All numbers in one row: the real parts, then the imaginary ones if there are any."""
    flat = values.ravel()
    return np.concatenate([flat.real, flat.imag]) if np.iscomplexobj(flat) else flat
