"""Contact, turned links, unresolved growth, friction, neglected effects: what may stop a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nrchain.motion.integrators.base import StepChecks
from nrchain.outcome import Stop
from nrchain.types import Poses, PosesAt
from nrchain.watch.friction import FrictionWatch
from nrchain.watch.growth import GrowthWatch
from nrchain.watch.guard import Guard
from nrchain.watch.neglected import NeglectedWatch
from nrchain.watch.settled import SettledWatch


@dataclass(frozen=True)
class Watches:
    """What watches every step of a run, ``guard`` and ``growth``, and every snapshot."""

    guard: Guard
    growth: GrowthWatch
    friction: FrictionWatch | None = None
    neglected: NeglectedWatch | None = None
    settled: SettledWatch | None = None

    @property
    def checks(self) -> StepChecks:
        """What tells compiled code which steps need no look."""
        return StepChecks(self.guard.clearance, self.growth.check)

    def check_step(
        self,
        begin: float,
        before: np.ndarray,
        end: float,
        reached: Poses,
        poses_at: PosesAt,
        y: np.ndarray,
    ) -> Stop | None:
        """The first event in the step from ``begin``, with positions ``before``, to ``end``.

        ``reached`` are the poses at its end, ``y`` the coordinates that the step has reached;
        ``poses_at(time)`` gives fresh arrays within it.
        """
        stop = self.guard.watch(begin, before, end, reached, poses_at)
        return self.growth.watch(begin, end, reached, y) if stop is None else stop

    @property
    def look_at_snapshots(self) -> bool:
        """Whether any of them may end the run at a snapshot."""
        return bool(self.friction or self.neglected or self.settled)

    def check_snapshot(self, time: float, poses: Poses) -> None:
        """Raise Stop or Settled of :mod:`nrchain.outcome` if a snapshot ends the run."""
        if self.friction:
            self.friction.check(time, poses[0])
        if self.neglected:
            self.neglected.check(time, poses)
        if self.settled:
            settled = self.settled.look(time, poses)
            if settled is not None:
                raise settled

    def restart(self) -> None:
        """Forget the history of steps, as the integrator does."""
        self.growth.restart()
