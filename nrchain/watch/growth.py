"""μ = max Re λ of the linearised chain, against the steps taken: growth that steps pass over.

Implicit steps damp what grows by more than e in one of them, as long as it stays below the
tolerance: a chain that buckles under a load then ends straight. While a chain is nearly straight,
its steps are held against the rates at which it leaves that state, whatever they come from. Which
growth a step follows is in :mod:`nrchain.watch.followed`; here is when that is looked at.

Rates are taken anew where links have become longer, shorter or more twisted, and where steps have
become too long for the last: at once the first few times, then at steps ever farther apart, so that
a chain that shakes along itself is not held up. They are not taken while a bend above the tolerance
is seen to decay.
"""

from __future__ import annotations

import math

import numpy as np

from nrchain._compile import kernel
from nrchain.motion.charts import ChartedChain
from nrchain.motion.integrators.base import Integrator
from nrchain.motion.model import Model
from nrchain.notices import Tell
from nrchain.outcome import Cause, Stop
from nrchain.scene.scene import Scene
from nrchain.types import Poses
from nrchain.watch.followed import LARGEST, SEEN, Sight
from nrchain.watch.growing_modes import Growth, growth_about_base

NEARLY = 1e4
"""Bends below this many tolerances are watched: modes hardly in larger ones are seen as well."""

FOLDS = math.log(10.0)
"""Growth by less than e to this power over the rest of the run is let be."""

CHANGED = 0.2
"""The rates are taken anew when a link has changed by this part of the largest change seen."""

LONGER = 10.0
"""So are they when steps have become this many times as long."""

BENT = 8
"""Steps until a chain that was found bent is looked at again."""

STRAIGHT = 1e-13
"""Bends up to this many radii or radians are rounding."""

AT_ONCE = 4
"""Looks at rates that follow each other at once; from then on twice the steps lie between two."""


class GrowthWatch:
    """Watches the steps of one run; ``restart`` forgets all, where the integrator does."""

    def __init__(self, scene: Scene, integrator: Integrator, tell: Tell, *, told: bool) -> None:
        self._scene, self._integrator, self._tell, self._told = scene, integrator, tell, told
        self._radius = scene.chain.radius
        self._periodic = scene.chain.ends == "periodic"
        self._chain: ChartedChain | None = None
        self.restart()

    def restart(self) -> None:
        """Begin anew, as a run does that goes on from here."""
        self._before = math.inf
        self._pause = 0
        self._links: np.ndarray | None = None
        self._most = np.zeros(self._integrator.chain.dimension)
        self._scale = np.zeros(2)
        self._fastest = self._judged = self._step = 0.0
        self._looks = self._wait = 0

    def watch(self, begin: float, end: float, poses: Poses, y: np.ndarray) -> Stop | None:
        """What the step from ``begin`` to ``end``, where it came to ``poses``, says of growth.

        ``y`` are the integrator's coordinates of these poses.
        """
        if self._pause:
            self._pause -= 1
            return None
        bend = _bend(*poses, self._radius, self._periodic, LARGEST)
        if bend <= STRAIGHT and self._told:
            return None
        self._most = np.maximum(self._most, np.abs(y))
        sight = Sight.of(self._integrator, self._scene.run.atol, y, self._most)
        tolerance = sight.across(_axis(poses[0], self._periodic))
        if bend >= min(NEARLY * tolerance, LARGEST):
            self._pause = BENT - 1
            return None
        falls, self._before = bend < self._before, bend
        step, left = end - begin, self._scene.run.end - end
        if falls and bend > SEEN * tolerance and self._links is None:
            return None
        if left <= 0.0 or not self._is_due(step, poses):
            return None
        growth = self._growth(end, step, left, poses)
        self._fastest = float(growth.rates.max(initial=0.0))
        self._judged, self._step = 2.0 * step * self._fastest, step
        if not len(growth.rates):
            return None
        if bend <= STRAIGHT:
            self._tell_once(end, self._fastest)
            return None
        lost = sight.passed_over(growth, step, left, bend)
        if lost is None:
            return None
        told = self._reason(growth.rates[lost], growth.parts[lost], sight, step, bend)
        return Stop(Cause.GROWTH, end, told)

    def _is_due(self, step: float, poses: Poses) -> bool:
        """Whether rates are to be taken after this step."""
        slow = step * self._fastest <= max(self._integrator.followed, self._judged)
        self._wait -= 1
        if slow and (
            self._wait > 0 or not (self._has_changed(poses) or step > LONGER * self._step)
        ):
            return False
        self._looks += 1
        self._wait = 2 ** max(self._looks - AT_ONCE, 0)
        return True

    def _reason(self, rate: float, part: np.ndarray, sight: Sight, step: float, bend: float) -> str:
        run = self._scene.run
        at = part, run.atol, run.rtol
        size, finer = min(sight.sizes(*at), sight.certain(*at)), sight.resolving(part)
        return (
            f"a part of the bend of {bend:.2g} a grows at rate {rate:.3g}; it is {size:.2g} of the "
            f"tolerance (run.atol = {run.atol:g}, run.rtol = {run.rtol:g}), and steps of "
            f"{step:.2g} do not follow it; {finer}{', or ' if finer else ''}a larger start "
            "resolves it"
        )

    def _has_changed(self, poses: Poses) -> bool:
        """Whether links differ from those at which rates were last taken; if so, keep these."""
        links = _links(*poses, self._scene.chain.spacing, self._periodic)
        largest = np.abs(links).max(axis=1)
        self._scale = np.maximum(self._scale, largest)
        if self._links is not None:
            change = np.abs(links - self._links).max(axis=1)
            floor = self._scene.run.atol * np.array([1.0 / self._scene.chain.spacing, 1.0])
            if (change <= np.maximum(CHANGED * self._scale, floor)).all():
                return False
        self._links = links
        return True

    def _growth(self, time: float, step: float, left: float, poses: Poses) -> Growth:
        """The modes that grow by more than ``FOLDS`` in what is left, at these poses."""
        if self._chain is None:
            # one of its own: the integrator's is not to notice
            self._chain = ChartedChain(Model(self._scene))
        self._chain.rebase(time, *poses)
        axis = _axis(poses[0], self._periodic)
        return growth_about_base(self._chain, axis, FOLDS / left, self._integrator.followed / step)

    def _tell_once(self, time: float, rate: float) -> None:
        if self._told:
            return
        self._told = True
        self._tell(
            f"the chain is straight to rounding at t = {time:.3g}, and stays so, although a bend"
            f" would grow at rate {rate:.3g}: there is nothing for it to grow from; start.shape ="
            " 'random' gives it"
        )


