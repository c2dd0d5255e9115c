"""μ = max Re λ of the linearised chain, against the steps taken: growth that steps do not resolve.

Implicit steps damp what grows by more than e in one of them, as long as it stays below the
tolerance: a chain that buckles under a load then ends straight. While a chain is nearly straight,
its steps are compared with the rates at which it leaves that state, whatever causes them. Which
growth a step resolves is in :mod:`nrchain.watch.resolved_growth`; here is when that is checked.

Rates are computed again where links have become longer, shorter or more twisted, and where steps
have become too long for the last rates: at once the first few times, then at steps ever farther
apart, so that a chain that oscillates along itself is not slowed down. They are not computed while
a bend above the tolerance decays.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from nrchain._compile import kernel
from nrchain.motion.bend import BENT, LARGEST, BendCheck, bend_of
from nrchain.motion.charts import ChartedChain
from nrchain.motion.integrators.base import Integrator
from nrchain.notices import Report
from nrchain.outcome import Cause, Stop
from nrchain.types import Poses
from nrchain.watch.growing_modes import Growth, growth_about_base
from nrchain.watch.resolved_growth import SEEN, Resolution

NEARLY = 1e4
"""Bends below this many tolerances are watched. In larger ones step control sees every mode of
which more than a ten-thousandth is in the bend."""

FOLDS = math.log(10.0)
"""Growth by less than e to this power over the rest of the run does not matter."""

CHANGED = 0.2
"""Rates are computed again when a link has changed by this fraction of the largest change seen."""

LONGER = 10.0
"""So are they when steps have become this many times as long."""

STRAIGHT = 1e-13
"""Bends up to this many radii or radians are rounding."""

AT_ONCE = 4
"""Computations of rates without a wait; from then on the wait doubles every time."""


class GrowthWatch:
    """Watches the steps of one run; ``restart`` forgets their history, as the integrator does.

    Parameters
    ----------
    integrator
        That of the run.
    spare_chain
        Makes a charted chain, of the same model, that may be linearised without disturbing the
        integrator's; called at most once.
    report
        Gets the text of a warning.
    atol
        Of a step, in radii and radians.
    radius, spacing
        Of spheres, and of their centres at rest.
    periodic
        Whether the chain repeats along x.
    warned_of_straight
        Whether the run has warned already of a straight chain that would buckle.

    Attributes
    ----------
    check
        Tells compiled code which steps need no look.
    """

    def __init__(
        self,
        integrator: Integrator,
        spare_chain: Callable[[], ChartedChain],
        report: Report,
        *,
        atol: float,
        radius: float,
        spacing: float,
        periodic: bool,
        warned_of_straight: bool,
    ) -> None:
        self._integrator, self._spare_chain, self._report = integrator, spare_chain, report
        self._atol, self._radius, self._spacing = atol, radius, spacing
        self._periodic, self._warned = periodic, warned_of_straight
        self._chain: ChartedChain | None = None
        order = integrator.chain.order
        self._places = (6 * order[:, None] + np.arange(6)).ravel()
        count = integrator.chain.model.count
        self.check = BendCheck.of(count, radius, count * spacing if periodic else 0.0)
        self.restart()

    def restart(self) -> None:
        """Forget all steps so far: a run resumed from here has not seen them."""
        self._before = math.inf
        self.check.pause[0] = 0
        self.check.farthest[:] = 0.0
        self._links: np.ndarray | None = None
        self._scale = np.zeros(2)
        self._fastest = self._judged = self._step = 0.0
        self._looks = self._wait = 0
        self._found = self._confirms = math.inf

    def watch(self, begin: float, end: float, poses: Poses, y: np.ndarray) -> Stop | None:
        """The stop at ``end`` if the step from ``begin``, to ``poses``, loses a growing mode.

        ``y`` are the integrator's coordinates of these poses.
        """
        check = self.check
        if check.pause[0]:
            check.pause[0] -= 1
            return None
        bend = max(bend_of(*poses, self._radius, self._periodic, LARGEST))
        if bend <= STRAIGHT and self._warned:
            return None
        farthest = np.maximum(check.farthest[self._places], np.abs(y))
        check.farthest[self._places] = farthest
        if bend >= LARGEST:
            check.pause[0] = BENT - 1
            return None
        resolution = Resolution.of(self._integrator, self._atol, y, farthest)
        tolerance = resolution.across(_axis(poses[0], self._periodic))
        if bend >= NEARLY * tolerance:
            check.pause[0] = BENT - 1
            return None
        falls, self._before = bend < self._before, bend
        step, left = end - begin, self._integrator.end - end
        if falls and bend > SEEN * tolerance and self._links is None:
            return None
        lasted = end - self._found if end >= self._confirms else 0.0
        if not lasted and (left <= 0.0 or not self._is_due(step, poses)):
            return None
        growth = self._growth(end, step, max(left, lasted), poses)
        self._fastest = float(growth.rates.max(initial=0.0))
        self._judged, self._step = 2.0 * step * self._fastest, step
        if bend <= STRAIGHT:
            self._warn_if_lasting(end, self._fastest)
            return None
        if not len(growth.rates):
            return None
        lost = resolution.lost_mode(growth, step, left, bend)
        if lost is None:
            return None
        reason = _reason(growth.rates[lost], growth.parts[lost], resolution, step, bend)
        return Stop(Cause.GROWTH, end, reason)

    def _is_due(self, step: float, poses: Poses) -> bool:
        """Whether rates are to be computed after this step."""
        slow = step * self._fastest <= max(self._integrator.growth_limit, self._judged)
        self._wait -= 1
        if slow and (
            self._wait > 0 or not (self._has_changed(poses) or step > LONGER * self._step)
        ):
            return False
        self._looks += 1
        self._wait = 2 ** max(self._looks - AT_ONCE, 0)
        return True

    def _has_changed(self, poses: Poses) -> bool:
        """Whether links differ from those at the last computation of rates; if so, keep these."""
        links = _links(*poses, self._spacing, self._periodic)
        largest = np.abs(links).max(axis=1)
        self._scale = np.maximum(self._scale, largest)
        if self._links is not None:
            change = np.abs(links - self._links).max(axis=1)
            floor = self._atol * np.array([1.0 / self._spacing, 1.0])
            if (change <= np.maximum(CHANGED * self._scale, floor)).all():
                return False
        self._links = links
        return True

    def _growth(self, time: float, step: float, left: float, poses: Poses) -> Growth:
        """The modes that grow by more than e^``FOLDS`` in the time ``left``, at these poses."""
        if self._chain is None:
            self._chain = self._spare_chain()
        self._chain.rebase(time, *poses)
        axis = _axis(poses[0], self._periodic)
        fast = self._integrator.growth_limit / step
        return growth_about_base(self._chain, axis, FOLDS / left, fast)

    def _warn_if_lasting(self, time: float, rate: float) -> None:
        """Warn of growth that is still there once it would have grown a bend by e^``FOLDS``.

        Links that relax along themselves pass through states that grow for a moment only.
        """
        if not rate:
            self._found = self._confirms = math.inf
            return
        if time < self._confirms:
            if math.isinf(self._found):
                self._found, self._confirms = time, time + FOLDS / rate
            return
        self._warned = True
        self._report(
            f"the chain is straight to rounding at t = {time:.3g} and stays straight, although a "
            f"bend would grow at rate {rate:.3g}: it has no bend to grow from; "
            "start.shape = 'random' provides one"
        )


def _reason(rate: float, part: np.ndarray, resolution: Resolution, step: float, bend: float) -> str:
    """What a run that stops for a lost mode says: which growth, why, and what resolves it."""
    at = part, resolution.atol, resolution.rtol
    size = min(resolution.over_tolerance(*at), resolution.over_step_errors(*at))
    finer = resolution.finer_tolerances(part)
    atol, rtol = resolution.atol / resolution.share, resolution.rtol / resolution.share
    return (
        f"a part of the bend of {bend:.2g} a grows at rate {rate:.3g}, but steps of {step:.2g} do "
        f"not resolve it: it is {size:.2g} of the tolerance of a step (run.atol = {atol:g}, "
        f"run.rtol = {rtol:g}); {finer}{' or finer, or ' if finer else ''}a larger bend at the "
        "start resolves it"
    )


def _axis(positions: np.ndarray, periodic: bool) -> np.ndarray:
    if periodic:
        return np.array([1.0, 0.0, 0.0])
    axis = positions[-1] - positions[0]
    return axis / max(float(np.linalg.norm(axis)), np.finfo(float).tiny)


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
