"""(1/h − J) δ = G: implicit Euler steps that follow a chain loosely to a state that attracts it.

G and J are those of :mod:`nrchain.comoving.relative`: motions of the whole chain are taken out.
A step may be long where all modes decay, and becomes a step of Newton's method as h → ∞. Along a
mode of rate Λ the step is δ = h G/(1 − hΛ). For real Λ > 1/h it goes backward, to the unstable
state that the chain leaves. Such steps have δ·G < 0 once the mode outweighs those that decay, and
are taken again with a smaller h. This is pseudo-transient continuation (Kelley & Keyes, SIAM J.
Numer. Anal. 35, 508, 1998) that keeps growing modes.
"""

from __future__ import annotations

import numpy as np

from nrchain.comoving.bordered import Bordered
from nrchain.comoving.relative import Point

STEPS = 400
"""Most steps, and most attempts."""

LARGEST = 0.3
"""Largest rotation of a sphere in a step, in radians, and displacement between neighbours, in d."""

FASTER, SLOWER = 4.0, 0.35
"""Ratios of a step to the one before, after success and failure."""

FIRST = 0.01
"""Longest displacement of the first step, in d."""

QUIET = 1e-8
"""Velocities below this fraction of the largest of the search end it."""

SMALL, STREAK = 1e-7, 8
"""So do so many steps one after the other, each four times as long as the one before, in which no
sphere moves by more than this part of d: what is left is rounding."""


def relax(point: Point) -> tuple[Point, int, bool]:
    """The point that steps of implicit Euler reach, their number, and whether it has settled."""
    spacing = point.chain.scene.chain.spacing
    speed = point.largest
    if not speed:
        return point, 0, True
    h, streak = FIRST * spacing / speed, 0
    for attempt in range(STEPS):
        step = _step(point, h)
        if step is None:
            h *= SLOWER
            streak = 0
            continue
        still = np.abs(step.positions - point.positions).max() <= SMALL * spacing
        streak = streak + 1 if still else 0
        point, speed = step, max(speed, step.largest)
        if point.largest <= QUIET * speed or streak == STREAK:
            return point, attempt + 1, True
        h *= FASTER
    return point, STEPS, False


def _step(point: Point, h: float) -> Point | None:
    """The next point; None if h is too long."""
    try:
        change = -Bordered(point, 1.0 / h, by_products=True).solve(point.residual)
        if change @ point.residual < 0.0 or not _strain(point, change) <= LARGEST:
            return None
        return point.moved(change)
    except FloatingPointError:
        return None


def _strain(point: Point, change: np.ndarray) -> float:
    """The largest rotation of a sphere, or displacement between neighbours over d."""
    poses, spacing = point.chain.poses(change), point.chain.scene.chain.spacing
    between = np.linalg.norm(np.diff(poses[:, :3], axis=0), axis=1).max(initial=0.0)
    return max(float(between) / spacing, float(np.linalg.norm(poses[:, 3:], axis=1).max()))
