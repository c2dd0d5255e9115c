"""(1/h − J) δ = G: implicit Euler steps that follow a chain loosely to a state that attracts it.

G and J are those of :mod:`nrchain.states.relative`: motions of the chain as a whole are taken out.
A step may be long where all modes decay, and becomes a step of Newton's method as h → ∞. Where a
mode grows at a rate σ, h stays below 1/(2σ). Otherwise the step would go backward along that mode,
to the unstable state that the chain leaves.

The error estimate (1 − hJ)⁻¹(δ − hG)/2 tells the two apart. For a mode of rate Λ it is
|hΛ/(1 − hΛ)| |δ|/2, which is at most |δ|/2 exactly if h Re Λ ≤ 1/2. As h → ∞ it is |δ|/2 for all
modes, but the step along one that grows has turned round: δ·G < 0. This is pseudo-transient
continuation (Kelley & Keyes, SIAM J. Numer. Anal. 35, 508, 1998) with a step length that keeps
growing modes.
"""

from __future__ import annotations

import math

import numpy as np

from nrchain.states.bordered import Bordered
from nrchain.states.relative import Point

STEPS = 400
"""Most steps, and most attempts."""

GROWS = 0.6
"""An error above this fraction of the step means that h is too long for a growing mode."""

LARGEST = 0.3
"""Largest rotation of a sphere in a step, in radians, and displacement between neighbours, in d."""

BENDS = 0.5
"""Largest part of a step that the curvature of G along it may change."""

FASTER, SLOWER = 4.0, 0.35
"""Ratios of a step to the one before, after success and failure."""

FIRST = 0.01
"""Longest displacement of the first step, in d."""

QUIET = 1e-8
"""Velocities below this fraction of the largest of the search end it."""


def relax(point: Point) -> tuple[Point, int, bool]:
    """The point that steps of implicit Euler reach, their number, and whether it has settled."""
    spacing = point.chain.scene.chain.spacing
    speed = point.largest
    if not speed:
        return point, 0, True
    h = FIRST * spacing / speed
    for attempt in range(STEPS):
        step = _step(point, h)
        if step is None:
            h *= SLOWER
            continue
        point, speed = step, max(speed, step.largest)
        if point.largest <= QUIET * speed:
            return point, attempt + 1, True
        h *= FASTER
    return point, STEPS, False


def _step(point: Point, h: float) -> Point | None:
    """The next point; None if h is too long."""
    try:
        factors = Bordered(point, 1.0 / h, by_products=True)
        change = -factors.solve(point.residual)
        length = float(np.linalg.norm(change))
        if not _strain(point, change) <= LARGEST:
            return None
        if change @ point.residual < 0.0:
            return None
        error = _filtered(factors, change - h * point.residual, h)
        if not 0.5 * error <= GROWS * length:
            return None
        trial = point.moved(change)
        missed = _filtered(factors, change - h * trial.residual, h)
    except FloatingPointError:
        return None
    return trial if missed <= BENDS * length else None


def _strain(point: Point, change: np.ndarray) -> float:
    """The largest rotation of a sphere, or displacement between neighbours over d."""
    poses, spacing = point.chain.poses(change), point.chain.scene.chain.spacing
    between = np.linalg.norm(np.diff(poses[:, :3], axis=0), axis=1).max(initial=0.0)
    return max(float(between) / spacing, float(np.linalg.norm(poses[:, 3:], axis=1).max()))


def _filtered(factors: Bordered, vector: np.ndarray, h: float) -> float:
    """‖(1 − hJ)⁻¹ v‖."""
    length = float(np.linalg.norm(factors.solve(vector))) / h
    return length if math.isfinite(length) else math.inf
