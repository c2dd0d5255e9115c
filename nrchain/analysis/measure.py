"""A(t) exp(iqs), Λ, V, Ω, hand: what is measured on a trajectory, with standard errors.

s = i d is the rest position of sphere i along its chain: a material coordinate, in which a wave is
exp(iqs + Λt), its growth rate Re Λ, its angular frequency Im Λ and its phase velocity −Im Λ/q.
Kinds of waves:

    "right"  y + iz = A exp(iqs), for q > 0 a right-handed helix (cos qs, sin qs)
    "left"   y − iz = A exp(iqs), a left-handed one
    "y", "z" y or z = Re A exp(iqs): plane sines; a chain that tells hands apart turns their plane
    "x"      x − s  = Re A exp(iqs): longitudinal waves

"right" and "left" are the hands + and − of :class:`nrchain.lattice.Branch`.

Positions of an elastic periodic chain may be wrapped: each link takes the image that is nearest to
its rest length (:func:`nrchain.scene.unwrapping.unwrapped`), and where that is not clear a
measurement is refused.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from nrchain.analysis.handedness import Handedness, handedness
from nrchain.analysis.measured_chain import (
    NOISE,
    Array,
    MeasurementError,
    a_trajectory,
    links_of,
    positions_of,
    real_number,
)
from nrchain.errors import shorten
from nrchain.scene.unwrapping import has_images, is_wrapped
from nrchain.trajectory.trajectory import Trajectory
from nrchain.wording import brief, span

Kind = Literal["right", "left", "y", "z", "x"]
Quantity = Literal["displacement", "tilt", "shear"]

__all__ = [
    "Estimate",
    "Handedness",
    "MeasurementError",
    "Rate",
    "ShapeFit",
    "Wave",
    "fit_shape",
    "handedness",
    "rate",
    "spin",
    "straightness",
    "translation",
    "turned_angle",
    "wave",
]

FEWEST = 4
"""Snapshots that a fit of a line needs for its error to mean anything."""

LARGEST_MISFIT = 0.3
"""What a wave may leave over of an open chain, relative to itself, for its rate to be believed."""

CLEAR = 30.0
"""What an amplitude must be over that for its logarithm to be fitted."""

CANDIDATES = 17
"""Ends of the transient that are tried, from the first snapshot to the middle one."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """value ± error, the error being one standard error."""

    value: float
    error: float

    def __str__(self) -> str:
        return f"{self.value:.6g} ± {self.error:.1g}"


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
        (T,) root mean square of what the wave (and the rigid motion, if taken out) leaves over.
    wavenumber
        q, in 1/length.
    projected
        Whether the wave fits a periodic chain, so that A is its Fourier component and what is left
        over are other waves, which leave it as it is.
    noise
        (T,) by how much the tolerances of the run leave the amplitude uncertain.
    """

    time: Array
    amplitude: NDArray[np.complex128]
    misfit: Array
    wavenumber: float
    projected: bool = False
    noise: Array | float = 0.0

    __repr__ = brief


@dataclass(frozen=True, slots=True)
class Rate:
    """Λ = growth + i frequency of a wave of wavenumber q, from ``start`` to ``end``.

    ``misfit`` is the median over the snapshots used of what the wave leaves over, relative to it.
    """

    growth: Estimate
    frequency: Estimate
    wavenumber: float
    start: float
    misfit: float = 0.0
    end: float = math.inf

    def __repr__(self) -> str:
        return (
            f"<Rate Λ = ({self.growth}) + i ({self.frequency}) at q = {self.wavenumber:.6g}, "
            f"t = {self.start:g} to {self.end:g}, misfit {self.misfit:.2g}>"
        )

    @property
    def value(self) -> complex:
        """Λ."""
        return complex(self.growth.value, self.frequency.value)

    @property
    def error(self) -> float:
        """The standard error of |Λ|, growth and frequency taken together."""
        return math.hypot(self.growth.error, self.frequency.error)

    @property
    def phase_velocity(self) -> Estimate:
        """−Im Λ/q, along the chain from its first sphere to its last."""
        q = self.wavenumber
        return Estimate(-self.frequency.value / q, self.frequency.error / abs(q))


@dataclass(frozen=True, slots=True)
class ShapeFit:
    """A exp(iqs + Λ(t − start)) fitted to all snapshots at once.

    ``misfit`` is the root mean square of what is left over, relative to that of the shape: 0 for
    a perfect wave, near 1 where there is none.
    """

    rate: Rate
    amplitude: complex
    misfit: float

    __repr__ = brief