def _axis(positions: np.ndarray, periodic: bool) -> np.ndarray:
    if periodic:
        return np.array([1.0, 0.0, 0.0])
    axis = positions[-1] - positions[0]
    return axis / max(float(np.linalg.norm(axis)), np.finfo(float).tiny)


@kernel
def _bend(positions, frames, radius, periodic, limit):
    """max (|offset|/a, |e₁ × axis|) from the axis, or ``limit`` as soon as it is as large."""
    count = positions.shape[0]
    axis = np.zeros(3)
    axis[0] = 1.0
    if not periodic:
        square = 0.0
        for k in range(3):
            axis[k] = positions[count - 1, k] - positions[0, k]
            square += axis[k] * axis[k]
        if square == 0.0:
            return limit
        axis /= np.sqrt(square)
    largest, across = 0.0, np.empty(3)
    for i in range(count):
        for part in range(2):
            size = 0.0
            for k in range(3):
                k1, k2 = (k + 1) % 3, (k + 2) % 3
                if part == 0:
                    first = (positions[i, k1] - positions[0, k1]) / radius
                    second = (positions[i, k2] - positions[0, k2]) / radius
                else:
                    first, second = frames[i, 0, k1], frames[i, 0, k2]
                across[k] = first * axis[k2] - second * axis[k1]
                size += across[k] * across[k]
            largest = max(largest, np.sqrt(size))
        if largest >= limit:
            return limit
    return largest


@kernel
def _links(positions, frames, spacing, periodic):
    """(2, links): the strain of every link, and the sine of its twist."""
    count = positions.shape[0]
    number = count if periodic else count - 1
    links = np.empty((2, number))
    for link in range(number):
        ahead = (link + 1) % count
        square, twist = 0.0, 0.0
        for k in range(3):
            along = positions[ahead, k] - positions[link, k]
            if ahead == 0 and k == 0:
                along += count * spacing
            square += along * along
            twist += frames[link, 2, k] * frames[ahead, 1, k]
        links[0, link] = np.sqrt(square) / spacing - 1.0
        links[1, link] = twist
    return links
