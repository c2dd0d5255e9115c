"""max |Δv|/a, |Δω|: how fast the effects that a run leaves out would move its spheres."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from nrchain.effects.base import largest_velocity
from nrchain.motion.pose_model import PoseModel
from nrchain.outcome import Cause, Stop
from nrchain.types import Poses

CHECKS = 10
"""How often a run compares what it neglects with what was predicted, at most."""


class NeglectedWatch:
    """Compares the run's model with the full one at snapshots that are ``interval`` apart or more.

    Each comparison takes a right-hand side of the full model. ``models`` are those two; ``allowed``
    gives, by the time, the largest difference of velocities in radii and radians per unit time;
    ``remedy`` names the keys that bring in what is left out.
    """

    def __init__(
        self,
        models: tuple[PoseModel, PoseModel],
        allowed: Callable[[float], float],
        *,
        radius: float,
        interval: float,
        remedy: str,
    ) -> None:
        self._models, self._allowed = models, allowed
        self._radius, self._interval, self._remedy = radius, interval, remedy
        self._next = 0.0

    def check(self, time: float, poses: Poses) -> None:
        """Raise :class:`~nrchain.outcome.Stop` if the difference at these poses is too large."""
        if time < self._next:
            return
        self._next = time + self._interval
        found = velocity_difference(*self._models, poses, self._radius)
        allowed = self._allowed(time)
        if found > allowed:
            raise Stop(
                Cause.NEGLECTED,
                time,
                f"the effects left out move a sphere by {found:.3g} radii or radians per unit time,"
                f" and the prediction allows {allowed:.3g}; {self._remedy} includes them, in place "
                "of effects = 'auto'",
            )


def velocity_difference(model: PoseModel, other: PoseModel, poses: Poses, radius: float) -> float:
    """max of |v − v′|/a and |ω − ω′| over the spheres, at the same poses."""
    with np.errstate(all="ignore"):
        return largest_velocity(model.twists(*poses) - other.twists(*poses), radius) / radius
