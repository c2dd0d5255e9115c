"""Several scenes integrated on the same steps, so that their differences are accurate.

Two runs of loose tolerance each have an error of their own, which hides their difference. As one
system of ODEs they share every step and every order. What a step leaves out is then the same
function of the pose for all members, and cancels where their poses agree. The relative error of the
difference of two members is as small as the relative error of one of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import partial

import numpy as np

from nrchain.geometry.distances import pose_distances
from nrchain.motion.chart_poses import TURN_LIMIT
from nrchain.motion.charts import ChartedChain
from nrchain.motion.contact import PoseLimits
from nrchain.motion.integrators.base import IntegrationError
from nrchain.motion.integrators.cvode import Cvode
from nrchain.motion.model import Model
from nrchain.motion.pose_model import PoseModel
from nrchain.outcome import Cause, Stop
from nrchain.planning.combined_chains import CombinedChains
from nrchain.planning.counted_work import interpreted_work
from nrchain.scene.scene import Scene
from nrchain.types import Poses
from nrchain.watch.guard import Guard
from nrchain.watch.seed import resolving_tolerance

FRESH_STEPS = 2000
"""Steps after which all charts are replaced by fresh ones."""


class SharedStepRun:
    """Scenes integrated on the same steps from the same poses; the first is the reference.

    Attributes
    ----------
    time
        Time reached.
    poses
        Poses of every member at that time, or at its stop.
    stops
        Why and when a member ended before the others, by its number.
    first_stops
        By the number of a member, if it or the reference has stopped: the time of the first of the
        two stops, and the poses of both then.
    evaluations
        Right-hand sides that each member has taken so far.
    work
        Nominal seconds (:mod:`nrchain.planning.counted_work`) of all of them.
    """

    def __init__(self, scenes: Sequence[Scene], poses: Poses, tolerance: float) -> None:
        self.scenes, self.tolerance = list(scenes), tolerance
        self._atol = resolving_tolerance(self.scenes[0], *poses, tolerance)
        self.time = 0.0
        self.poses = [(poses[0].copy(), poses[1].copy()) for _ in scenes]
        self.stops: dict[int, Stop] = {}
        self.first_stops: dict[int, tuple[float, Poses, Poses]] = {}
        self.members = list(range(len(self.scenes)))
        self._chains = [ChartedChain(Model(scene)) for scene in self.scenes]
        self._guards = [Guard(PoseLimits.of(scene), poses[0]) for scene in self.scenes]
        self._costs = [interpreted_work(scene) for scene in self.scenes]
        self.steps = 0

    @property
    def models(self) -> list[PoseModel]:
        """The model of every member."""
        return [chain.model for chain in self._chains]

    @property
    def evaluations(self) -> list[int]:
        return [chain.evaluations for chain in self._chains]

    @property
    def work(self) -> float:
        return float(np.dot(self._costs, self.evaluations))

    def remove(self, members: Iterable[int]) -> None:
        """Stop integrating these members."""
        gone = set(members)
        self.members = [m for m in self.members if m not in gone]

    def advance(self, times: Iterable[float], budget: float = math.inf) -> Iterator[float]:
        """Integrate to each of the times, all after ``time``, and yield each when reached.

        Ends early when the reference or all others have stopped, or when ``work`` has grown by
        ``budget``. Between times the caller may :meth:`remove` members.
        """
        moves = self._wait if self._chains[0].dimension == 0 else self._integrate
        reached = moves([float(time) for time in times], self.work + budget)
        while True:
            # not across a yield: the caller keeps its own error state
            with np.errstate(all="ignore"):
                time = next(reached, None)
            if time is None:
                return
            yield time

    def _wait(self, times: list[float], budget: float) -> Iterator[float]:
        """Let the time pass: every sphere is clamped."""
        for self.time in times:
            yield self.time

    def _goes_on(self) -> bool:
        return 0 in self.members and (len(self.members) > 1 or len(self.scenes) == 1)

    def _integrate(self, times: list[float], budget: float) -> Iterator[float]:
        due, combined = 0, list(self.members)
        self._start(times[-1])
        while due < len(times) and self._goes_on() and self.work < budget:
            try:
                reached = self._integrator.step()
                if reached == self.time:
                    raise IntegrationError("steps have become too small to advance the time")
            except (IntegrationError, ArithmeticError, np.linalg.LinAlgError) as error:
                if not self._remove_fastest(error):
                    return
                combined = list(self.members)
                self._start(times[-1])
                continue
            self.steps += 1
            self._fresh += 1
            y = self._integrator.at(reached)
            end = min(reached, times[-1])
            ended = self._poses_at(end, y if end == reached else None)
            self._watch(end, ended)
            while due < len(times) and times[due] <= end and 0 in self.members:
                self._move(times[due], self._poses_at(times[due]))
                yield times[due]
                due += 1
            if due == len(times) or not self._goes_on():
                return
            self._move(end, ended)
            turned = max(
                chain.largest_turn(y[part])
                for chain, part in zip(self._combined.chains, self._combined.parts, strict=True)
            )
            if combined != self.members or not turned <= TURN_LIMIT or self._fresh >= FRESH_STEPS:
                combined = list(self.members)
                self._start(times[-1])

    def _start(self, end: float) -> None:
        """Restart the integrator on fresh charts about the poses of the members that are left."""
        chains = [self._chains[m] for m in self.members]
        for member, chain in zip(self.members, chains, strict=True):
            chain.rebase(self.time, *self.poses[member])
        self._combined, self._numbers = CombinedChains(chains), list(self.members)
        pose = np.concatenate(
            [
                np.tile(np.repeat([self.scenes[m].chain.radius, 1.0], 3), chain.dimension // 6)
                for m, chain in zip(self.members, chains, strict=True)
            ]
        )
        self._integrator = Cvode(
            self._combined,  # type: ignore[arg-type]
            end,
            self.tolerance,
            self._atol * pose,
        )
        self._integrator.start(self.time, np.zeros(self._combined.dimension))
        self._fresh = 0

    def _poses_at(self, time: float, y: np.ndarray | None = None) -> dict[int, Poses]:
        """Copies of the poses of all members at a time within the last step."""
        y = self._integrator.at(time) if y is None else y
        found = {}
        for member, chain, part in zip(
            self._numbers, self._combined.chains, self._combined.parts, strict=True
        ):
            positions, frames = chain.poses(time, y[part])
            found[member] = positions.copy(), frames.copy()
        return found

    def _poses_of(self, member: int, time: float) -> Poses:
        return self._poses_at(time)[member]

    def _move(self, time: float, poses: dict[int, Poses]) -> None:
        for member in self.members:
            self.poses[member] = poses[member]
        self.time = time

    def _watch(self, end: float, ended: dict[int, Poses]) -> None:
        """Remove each member that touches or turns over between ``time`` and ``end``."""
        found: dict[int, Stop] = {}
        for member in self.members:
            poses_at = partial(self._poses_of, member)
            before, after = self.poses[member][0], ended[member]
            stop = self._guards[member].watch(self.time, before, end, after, poses_at)
            if stop is not None:
                found[member] = stop
        for member in self.members if 0 in found else found:
            if member:
                first = min((found[m] for m in (0, member) if m in found), key=lambda s: s.time)
                self.first_stops[member] = (
                    first.time,
                    self._poses_until(member, first),
                    self._poses_until(0, first),
                )
        for member, stop in found.items():
            self.stops[member] = stop
            self.poses[member] = self._poses_until(member, stop)
        self.remove(found)

    def _poses_until(self, member: int, stop: Stop) -> Poses:
        """Poses at a stop within the last step; those before it if it led to NaN or infinity."""
        if stop.cause is Cause.NOT_FINITE:
            return self.poses[member]
        return self._poses_of(member, stop.time)

    def _remove_fastest(self, error: Exception) -> bool:
        """A step failed: remove the fastest member besides the reference; False if none is left."""
        others = [m for m in self.members if m != 0]
        cause = getattr(error, "cause", Cause.NOT_FINITE)
        if not others:
            self.stops[0] = Stop(cause, self.time, str(error))
            self.remove([0])
            return False
        speeds = []
        for member in others:
            twists = self._chains[member].model.twists(*self.poses[member])
            speeds.append(np.abs(twists).max())
        worst = others[int(np.argmax(np.nan_to_num(speeds, nan=np.inf)))]
        self.stops[worst] = Stop(cause, self.time, str(error))
        self.first_stops[worst] = self.time, self.poses[worst], self.poses[0]
        self.remove([worst])
        return True


def largest_distance(poses: Poses, others: Poses, radius: float) -> tuple[float, float]:
    """max |r − r′|/a and max ∠(frame, frame′) over the spheres, in radii and radians."""
    apart, turned = pose_distances(poses, others)
    return float(apart.max() / radius), float(turned.max())
