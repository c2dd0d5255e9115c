"""Where the intervals of an orbit begin, and how far the orbit is from the exact one.

The step of Radau IIA is of order 5 at the ends of intervals, and its cubic leaves an error of
fourth order between them. Intervals are chosen so that |y''''|^(1/4) is shared evenly, with the
fourth derivative from the third ones of neighbouring intervals (Ascher, Mattheij & Russell,
Numerical Solution of Boundary Value Problems, 1995, sec. 9.5). An orbit is then found once more
with every interval halved. The difference is the error of the coarser one, and an
:data:`ASSURED`-th of it that of the finer one: less than the 31st that order 5 promises, for stiff
chains may converge at order 3.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from nrchain.comoving.relative import RelativeChain
from nrchain.states.cycles.newton import solve
from nrchain.states.cycles.orbit import Orbit
from nrchain.states.cycles.system import Condensed

MOST = 1024
"""Most intervals."""

ASSURED = 7.0

EVEN = 0.3
"""Part of the intervals that are even: none is much longer than the others."""


class Refined(NamedTuple):
    """An orbit with half as long intervals, the coarser one, and the difference.

    Attributes
    ----------
    period
        Estimate of the error of T.
    poses
        Estimate of that of the poses, in lengths and radians: the largest of all spheres at the
        first poses of intervals.
    """

    fine: Condensed
    coarse: Condensed
    period: float
    poses: float


def refined(chain: RelativeChain, orbit: Orbit, tolerance: float) -> Refined | None:
    """The orbit with errors below ``tolerance``, of T and of d, if it takes few enough intervals.

    None if Newton's method finds no orbit from here.
    """
    coarse, _, found = solve(chain, orbit)
    if not found:
        return None
    while True:
        even = coarse.system.orbit.remeshed(adapted(chain, coarse.system.orbit))
        coarse, _, found = solve(chain, even)
        if not found:
            return None
        orbit = coarse.system.orbit
        halves = np.repeat(0.5 * orbit.widths, 2)
        fine, size, found = solve(chain, orbit.remeshed(halves))
        if not found:
            return None
        period, poses = _difference(coarse, fine)
        result = Refined(fine, coarse, period, max(poses, size))
        spacing = chain.scene.chain.spacing
        reached = fine.system.orbit
        enough = max(period / reached.period, poses / spacing) <= tolerance
        if enough or 2 * reached.count > MOST:
            return result
        coarse = fine


def _difference(coarse: Condensed, fine: Condensed) -> tuple[float, float]:
    """The errors of period and poses of the finer orbit."""
    one, other = coarse.system.orbit, fine.system.orbit
    away = np.linalg.norm(one.positions[:, 2] - other.positions[1::2, 2], axis=-1).max()
    overlap = np.einsum("kaij,kaij->ka", one.frames[:, 2], other.frames[1::2, 2])
    # 3 − tr = 2 − 2 cos α loses digits below 1e-8: the frames themselves do not
    turn = math.sqrt(max(0.0, 3.0 - float(overlap.min())))
    if turn < 1e-6:
        turn = float(np.abs(one.frames[:, 2] - other.frames[1::2, 2]).max())
    return abs(one.period - other.period) / ASSURED, max(float(away), turn) / ASSURED


def adapted(chain: RelativeChain, orbit: Orbit) -> np.ndarray:
    """Widths (M,) that share the error evenly."""
    starts, widths = orbit.starts, orbit.widths
    thirds = np.stack(
        [chain.coordinates(6.0 * orbit.cubic(k)[2]) / widths[k] ** 3 for k in range(orbit.count)]
    )
    jumps = np.linalg.norm(thirds - np.roll(thirds, 1, axis=0), axis=1)
    middle = 0.5 * (widths + np.roll(widths, 1))
    fourths = jumps / middle
    density = (0.5 * (fourths + np.roll(fourths, -1))) ** 0.25
    mean = float(density @ widths)
    density = (1.0 - EVEN) * density / mean + EVEN if mean > 0.0 else np.ones(orbit.count)
    share = np.concatenate([[0.0], np.cumsum(density * widths)])
    edges = np.concatenate([starts, [1.0]])
    even = np.linspace(0.0, share[-1], orbit.count + 1)
    found = np.interp(even, share, edges)
    found[0], found[-1] = 0.0, 1.0
    return np.diff(found)
