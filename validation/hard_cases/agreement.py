"""|r − r′| ≤ 30 · tolerance · growth: how far two integrators may come to lie apart.

Each step errs by its tolerance, atol + rtol |y|, at most, and what it erred by grows until the end
as the distance between two neighbouring runs does. The growth is measured: the same scene is run
again from a start nudged by 1e-5 a, and the separation of both runs at the end is divided by the
smallest they had on the way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nrchain import Trajectory
from validation.hard_cases.gallery import Case, Poses

NUDGE = 1e-5
"""Standard deviation, in radii, of what the start is moved by to see how distances grow."""


LEEWAY = 30.0
"""Steps whose errors may add up to the global one: what is older has died away, or has grown."""


@dataclass(frozen=True)
class Agreement:
    """How far apart two runs of a scene end, and how far they may, in units of the tolerance.

    ``tolerance`` is atol + rtol times the largest displacement, in radii and radians;
    ``growth`` is how much a separation grew by the end.
    """

    apart: float
    tolerance: float
    growth: float

    @property
    def factor(self) -> float:
        """The distance over the tolerance."""
        return self.apart / self.tolerance

    @property
    def allowed(self) -> float:
        """The most that the factor may be."""
        return LEEWAY * self.growth


def agreement(one: Trajectory, other: Trajectory, nudged: Trajectory) -> Agreement:
    """How two runs of a scene agree; ``nudged`` began by :data:`NUDGE` elsewhere."""
    tolerances = [
        run.scene.run.atol + run.scene.run.rtol * _distance(run, -1, run, 0) for run in (one, other)
    ]
    apart = np.inf if other.status != one.status else _distance(one, -1, other, -1)
    snapshots = min(len(one.time), len(nudged.time))
    separations = [_distance(one, k, nudged, k) for k in range(snapshots)]
    return Agreement(
        apart,
        max(tolerances),
        max(separations[-1] / max(min(separations), np.finfo(float).tiny), 1.0),
    )


def nudge(case: Case) -> Poses:
    """The start of a case, moved by normal random numbers; clamped ends stay where they are."""
    scene = case.scene()
    positions, frames = case.start(scene)
    moves = NUDGE * scene.chain.radius * np.random.default_rng(0).standard_normal(positions.shape)
    if scene.chain.ends == "clamped":
        moves[[0, -1]] = 0.0
    return {"positions": positions + moves, "frames": frames}


def _distance(one: Trajectory, at: int, other: Trajectory, when: int) -> float:
    """The largest difference of two snapshots, of a coordinate in radii or of a frame vector."""
    moved = np.abs(one.positions[at] - other.positions[when]).max() / one.scene.chain.radius
    return float(max(moved, np.abs(one.frames[at] - other.frames[when]).max()))
