"""Whether a chain has settled: ``run.until = "settled"``.

The chain has settled in a steady state when all that is left of its motion is small and nothing
grows. δ = (1/h − J)⁻¹ G is one implicit Euler step of length h (:mod:`nrchain.comoving.relative`);
for h much longer than the run it ends where the chain would end, but for motions of the whole. If δ
moves no sphere by more than :data:`NEAR` radii or radians, the rates Λ of small changes about the
end of δ say whether that is a state that attracts the chain. A chain that passes slowly by an
unstable state, such as a straight chain that has hardly begun to buckle, has not settled.

It has settled in a cycle when its shape recurs, and keeps recurring, to :data:`RECURS` of its
amplitude (:mod:`nrchain.comoving.recurrence`), and small changes do not grow along it
(:mod:`nrchain.comoving.tangents`).

The watch sees every snapshot, and depends on nothing else: a run ends at the same snapshot however
often it is interrupted. Eigenvalues are computed when the velocities beside the motion as a whole
have fallen to a tenth of the largest; cycles are sought when the number of snapshots has grown by a
tenth.
"""

from __future__ import annotations

import math

import numpy as np

from nrchain.comoving.bordered import Bordered
from nrchain.comoving.recurrence import FINE, Cycle, find_cycle
from nrchain.comoving.relative import RelativeChain
from nrchain.comoving.shapes import Series
from nrchain.comoving.stability import leading_rate
from nrchain.comoving.tangents import FEWEST, PERIODS, largest_exponent
from nrchain.outcome import Settled
from nrchain.scene.scene import Scene
from nrchain.types import Poses

NEAR = 1e-3
"""Largest distance from a steady state, in radii or radians."""

RECURS = 1e-3
"""Largest change of a shape in a period, and of its amplitude from now on, in amplitudes."""

HORIZON = 10.0
"""h, in lengths of the run."""

GROWS = 1e-2
"""Nothing grows if its rate times the length of the run is below this."""

QUIET = 0.1
"""A steady state is looked for when velocities are below this fraction of the largest so far."""

FIRST, RATIO = 40, 1.1
"""Snapshots at the first look for a cycle, and their ratio from one look to the next."""

KEPT = 4000
"""Snapshots that are kept for these looks."""

ALIKE = 1e-2
"""Two cycles whose period and amplitude differ by less than this part are one."""

CERTAIN = 3.0
"""Standard errors by which an exponent must exceed 0 to mean growth."""


class SettledWatch:
    """Sees the snapshots of one run, one after the other from its start on."""

    def __init__(self, scene: Scene, poses: Poses) -> None:
        self._chain, self._end = RelativeChain(scene, poses), scene.run.end
        self._poses: list[Poses] = []
        self._times: list[float] = []
        self._largest, self._count, self._next = 0.0, 0, FIRST
        self._is_unstable = False
        self._left: tuple[float, float] | None = None

    def look(self, time: float, poses: Poses) -> Settled | None:
        """How the run ends at this snapshot, if the chain has settled."""
        self._keep(time, poses)
        try:
            return self._steady(time, poses) or self._cycle(time)
        except (FloatingPointError, ValueError, np.linalg.LinAlgError):
            # a state or a cycle that cannot be judged is none
            return None

    def _keep(self, time: float, poses: Poses) -> None:
        self._count += 1
        self._times.append(time)
        self._poses.append((poses[0].copy(), poses[1].copy()))
        if len(self._times) > 2 * KEPT:
            del self._times[:-KEPT], self._poses[:-KEPT]

    def _steady(self, time: float, poses: Poses) -> Settled | None:
        """Settled, if a state that attracts the chain is near."""
        point = self._chain.at(poses)
        self._largest = max(self._largest, point.largest)
        radius = self._chain.scene.chain.radius
        is_still = point.largest * HORIZON * self._end <= NEAR * radius
        if point.largest > QUIET * self._largest and not is_still:
            return None
        step = Bordered(point, 1.0 / (HORIZON * self._end), by_products=True)
        left = -step.solve(point.residual)
        distance = self._distance(left)
        if distance > NEAR:
            self._is_unstable = False
            return None
        if self._is_unstable:
            # still near the state that was found to be unstable
            return None
        rate = leading_rate(point.moved(left)).real
        if rate * self._end > GROWS:
            self._is_unstable = True
            return None
        return Settled(time, f"settled in a steady state, {distance:.1g} a away")

    def _distance(self, change: np.ndarray) -> float:
        """The largest displacement of a sphere, in radii, or rotation."""
        sizes = np.linalg.norm(self._chain.poses(change).reshape(-1, 2, 3), axis=2)
        sizes /= [self._chain.scene.chain.radius, 1.0]
        return float(sizes.max(initial=0.0))

    def _cycle(self, time: float) -> Settled | None:
        """Settled, if the shape recurs and small changes do not grow."""
        if self._count < self._next:
            return None
        self._next = math.ceil(RATIO * self._count)
        times = np.array(self._times)
        positions, frames = (np.array(rows) for rows in zip(*self._poses, strict=True))
        found = find_cycle(Series(self._chain, times, positions, frames))
        if not isinstance(found, Cycle) or not found.persists(RECURS):
            return None
        if self._left and np.allclose(self._left, (found.period, found.amplitude), ALIKE, 0.0):
            # still near the cycle along which small changes were found to grow
            return None
        spacing = float(times[-1] - times[-2])
        stride = max(int(found.period / (FINE * spacing)), 1)
        seen = min(len(times) - 1, round(PERIODS * found.period / spacing))
        places = np.arange(len(times) - 1, len(times) - 2 - seen, -stride)[::-1]
        if len(places) < FEWEST:
            return None
        exponent, error = largest_exponent(
            self._chain, times[places], positions[places], frames[places], beside=True
        )
        if exponent > CERTAIN * error and exponent * found.period > GROWS:
            self._left = found.period, found.amplitude
            return None
        words = f"settled in a cycle of period {found.period:.6g}"
        return Settled(time, f"{words}: its shape changes by {found.change:.1g} a period")
