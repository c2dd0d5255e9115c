"""|r − r′| ≤ 30 · tolerance · growth: the allowed distance between two integrators.

The error of a step is at most its tolerance, atol + rtol |y|. It grows until the end as the
distance between two neighbouring runs does. The growth is measured: the same scene runs again from
a start displaced by 1e-5 a, and the separation at the end is divided by the smallest one before.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nrchain import Trajectory
from validation.report.gallery import Case, Poses

NUDGE = 1e-5
"""Standard deviation of the displacements of the start, in radii."""


LEEWAY = 30.0
"""Number of steps whose errors add up; older errors have decayed, or are in the growth."""


@dataclass(frozen=True)
class Agreement:
    """Distance between the ends of two runs of a scene, and its allowed value, in tolerances.

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
        """Largest allowed factor."""
        return LEEWAY * self.growth


def agreement(one: Trajectory, other: Trajectory, nudged: Trajectory) -> Agreement:
    """Agreement of two runs of a scene; ``nudged`` starts displaced by :data:`NUDGE`."""
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
    """The start of a case with random normal displacements; clamped ends are not displaced."""
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
