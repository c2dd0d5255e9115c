"""J δ = −G, r ← r + u, R ← cay(φ) R: Newton's method for states of rest and of steady motion.

The unknowns are the poses and the motion of the chain as a whole (V, Ω, turn about e₁). The motion
is the one that fits the twists best at each iterate (:mod:`nrchain.comoving.relative`); its change
within a step is of second order, so that convergence is quadratic. The gauge is fixed by Qᵀ δ = 0:
no step moves the chain as a whole.

Steps are damped until the next correction with the same factors is shorter (the natural
monotonicity test of Deuflhard, Newton Methods for Nonlinear Problems, 2004, sec. 3.3), which does
not depend on how stiff the links are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nrchain.comoving.bordered import Bordered
from nrchain.comoving.motions import Motion
from nrchain.comoving.relative import Point, RelativeChain
from nrchain.notebook import record_html
from nrchain.scene.scene import Scene
from nrchain.types import Poses
from nrchain.wording import brief

STEPS = 60
"""Most steps."""

LARGEST = 0.3
"""Largest rotation of a sphere in a step, in radians, and displacement, in d."""

LEAST_DAMPING = 1e-4
"""Below this fraction of a step the search is given up."""

CONVERGED = 1e-12
"""The state is found if the correction is below this fraction of the extent of the chain."""

ACCEPTED = 1e-7
"""If rounding ends the iteration, the state is found below this correction, in d and rad."""


@dataclass(frozen=True)
class SteadyState:
    """Poses at which a chain rests, or moves as a whole.

    Attributes
    ----------
    positions, frames
        (N, 3) and (N, 3, 3).
    motion
        V of the point ``origin``, Ω, and the turn about e₁ of all spheres.
    origin
        (3,) the point o: the mean of the start, or of the held spheres.
    residual
        Largest velocity, or a times angular velocity, of a sphere in axes that go along.
    error
        The last correction of Newton's method, in lengths and radians: the largest of all spheres.
    steps
        Steps of Newton's method.
    found
        Whether this is a state. If not, the poses are those of the smallest correction.
    """

    positions: np.ndarray
    frames: np.ndarray
    motion: Motion
    origin: np.ndarray
    residual: float
    error: float
    steps: int
    found: bool

    __repr__ = brief
    _repr_html_ = record_html

    @property
    def poses(self) -> Poses:
        """Positions and frames."""
        return self.positions, self.frames


def find_steady_state(scene: Scene, poses: Poses) -> SteadyState:
    """The state that Newton's method reaches from these poses; see ``found`` of the result."""
    chain = RelativeChain(scene, poses)
    point, size, steps, found = solve(chain.at(poses))
    return SteadyState(
        point.positions,
        point.frames,
        point.motion,
        chain.origin,
        point.largest,
        size,
        steps,
        found,
    )


def solve(point: Point) -> tuple[Point, float, int, bool]:
    """The point reached, the size of its last correction, the steps, and whether it is a state."""
    if not point.largest:
        return point, 0.0, 0, True
    spacing, damping = point.chain.scene.chain.spacing, 1.0
    for steps in range(STEPS):
        try:
            factors = Bordered(point, by_products=True)
            change = -factors.solve(point.residual)
        except FloatingPointError:
            return point, np.inf, steps, False
        size = largest_change(point, change)
        extent = max(float(np.ptp(point.positions, axis=0).max()), spacing)
        if size <= CONVERGED * extent:
            return point.moved(change), size, steps + 1, True
        damping = min(2.0 * damping, 1.0, LARGEST * spacing / size)
        reached = _damped(point, factors, change, damping)
        if reached is None:
            small = size <= ACCEPTED * spacing
            return (point.moved(change) if small else point), size, steps, small
        point, damping = reached
    return point, size, STEPS, size <= ACCEPTED * spacing


def _damped(
    point: Point, factors: Bordered, change: np.ndarray, damping: float
) -> tuple[Point, float] | None:
    """The next point and the damping that led there; None if no shorter correction is found."""
    length = np.linalg.norm(change)
    while damping >= LEAST_DAMPING:
        try:
            trial = point.moved(damping * change)
            next_length = float(np.linalg.norm(factors.solve(trial.residual)))
        except FloatingPointError:
            next_length = math.inf
        if next_length <= (1.0 - 0.25 * damping) * length:
            return trial, damping
        damping *= 0.5
    return None


def largest_change(point: Point, change: np.ndarray) -> float:
    """The largest displacement, or rotation times d, of a sphere."""
    chain = point.chain
    parts = (change / chain.units).reshape(-1, 2, 3)
    sizes = np.linalg.norm(parts, axis=2) * [1.0, chain.scene.chain.spacing]
    return float(sizes.max(initial=0.0))