def wave(
    trajectory: Trajectory,
    wavenumber: float | None = None,
    kind: Kind = "right",
    *,
    of: Quantity = "displacement",
    rigid: bool = True,
) -> Wave:
    """A(t) = Σ_i w_i exp(−iqs_i)/N, for w = y ± iz; twice the real field for "x", "y" and "z".

    On a periodic chain whose length the wave fits, this Fourier projection is exact: waves of
    other wavenumbers leave A as it is. On open chains the plane waves are not orthogonal, and A is
    the least-squares fit to each snapshot.

    Parameters
    ----------
    wavenumber
        q; the one the scene starts from when None. Its sign tells the directions of waves apart.
    kind
        Which component, see the module.
    of
        ``"displacement"``; ``"tilt"``, the part of e₁ across x; or ``"shear"``, the tilt of the
        midpoint frames against the midpoint tangents, with the stencils of the elastic potential
        (paper, Appendix B). Only displacements have a kind "x".
    rigid
        On open chains: whether each snapshot's mean and slope are fitted along and left out.

    Raises :class:`MeasurementError` for a wave too short for the lattice, |q| d > π.
    """
    chain = a_trajectory(trajectory).scene.chain
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
        # the stencils act on a plane wave as factors, on midpoints as on spheres
        bent = wave(trajectory, q, kind, rigid=rigid)
        tilted = wave(trajectory, q, kind, of="tilt", rigid=rigid)
        half = q * chain.spacing / 2.0
        mean = 9.0 / 8.0 * math.cos(half) - math.cos(3.0 * half) / 8.0
        slope = (9.0 / 4.0 * math.sin(half) - math.sin(3.0 * half) / 12.0) / chain.spacing
        amplitude = mean * tilted.amplitude - 1j * slope * bent.amplitude
        misfit = np.hypot(mean * tilted.misfit, slope * bent.misfit)
        noise = np.hypot(mean * tilted.noise, slope * bent.noise)
        return Wave(trajectory.time, amplitude, misfit, q, bent.projected, noise)
    field = _field(trajectory, kind, of, s)
    turns = q * trajectory.scene.length / (2.0 * math.pi)
    fits = chain.ends == "periodic" and abs(turns - round(turns)) < 1e-9
    amplitude, misfit = _project(field, q, s) if fits else _fit_snapshots(field, q, s, rigid)
    run, unit = trajectory.scene.run, chain.radius if of == "displacement" else 1.0
    noise = NOISE * (run.atol * unit + run.rtol * misfit)
    return Wave(trajectory.time, amplitude, misfit, q, fits, noise)


