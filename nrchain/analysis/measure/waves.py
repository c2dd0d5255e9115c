"""A(t) of a plane wave: by projection on a periodic chain, by least squares on an open one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from nrchain.analysis.measured_chain import (
    NOISE,
    Array,
    MeasurementError,
    positions_of,
    real_number,
    require_trajectory,
)
from nrchain.errors import shorten
from nrchain.notebook import record_html
from nrchain.trajectory.trajectory import Trajectory
from nrchain.wording import brief

Kind = Literal["right", "left", "y", "z", "x"]
Quantity = Literal["displacement", "tilt", "shear"]


@dataclass(frozen=True, slots=True, eq=False)
class Wave:
    """A(t) of one plane wave.

    Attributes
    ----------
    time
        (T,).
    amplitude
        (T,) complex: a length, or an angle for tilts and shears.
    misfit
        (T,) root mean square of the residual, without the wave (and the rigid motion, if fitted).
    wavenumber
        q, in 1/length.
    projected
        Whether the wave fits a periodic chain. A is then its Fourier component, and the residual
        holds other waves, which do not change A.
    noise
        (T,) uncertainty of the amplitude from the tolerances of the run.
    """

    time: Array
    amplitude: NDArray[np.complex128]
    misfit: Array
    wavenumber: float
    projected: bool = False
    noise: Array | float = 0.0

    __repr__ = brief
    _repr_html_ = record_html


def wave(
    trajectory: Trajectory,
    wavenumber: float | None = None,
    kind: Kind = "right",
    *,
    of: Quantity = "displacement",
    rigid: bool = True,
) -> Wave:
    """A(t) = Σ_i w_i exp(−iqs_i)/N, for w = y ± iz; twice the real field for "x", "y" and "z".

    On a periodic chain that holds a whole number of wavelengths this Fourier projection is exact:
    other waves do not change A. On open chains plane waves are not orthogonal, and A is the
    least-squares fit to each snapshot.

    Parameters
    ----------
    wavenumber
        q, in 1/length; when None, that of the start of the scene. Its sign is the direction.
    kind
        Which component, see :mod:`nrchain.measure`.
    of
        ``"displacement"``; ``"tilt"``, the part of e₁ across x; or ``"shear"``, the tilt of the
        midpoint frames against the midpoint tangents, with the stencils of the elastic potential
        (paper, Appendix B). Only displacements have a kind "x".
    rigid
        On open chains: whether the fit takes out the mean and the slope of each snapshot.

    Raises :class:`~nrchain.analysis.measured_chain.MeasurementError` for a wave too short for the
    lattice, |q| d > π.
    """
    chain = require_trajectory(trajectory).scene.chain
    q = trajectory.scene.wavevector if wavenumber is None else real_number("wavenumber", wavenumber)
    s = chain.spacing * np.arange(chain.particles)
    if not isinstance(of, str) or of not in get_args(Quantity):
        raise MeasurementError(f"of = {shorten(of)}: must be 'displacement', 'tilt' or 'shear'")
    if not 0.0 < abs(q) * chain.spacing <= math.pi * (1.0 + 1e-12):
        raise MeasurementError(
            f"wavenumber = {q:.6g}: |q| d must lie above 0 and at most at π, with d = "
            f"{chain.spacing:g}"
        )
    if of == "shear":
        # on a plane wave each stencil is a factor, at midpoints as at spheres
        bent = wave(trajectory, q, kind, rigid=rigid)
        tilted = wave(trajectory, q, kind, of="tilt", rigid=rigid)
        half = q * chain.spacing / 2.0
        mean = 9.0 / 8.0 * math.cos(half) - math.cos(3.0 * half) / 8.0
        slope = (9.0 / 4.0 * math.sin(half) - math.sin(3.0 * half) / 12.0) / chain.spacing
        amplitude = mean * tilted.amplitude - 1j * slope * bent.amplitude
        misfit = np.hypot(mean * tilted.misfit, slope * bent.misfit)
        noise = np.hypot(mean * tilted.noise, slope * bent.noise)
        return Wave(trajectory.time, amplitude, misfit, q, bent.projected, noise)
    field = component(trajectory, kind, of, s)
    turns = q * trajectory.scene.length / (2.0 * math.pi)
    fits = chain.ends == "periodic" and abs(turns - round(turns)) < 1e-9
    amplitude, misfit = _project(field, q, s) if fits else _fit_snapshots(field, q, s, rigid)
    run, unit = trajectory.scene.run, chain.radius if of == "displacement" else 1.0
    noise = NOISE * (run.atol * unit + run.rtol * misfit)
    return Wave(trajectory.time, amplitude, misfit, q, fits, noise)


def component(trajectory: Trajectory, kind: Kind, of: Quantity, s: Array) -> NDArray[Any]:
    """(T, N) y ± iz, y, z or x − s, of positions or of e₁."""
    if not isinstance(kind, str) or kind not in get_args(Kind) or (kind, of) == ("x", "tilt"):
        allowed = "must be 'right', 'left', 'y', 'z' or, for displacements, 'x'"
        raise MeasurementError(f"kind = {shorten(kind)}: {allowed}")
    vectors = positions_of(trajectory) if of == "displacement" else trajectory.frames[:, :, 0]
    if kind in ("right", "left"):
        return vectors[..., 1] + (1j if kind == "right" else -1j) * vectors[..., 2]
    if kind in ("y", "z"):
        return vectors[..., "xyz".index(kind)]
    return vectors[..., 0] - s


def _project(field: NDArray[Any], q: float, s: Array) -> tuple[NDArray[np.complex128], Array]:
    """The discrete Fourier component, and the root mean square of all others except the mean."""
    amplitude = field @ np.exp(-1j * q * s) / len(s)
    shape = amplitude[:, None] * np.exp(1j * q * s)
    if not np.iscomplexobj(field):
        twin = abs(abs(q) * (s[1] - s[0]) - math.pi) > 1e-9  # at π/d the wave is its own mirror
        amplitude, shape = amplitude * (1 + twin), shape.real * (1 + twin)
    rest = field - field.mean(axis=1, keepdims=True) - shape
    return amplitude, np.sqrt(np.mean(np.abs(rest) ** 2, axis=1))


def _fit_snapshots(
    field: NDArray[Any], q: float, s: Array, rigid: bool
) -> tuple[NDArray[np.complex128], Array]:
    """The least-squares amplitude in each snapshot, with a mean and a slope if ``rigid``."""
    complex_field = np.iscomplexobj(field)
    carrier = np.exp(1j * q * s)
    columns = [carrier] if complex_field else [carrier.real, -carrier.imag]
    if rigid:
        columns += [np.ones(len(s)), (s - s.mean()) / s[-1]]
    basis = np.stack(columns, axis=1)
    found = np.linalg.lstsq(basis, field.T, rcond=None)[0]
    misfit = np.sqrt(np.mean(np.abs(field.T - basis @ found) ** 2, axis=0))
    return (found[0] if complex_field else found[0] + 1j * found[1]), misfit
