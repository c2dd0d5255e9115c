"""x(t) = x(t − P): the period of a shape that recurs, how it recurs, and the wave that it carries.

Between snapshots x is the cubic that has its values and rates (Hermite). On an orbit of one
frequency ω the root mean square of dx/dt is ω times that of x − ⟨x⟩, however far apart the
snapshots are: this tells how many of them there are in a period, before a period is sought.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from nrchain.comoving.shapes import Series, Shapes

if TYPE_CHECKING:
    from scipy.interpolate import CubicHermiteSpline

FEWEST = 10.0
"""Snapshots in a period that cubics need."""

PERIODS = 3.0
"""Periods that must have been seen."""

RECURS, NEARLY = 1e-2, 5e-2
"""A shape recurs, or nearly so, if it changes by less than this part of its amplitude in a period.
"""

CANDIDATE = 0.3
"""A lag after which the shape is this near to what it was may be a period: in its root mean square
difference from what it was at any time."""

FINE, MOST = 30.0, 20.0
"""Snapshots in a period, and periods, that are looked at where there are more."""

LAGS, SAME = 8, 3.0
"""Lags that are tried, and the ratio of changes up to which one lag is as good as another."""

STILL = 1e-5
"""An amplitude that changes by less than this part of it in a period does not change."""

GRID = 64
"""Points of a period at which an orbit is sampled."""


@dataclass(frozen=True)
class Cycle:
    """A shape that recurs.

    Attributes
    ----------
    period
        P.
    change
        max |x(t) − x(t − P)| over the last period, in amplitudes.
    amplitude
        max |x − ⟨x⟩| over the last period.
    growth
        Growth rate of the amplitude, from one period to the next.
    left
        How far the amplitude is still to change, as a part of it, if its change goes on as a
        geometric series; infinite if that does not converge.
    orbit
        (GRID, m) x over the last period.
    travelling, ellipticity
        0 where all links oscillate in phase, and 1 where the phase runs along the chain at constant
        amplitude; 0 where bends oscillate in a plane, and 1 where they go round on circles.
    """

    period: float
    change: float
    amplitude: float
    growth: float
    left: float
    orbit: np.ndarray
    travelling: float
    ellipticity: float

    def persists(self, tolerance: float) -> bool:
        """Whether the shape recurs to this tolerance, and hardly changes from now on."""
        return max(self.change, self.left) <= tolerance

    def distances(self, shapes: Shapes) -> np.ndarray:
        """(T,) of shapes from the orbit, in amplitudes."""
        ends = np.vstack([self.orbit, self.orbit[:1]])
        steps = np.diff(ends, axis=0)
        apart = shapes.values[:, None] - self.orbit
        squares = np.maximum((steps**2).sum(axis=1), 1e-300)
        part = np.clip(np.einsum("tgm,gm->tg", apart, steps) / squares, 0.0, 1.0)
        apart -= part[..., None] * steps
        found: np.ndarray = np.linalg.norm(apart, axis=2).min(axis=1) / self.amplitude
        return found


def frequency(shapes: Shapes) -> float:
    """ω = rms(dx/dt)/rms(x − ⟨x⟩)."""
    away = shapes.values - shapes.values.mean(axis=0)
    size = float(np.sqrt((away**2).sum(axis=1).mean()))
    speed = float(np.sqrt((shapes.rates**2).sum(axis=1).mean()))
    return speed / max(size, 1e-300)


def find_cycle(series: Series) -> Cycle | str:
    """The cycle at the end of a series, or why there is none.

    Of the last half, some :data:`FINE` snapshots are looked at in each of the last :data:`MOST`
    periods.
    """
    count = len(series.time) // 2
    if count < 2:
        return f"{len(series.time)} snapshots are too few to see a period"
    expected = 2.0 * math.pi / max(frequency(series.late(GRID)), 1e-300)
    spacing = float(series.time[-1] - series.time[-count]) / (count - 1)
    if PERIODS * expected > spacing * (count - 1):
        return "the shape still changes: a longer run shows whether it comes to rest or oscillates"
    if expected < FEWEST * spacing:
        return f"snapshots are too far apart: {expected / spacing:.2g} in a period"
    stride = max(int(expected / (FINE * spacing)), 1)
    seen = min(count, int(MOST * FINE) * stride)
    shapes = series.at(np.arange(len(series.time) - 1, len(series.time) - 1 - seen, -stride)[::-1])
    time, spacing = shapes.time, stride * spacing
    from scipy.interpolate import CubicHermiteSpline

    curve = CubicHermiteSpline(time, shapes.values, shapes.rates)
    period = _period(curve, _lags(shapes), spacing)
    if period is None:
        return f"the shape does not recur within {0.5 * (time[-1] - time[0]):.4g}"
    if PERIODS * period > time[-1] - time[0]:
        return f"half of the run is over before {PERIODS:g} periods of {period:.4g}"
    return _cycle(shapes, curve, period)


def _lags(shapes: Shapes) -> np.ndarray:
    """Numbers of snapshots after which the shape is more like what it was than a little later."""
    values = shapes.values
    half = len(values) // 2
    late = values[half:]
    unlike = np.array(
        [((late - values[half - lag : len(values) - lag]) ** 2).sum(axis=1).mean()
         for lag in range(half + 1)]
    )  # fmt: skip
    inner = unlike[1:-1]
    lowest = (inner <= unlike[:-2]) & (inner < unlike[2:])
    return 1 + np.flatnonzero(lowest & (inner < CANDIDATE**2 * 2.0 * unlike.mean()))


def _period(curve: CubicHermiteSpline, lags: np.ndarray, spacing: float) -> float | None:
    """The lag after which the shape is most like what it was; of multiples, the least."""
    from scipy.optimize import minimize_scalar

    end, found = float(curve.x[-1]), []
    for guess in lags[:LAGS] * spacing:
        times = end - guess * np.linspace(0.0, 1.0, GRID, endpoint=False)
        last = curve(times)

        def unlike(lag: float, times: np.ndarray = times, last: np.ndarray = last) -> float:
            return float(((curve(times - lag) - last) ** 2).sum())

        bounds = guess - spacing, guess + spacing
        best = minimize_scalar(unlike, bounds=bounds, options={"xatol": 1e-7 * guess})
        size = float(((last - last.mean(axis=0)) ** 2).sum())
        found.append((float(best.x), math.sqrt(float(best.fun) / max(size, 1e-300))))
    if not found:
        return None
    least = min(change for _, change in found)
    return next(lag for lag, change in found if change <= max(SAME * least, RECURS))


def _cycle(shapes: Shapes, curve: CubicHermiteSpline, period: float) -> Cycle:
    end = float(shapes.time[-1])
    phases = np.linspace(0.0, 1.0, GRID, endpoint=False)
    times = end - period * (1.0 - phases)
    orbit, before = curve(times), curve(times - period)
    away = orbit - orbit.mean(axis=0)
    amplitude = float(np.linalg.norm(away, axis=1).max())
    change = float(np.linalg.norm(orbit - before, axis=1).max()) / max(amplitude, 1e-300)
    seen = int((end - float(shapes.time[0])) / period)
    sizes = [_size(curve(times - k * period)) for k in range(min(seen, 3))]
    growth = math.log(sizes[0] / sizes[1]) / period
    left = _left(*sizes)
    amplitudes = shapes.bends(np.tensordot(np.exp(-2j * np.pi * phases), orbit, axes=(0, 0)))
    return Cycle(period, change, amplitude, growth, left, orbit, *_wave(amplitudes))


def _size(orbit: np.ndarray) -> float:
    return float(np.linalg.norm(orbit - orbit.mean(axis=0)))


def _left(last: float, before: float, first: float) -> float:
    """|s_∞ − s|/s of sizes s whose changes form a geometric series."""
    change, earlier = last - before, before - first
    if abs(change) <= STILL * last:
        return abs(change) / last
    ratio = change / earlier if earlier else math.inf
    if not abs(ratio) < 1.0:
        return math.inf
    return abs(change * ratio / (1.0 - ratio)) / last


def _wave(amplitudes: np.ndarray) -> tuple[float, float]:
    """How far bends (links, 2), complex, travel along the chain, and go round."""
    along, _, across = np.linalg.svd(amplitudes)
    return _roundness(along[:, 0]), _roundness(across[0])


def _roundness(vector: np.ndarray) -> float:
    """Smaller over larger axis of the ellipse of Re(v exp iωt), for a unit vector v.

    For the amplitudes along a chain it is 0 for a standing wave and 1 for a travelling one (Feeny,
    J. Sound Vib. 310, 203, 2008).
    """
    flat = min(abs(complex(vector @ vector)), 1.0)
    return math.sqrt((1.0 - flat) / (1.0 + flat))