def rate(wave: Wave, start: float | None = None, *, most_misfit: float = LARGEST_MISFIT) -> Rate:
    """ln A = const + Λt by least squares: growth from ln |A|, frequency from the phase.

    ``start`` is the time before which all is dropped as transient. When None, it is found: of
    starts up to the middle snapshot, the one that leaves the smallest standard error. Errors are
    those of the regression, for as many independent residuals as their correlation from one
    snapshot to the next leaves, and those that the tolerances of the run make, all of one sign at
    worst. Of a wave that decays into what these leave uncertain, or grows out of it, only the
    snapshots well above are used, the longest row of them.

    On an open chain Λ is the rate of the shape in which the wave was found, and the ends have a
    part in that shape: where the wave leaves over more than ``most_misfit`` of itself, the rate
    says nothing about it and is refused. A small misfit does not make it that of an endless chain:
    a free passive chain that starts as half a sine takes the shape of its slowest mode, which half
    a sine and a rigid motion fit to 1 %, and decays four times as fast as the wave would.

    Raises :class:`MeasurementError` for fewer than four snapshots, for a wave that vanishes or is
    nowhere above what is uncertain, for one that is not the shape of its chain, and for snapshots
    too far apart: where the phase moves by more than a quarter turn from one to the next it cannot
    be unwrapped with certainty.
    """
    if not isinstance(wave, Wave):
        raise MeasurementError(f"wave = {shorten(wave)}: must be a Wave, as measure.wave gives it")
    real_number("most_misfit", most_misfit, most=math.inf)
    clear = _clear(wave)
    time, amplitude, left = wave.time[clear], wave.amplitude[clear], wave.misfit[clear]
    uncertain = np.broadcast_to(wave.noise, wave.time.shape)[clear] / np.abs(amplitude)
    logarithm = np.log(np.abs(amplitude)) + 1j * np.unwrap(np.angle(amplitude))

    def fit(first: int) -> Rate:
        t, log = time[first:], logarithm[first:]
        x = t - t.mean()
        most = float(np.abs(x) @ uncertain[first:] / (x @ x))
        growth, frequency = _slope(t, log.real, most), _slope(t, log.imag, most)
        misfit = float(np.median(left[first:] / np.abs(amplitude[first:])))
        return Rate(growth, frequency, wave.wavenumber, float(t[0]), misfit, float(t[-1]))

    best = fit(_first(time, start))
    if start is None:
        for first in _candidates(len(time)):
            best = min(best, fit(first), key=lambda found: found.error)
    if not wave.projected and best.misfit > most_misfit:
        raise MeasurementError(
            f"what a wave of wavenumber {wave.wavenumber:.6g} leaves over of this open chain is "
            f"{best.misfit:.2g} of it, and its rate is not to be trusted above {most_misfit:g}: "
            "measure another kind of wave, or a periodic chain, or raise most_misfit"
        )
    used = time >= best.start
    steps = np.abs(np.diff(logarithm.imag[used]))
    if steps.max() > math.pi / 2.0:
        late = time[used][int(np.argmax(steps)) + 1]
        raise MeasurementError(
            f"snapshots too far apart: the wave turns by {steps.max():.2f} rad up to t = "
            f"{late:.6g}; more than π/2 cannot be unwrapped with certainty"
        )
    return best


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
    "x", "y" and "z" to the real part), as the paper reads its open chains (Appendix D). Nothing
    rigid is taken out, and the largest snapshots weigh most. ``start`` as in :func:`rate`.

    Errors are those of the fit, as if the misfits of spheres and snapshots were independent. The
    ends of an open chain leave misfits that are not: look at ``misfit``. A fit that leaves over
    more than ``most_misfit`` of the shape is refused. Raises :class:`MeasurementError`, as
    :func:`rate`.
    """
    from scipy.optimize import curve_fit

    chain = a_trajectory(trajectory).scene.chain
    real_number("most_misfit", most_misfit, most=math.inf)
    first_guess = wave(trajectory, wavenumber, kind, rigid=kind == "x")
    guess = rate(first_guess, start, most_misfit=math.inf)
    s = chain.spacing * np.arange(chain.particles)
    field = _field(trajectory, kind, "displacement", s)
    if kind == "x":
        field = field - field.mean(axis=1, keepdims=True)
    used = trajectory.time >= guess.start
    t, data = trajectory.time[used] - guess.start, _stacked(field[used])
    span, size = t[-1], math.sqrt(np.mean(data**2))
    carrier = np.exp(1j * guess.wavenumber * s)

    def shape_of(p, factor):
        history = factor * np.exp((p[2] + 1j * p[3]) * t / span)
        shape = history[:, None] * carrier
        return _stacked(shape if np.iscomplexobj(field) else shape.real)

    def model(_, *p):
        return shape_of(p, p[0] + 1j * p[1])

    def derivative(_, *p):
        size_and_phase = (p[0] + 1j * p[1]) * t / span
        factors = (1.0, 1j, size_and_phase, 1j * size_and_phase)
        return np.stack([shape_of(p, factor + 0.0 * t) for factor in factors], axis=1)

    begin = first_guess.amplitude[used][0] / size
    p0 = [begin.real, begin.imag, guess.growth.value * span, guess.frequency.value * span]
    found, covariance = curve_fit(model, None, data / size, p0=p0, jac=derivative)
    errors = np.sqrt(np.diag(covariance)) / span
    misfit = math.sqrt(np.mean((data / size - model(None, *found)) ** 2))
    if misfit > most_misfit:
        raise MeasurementError(
            f"the best fit of a wave of wavenumber {guess.wavenumber:.6g} leaves over {misfit:.2g} "
            f"of the shape, and says nothing about it above {most_misfit:g}: fit another kind of "
            "wave or other times, or raise most_misfit"
        )
    growth, frequency = (Estimate(float(found[k] / span), float(errors[k])) for k in (2, 3))
    fitted = Rate(
        growth, frequency, guess.wavenumber, guess.start, misfit, float(trajectory.time[-1])
    )
    return ShapeFit(fitted, complex(found[0], found[1]) * size, misfit)


def translation(
    trajectory: Trajectory, start: float | None = None
) -> tuple[Estimate, Estimate, Estimate]:
    """V = d/dt Σ_i r_i/N: the components of the mean velocity, by least squares from ``start``.

    With ``start`` None, from the first snapshot. Raises :class:`MeasurementError` for fewer than
    four snapshots, and for an elastic periodic chain that is wrapped: how often it went around as a
    whole is then lost.
    """
    first = _first(a_trajectory(trajectory).time, start)
    _refuse_lost_image(trajectory)
    centre = trajectory.positions[first:].mean(axis=1)
    x, y, z = (_slope(trajectory.time[first:], centre[:, k]) for k in range(3))
    return x, y, z


def spin(trajectory: Trajectory, start: float | None = None) -> Estimate:
    """Ω = d/dt of :func:`turned_angle`, by least squares from ``start`` on.

    Arguments and errors as for :func:`translation` and :func:`turned_angle`.
    """
    first = _first(a_trajectory(trajectory).time, start)
    return _slope(trajectory.time[first:], turned_angle(trajectory)[first:])


def turned_angle(trajectory: Trajectory) -> Array:
    """(T,) angle by which the spheres have turned about their own e₁, on average.

    From one snapshot to the next every sphere is turned by the smallest rotation that brings e₁
    to its new direction, and by an angle about it. Frames tell that angle up to whole turns; how
    many there were is taken from the mean angular velocity of the model at both snapshots. Raises
    :class:`MeasurementError`, naming the time, where that and the angle of a sphere differ by more
    than a quarter turn, or an axis has swung by more than a right angle: those snapshots are too
    far apart.
    """
    from nrchain.motion.model import Model

    frames, time = a_trajectory(trajectory).frames, trajectory.time
    positions = positions_of(trajectory)
    model = Model(trajectory.scene)
    rates = np.empty(len(time))
    for k in range(len(time)):
        omega = model.twists(positions[k], frames[k])[:, 3:]
        rates[k] = np.einsum("ik,ik->i", omega, frames[k, :, 0]).mean()
    relative = np.einsum("tiak,tibk->tiab", frames[:-1], frames[1:])
    seen = np.arctan2(
        relative[..., 2, 1] - relative[..., 1, 2], relative[..., 1, 1] + relative[..., 2, 2]
    )
    expected = ((rates[:-1] + rates[1:]) / 2.0 * np.diff(time))[:, None]
    turned = seen + 2.0 * math.pi * np.round((expected - seen) / (2.0 * math.pi))
    lost = (np.abs(turned - expected) > math.pi / 2.0) | (relative[..., 0, 0] < 0.0)
    if lost.any():
        k = int(np.argmax(lost.any(axis=1)))
        raise MeasurementError(
            f"snapshots too far apart: between t = {time[k]:.6g} and {time[k + 1]:.6g} spheres "
            "turn by an angle that cannot be told from their frames"
        )
    return np.concatenate([[0.0], np.cumsum(turned.mean(axis=1))])


def _refuse_lost_image(trajectory: Trajectory) -> None:
    """Refuse the motion of a chain along x whose coordinates were put back into a box."""
    if not has_images(trajectory.scene):
        return
    positions_of(trajectory)
    wrapped = is_wrapped(trajectory.positions, trajectory.scene.chain.spacing)
    if wrapped.any():
        raise MeasurementError(
            f"positions[{int(np.argmax(wrapped))}]: the chain is wrapped, and how often it went "
            "around its period as a whole is lost: give the positions of the unwrapped chain"
        )


def straightness(trajectory: Trajectory) -> Array:
    """(T,) end-to-end distance over the length of all links: 1 for a straight chain.

    On a periodic chain the end-to-end distance is its period.
    """
    links = links_of(trajectory)
    across = np.linalg.norm(links.sum(axis=1), axis=1)
    return across / np.linalg.norm(links, axis=2).sum(axis=1)


def _field(trajectory: Trajectory, kind: Kind, of: Quantity, s: Array) -> NDArray:
    """(T, N) y ± iz, y, z or x − s of positions or of e₁."""
    if not isinstance(kind, str) or kind not in get_args(Kind) or (kind, of) == ("x", "tilt"):
        allowed = "must be 'right', 'left', 'y', 'z' or, for displacements, 'x'"
        raise MeasurementError(f"kind = {shorten(kind)}: {allowed}")
    vectors = positions_of(trajectory) if of == "displacement" else trajectory.frames[:, :, 0]
    if kind in ("right", "left"):
        return vectors[..., 1] + (1j if kind == "right" else -1j) * vectors[..., 2]
    if kind in ("y", "z"):
        return vectors[..., "xyz".index(kind)]
    return vectors[..., 0] - s


def _project(field: NDArray, q: float, s: Array) -> tuple[NDArray[np.complex128], Array]:
    """The discrete Fourier component, and the root mean square of all others but the mean."""
    amplitude = field @ np.exp(-1j * q * s) / len(s)
    shape = amplitude[:, None] * np.exp(1j * q * s)
    if not np.iscomplexobj(field):
        twin = abs(abs(q) * (s[1] - s[0]) - math.pi) > 1e-9  # at π/d the wave is its own mirror
        amplitude, shape = amplitude * (1 + twin), shape.real * (1 + twin)
    rest = field - field.mean(axis=1, keepdims=True) - shape
    return amplitude, np.sqrt(np.mean(np.abs(rest) ** 2, axis=1))


def _fit_snapshots(
    field: NDArray, q: float, s: Array, rigid: bool
) -> tuple[NDArray[np.complex128], Array]:
    """The least-squares amplitude in every snapshot, with or without a mean and a slope beside."""
    complex_field = np.iscomplexobj(field)
    carrier = np.exp(1j * q * s)
    columns = [carrier] if complex_field else [carrier.real, -carrier.imag]
    if rigid:
        columns += [np.ones(len(s)), (s - s.mean()) / s[-1]]
    basis = np.stack(columns, axis=1)
    found = np.linalg.lstsq(basis, field.T, rcond=None)[0]
    misfit = np.sqrt(np.mean(np.abs(field.T - basis @ found) ** 2, axis=0))
    return (found[0] if complex_field else found[0] + 1j * found[1]), misfit


def _stacked(values: NDArray) -> Array:
    """One row of real numbers."""
    flat = values.ravel()
    return np.concatenate([flat.real, flat.imag]) if np.iscomplexobj(flat) else flat


def _clear(wave: Wave) -> slice:
    """The longest row of snapshots in which the wave is well above the noise of its run."""
    size = np.abs(wave.amplitude)
    above = np.concatenate([[False], size > CLEAR * wave.noise, [False]])
    changes = np.flatnonzero(np.diff(above))
    rows = [slice(int(a), int(b)) for a, b in changes.reshape(-1, 2)]
    longest = max(rows, key=lambda row: row.stop - row.start, default=slice(0, 0))
    if longest.stop - longest.start >= min(FEWEST, len(size)):
        return longest
    if not size.all():
        raise MeasurementError(f"the wave vanishes at t = {wave.time[size == 0.0][0]:.6g}")
    raise MeasurementError(
        f"the wave, of {span(f'{size.min():.2g}', f'{size.max():.2g}')}, is well above what the"
        f" tolerances of its run leave uncertain, {float(np.min(wave.noise)):.2g}, in no more than"
        f" {longest.stop - longest.start} snapshots in a row, and {FEWEST} are needed: lower"
        " run.atol and run.rtol, start from a larger amplitude, or take more snapshots"
    )


def _first(time: Array, start: float | None) -> int:
    """Index of the first snapshot used."""
    first = 0 if start is None else int(np.searchsorted(time, real_number("start", start)))
    if len(time) - first < FEWEST:
        when = "" if start is None else f" from t = {start:g} on"
        raise MeasurementError(f"{len(time) - first} snapshots{when}: at least {FEWEST} are needed")
    return first


def _candidates(snapshots: int) -> NDArray[np.int_]:
    """Where the transient may end: up to the middle, with enough snapshots left."""
    last = max(min(snapshots // 2, snapshots - FEWEST), 0)
    return np.unique(np.linspace(0, last, CANDIDATES).astype(int))


def _slope(t: Array, y: Array, systematic: float = 0.0) -> Estimate:
    """The slope of a line through y(t), and its standard error beside a ``systematic`` one.

    Residuals that are alike from one snapshot to the next, with correlation ρ, count as
    n (1 − ρ)/(1 + ρ) independent ones.
    """
    n, x = len(t), t - t.mean()
    slope = float(x @ y / (x @ x))
    rest = y - y.mean() - slope * x
    square = float(rest @ rest)
    if square == 0.0:
        return Estimate(slope, systematic)
    rho = min(max(float(rest[1:] @ rest[:-1]) / square, 0.0), 1.0)
    independent = max(n * (1.0 - rho) / (1.0 + rho), 3.0)
    scatter = math.sqrt(square / (independent - 2.0) / float(x @ x))
    return Estimate(slope, math.hypot(scatter, systematic))
