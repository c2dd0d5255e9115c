"""Λ = growth + i frequency: the rate of a wave, from a line through the logarithm of A(t)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nrchain.analysis.measure.line_fit import FEWEST, Estimate, first_snapshot, slope
from nrchain.analysis.measure.waves import Wave
from nrchain.analysis.measured_chain import MeasurementError, real_number
from nrchain.errors import shorten
from nrchain.notebook import table_html
from nrchain.wording import span

LARGEST_MISFIT = 0.3
"""Largest misfit of a wave on an open chain, relative to the wave, whose rate is trusted."""

CLEAR = 30.0
"""An amplitude is fitted where it exceeds its uncertainty this many times."""

CANDIDATES = 17
"""Ends of the transient that are tried, from the first snapshot to the middle one."""


@dataclass(frozen=True, slots=True)
class Rate:
    """Λ = growth + i frequency of a wave of wavenumber q, from ``start`` to ``end``.

    ``misfit`` is the median over the snapshots used of the misfit of the wave, relative to it.
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

    def _repr_html_(self) -> str:
        rows = [
            ("growth", str(self.growth)),
            ("frequency", str(self.frequency)),
            ("phase velocity", str(self.phase_velocity)),
            ("wavenumber q", self.wavenumber),
            ("times", f"{self.start:g} to {self.end:g}"),
            ("misfit", f"{self.misfit:.2g}"),
        ]
        return table_html("Rate of a wave", rows)

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


def rate(wave: Wave, start: float | None = None, *, most_misfit: float = LARGEST_MISFIT) -> Rate:
    """ln A = const + Λt by least squares: growth from ln |A|, frequency from the phase.

    Parameters
    ----------
    start
        The time before which snapshots are left out as a transient. When None, it is the one that
        gives the smallest standard error, among times up to the middle snapshot.
    most_misfit
        On an open chain: the largest misfit of the wave, relative to it, at which to trust a rate.

    The error combines that of the regression, for residuals that are correlated, with the largest
    error that the tolerances of the run allow. If a wave decays into the uncertainty that these
    tolerances leave, or grows out of it, the fit uses the longest row of snapshots in which the
    wave is well above.

    On an open chain Λ is the rate of the shape in which the wave was found, and the ends shape it
    too. A small misfit does not make Λ the rate of an infinite chain: a free passive chain that
    starts as half a sine takes the shape of its slowest mode. Half a sine and a rigid motion fit
    that mode to 1 %, and it decays four times as fast as the wave would.

    Raises :class:`~nrchain.analysis.measured_chain.MeasurementError` for fewer than four snapshots,
    for a wave that vanishes or never exceeds its uncertainty, for a misfit above ``most_misfit``,
    and for snapshots too far apart: where the phase moves by more than a quarter turn from one to
    the next it cannot be unwrapped with certainty.
    """
    if not isinstance(wave, Wave):
        raise MeasurementError(f"wave = {shorten(wave)}: must be a Wave, as measure.wave gives it")
    real_number("most_misfit", most_misfit, most=math.inf)
    clear = _clear_snapshots(wave)
    time, amplitude, left = wave.time[clear], wave.amplitude[clear], wave.misfit[clear]
    uncertain = np.broadcast_to(wave.noise, wave.time.shape)[clear] / np.abs(amplitude)
    logarithm = np.log(np.abs(amplitude)) + 1j * np.unwrap(np.angle(amplitude))

    def fit(first: int) -> Rate:
        t, log = time[first:], logarithm[first:]
        x = t - t.mean()
        most = float(np.abs(x) @ uncertain[first:] / (x @ x))
        growth, frequency = slope(t, log.real, most), slope(t, log.imag, most)
        misfit = float(np.median(left[first:] / np.abs(amplitude[first:])))
        return Rate(growth, frequency, wave.wavenumber, float(t[0]), misfit, float(t[-1]))

    best = fit(first_snapshot(time, start))
    if start is None:
        for first in _candidates(len(time)):
            best = min(best, fit(first), key=lambda found: found.error)
    if not wave.projected and best.misfit > most_misfit:
        raise MeasurementError(
            f"the misfit of a wave of wavenumber {wave.wavenumber:.6g} on this open chain is "
            f"{best.misfit:.2g} of the wave; above {most_misfit:g} its rate is not to be trusted: "
            "measure another kind of wave, or a periodic chain, or raise most_misfit"
        )
    used = time >= best.start
    steps = np.abs(np.diff(logarithm.imag[used]))
    if steps.max() > math.pi / 2.0:
        late = time[used][int(np.argmax(steps)) + 1]
        raise MeasurementError(
            f"snapshots too far apart: the phase of the wave turns by {steps.max():.2f} rad before "
            f"t = {late:.6g}; more than π/2 cannot be unwrapped with certainty"
        )
    return best


def _clear_snapshots(wave: Wave) -> slice:
    """The longest row of snapshots in which the amplitude is well above its uncertainty."""
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
        f"the amplitude of the wave, {span(f'{size.min():.2g}', f'{size.max():.2g}')}, is well"
        f" above its uncertainty, {float(np.min(wave.noise)):.2g} from the tolerances of the run,"
        f" in no more than {longest.stop - longest.start} snapshots in a row, and {FEWEST} are"
        " needed: lower run.atol and run.rtol, start from a larger amplitude, or take more"
        " snapshots"
    )


def _candidates(snapshots: int) -> NDArray[np.int_]:
    """Where the transient may end: up to the middle, with enough snapshots left."""
    last = max(min(snapshots // 2, snapshots - FEWEST), 0)
    return np.unique(np.linspace(0, last, CANDIDATES).astype(int))
