"""Several scenes on the same steps: their differences are exact where each by itself is coarse.

Two runs of loose tolerance each have an error of their own, and their difference is lost in it. As
one system of ODEs they share every step and every order: what the steps leave out is the same
function of the pose for all members, and cancels where their poses agree. The difference of two
members is then as accurate, relative to itself, as the loose tolerance is relative to one.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from itertools import pairwise

import numpy as np

from nrchain.motion.charts import TURN_LIMIT, ChartedChain
from nrchain.motion.contact import PoseLimits
from nrchain.motion.integrators.base import IntegrationError
from nrchain.motion.integrators.cvode import Cvode
from nrchain.motion.model import Model
from nrchain.outcome import Cause, Stop
from nrchain.planning.nominal_cost import evaluation_cost
from nrchain.scene.scene import Scene
from nrchain.types import Poses
from nrchain.watch.guard import Guard
from nrchain.watch.seed import resolving_tolerance

FRESH_STEPS = 2000
"""Steps after which all charts are left for fresh ones."""


class _Together:
    """The charted chains of several scenes as one: y holds one stretch a chain."""

    def __init__(self, chains: Sequence[ChartedChain]) -> None:
        self.chains = chains
        ends = np.cumsum([0, *(chain.dimension for chain in chains)])
        self.dimension = int(ends[-1])
        self.parts = [slice(a, b) for a, b in pairwise(ends)]

    def rates(self, time: float, y: np.ndarray, out: np.ndarray) -> None:
        for chain, part in zip(self.chains, self.parts, strict=True):
            chain.rates(time, y[part], out[part])

    def linearise(self, time: float, y: np.ndarray) -> None:
        for chain, part in zip(self.chains, self.parts, strict=True):
            chain.linearise(time, y[part])

    def factorise(self, gamma: float) -> None:
        for chain in self.chains:
            chain.factorise(gamma)

    def solve(self, vector: np.ndarray, out: np.ndarray) -> None:
        for chain, part in zip(self.chains, self.parts, strict=True):
            chain.solve(vector[part], out[part])

    def product(self, vector: np.ndarray, out: np.ndarray) -> None:
        for chain, part in zip(self.chains, self.parts, strict=True):
            chain.product(vector[part], out[part])


class PairedRun:
    """Scenes integrated side by side from the same poses, the first of them the reference.

    Attributes
    ----------
    time
        Time reached.
    poses
        Poses of every member at that time, or at its stop.
    stops
        Why and when a member ended before the others, by its number.
    parted
        Where a member, or the reference, has stopped: the time of the first of the two stops, and
        the poses of both then, by the number of the member.
    evaluations
        Right-hand sides each member has taken so far.
    work
        Nominal seconds (:mod:`nrchain.planning.nominal_cost`) of all of them.
    """

    def __init__(self, scenes: Sequence[Scene], poses: Poses, tolerance: float) -> None:
        self.scenes, self.tolerance = list(scenes), tolerance
        self._atol = resolving_tolerance(self.scenes[0], *poses, tolerance)
        self.time = 0.0
        self.poses = [(poses[0].copy(), poses[1].copy()) for _ in scenes]
        self.stops: dict[int, Stop] = {}
        self.parted: dict[int, tuple[float, Poses, Poses]] = {}
        self.members = list(range(len(self.scenes)))
        self._chains = [ChartedChain(Model(scene)) for scene in self.scenes]
        self._guards = [Guard(PoseLimits.of(scene), poses[0]) for scene in self.scenes]
        self._costs = [evaluation_cost(scene) for scene in self.scenes]
        self.steps = 0

    @property
    def models(self) -> list[Model]:
        """The model of every member."""
        return [chain.model for chain in self._chains]

    @property
    def evaluations(self) -> list[int]:
        return [chain.evaluations for chain in self._chains]

    @property
    def work(self) -> float:
        return float(np.dot(self._costs, self.evaluations))

    def drop(self, members: Iterable[int]) -> None:
        """Go on without these."""
        gone = set(members)
        self.members = [m for m in self.members if m not in gone]

    def go(self, times: Iterable[float], budget: float = math.inf) -> Iterator[float]:
        """Integrate to each of the times, which begin after ``time``, and yield it when reached.

        Ends early when the reference stops, or all others have, and when further ``work`` of
        ``budget`` is done. What the consumer drops is no longer integrated.
        """
        moves = self._hold if self._chains[0].dimension == 0 else self._integrate
        reached = moves([float(time) for time in times], self.work + budget)
        while True:
            # not across a yield: the consumer's arithmetic is its own
            with np.errstate(all="ignore"):
                time = next(reached, None)
            if time is None:
                return
            yield time

    def _hold(self, times: list[float], budget: float) -> Iterator[float]:
        """Every sphere is clamped, and the time passes."""
        for self.time in times:
            yield self.time

    def _goes_on(self) -> bool:
        return 0 in self.members and (len(self.members) > 1 or len(self.scenes) == 1)

    def _integrate(self, times: list[float], budget: float) -> Iterator[float]:
        due, together = 0, list(self.members)
        self._start(times[-1])
        while due < len(times) and self._goes_on() and self.work < budget:
            try:
                reached = self._integrator.step()
                if reached == self.time:
                    raise IntegrationError("steps have become too small to advance the time")
            except (IntegrationError, ArithmeticError, np.linalg.LinAlgError) as error:
                if not self._lose_one(error):
                    return
                together = list(self.members)
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
                for chain, part in zip(self._together.chains, self._together.parts, strict=True)
            )
            if together != self.members or not turned <= TURN_LIMIT or self._fresh >= FRESH_STEPS:
                together = list(self.members)
                self._start(times[-1])

    def _start(self, end: float) -> None:
        """Fresh charts about the poses of the members there are, and no history."""
        chains = [self._chains[m] for m in self.members]
        for member, chain in zip(self.members, chains, strict=True):
            chain.rebase(self.time, *self.poses[member])
        self._together, self._numbers = _Together(chains), list(self.members)
        pose = np.concatenate(
            [
                np.tile(np.repeat([self.scenes[m].chain.radius, 1.0], 3), chain.dimension // 6)
                for m, chain in zip(self.members, chains, strict=True)
            ]
        )
        self._integrator = Cvode(
            self._together,  # type: ignore[arg-type]
            end,
            self.tolerance,
            self._atol * pose,
        )
        self._integrator.start(self.time, np.zeros(self._together.dimension))
        self._fresh = 0

    def _poses_at(self, time: float, y: np.ndarray | None = None) -> dict[int, Poses]:
        """Poses of all members within the last step, in arrays of their own."""
        y = self._integrator.at(time) if y is None else y
        found = {}
        for member, chain, part in zip(
            self._numbers, self._together.chains, self._together.parts, strict=True
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
        """Take out whoever meets an event on the way from ``time`` to ``end``."""
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
                self.parted[member] = (
                    first.time,
                    self._poses_until(member, first),
                    self._poses_until(0, first),
                )
        for member, stop in found.items():
            self.stops[member] = stop
            self.poses[member] = self._poses_until(member, stop)
        self.drop(found)

    def _poses_until(self, member: int, stop: Stop) -> Poses:
        """Poses at a stop within the last step; before that step, where it has left all numbers."""
        if stop.cause is Cause.NOT_FINITE:
            return self.poses[member]
        return self._poses_of(member, stop.time)

    def _lose_one(self, error: Exception) -> bool:
        """A step has failed: take out whoever moves fastest beside the reference, if anyone."""
        others = [m for m in self.members if m != 0]
        cause = getattr(error, "cause", Cause.NOT_FINITE)
        if not others:
            self.stops[0] = Stop(cause, self.time, str(error))
            self.drop([0])
            return False
        speeds = []
        for member in others:
            twists = self._chains[member].model.twists(*self.poses[member])
            speeds.append(np.abs(twists).max())
        worst = others[int(np.argmax(np.nan_to_num(speeds, nan=np.inf)))]
        self.stops[worst] = Stop(cause, self.time, str(error))
        self.parted[worst] = self.time, self.poses[worst], self.poses[0]
        self.drop([worst])
        return True


def apart(poses: Poses, others: Poses, radius: float) -> tuple[float, float]:
    """max |r − r′|/a and max ∠(frame, frame′) over the spheres, in radii and radians."""
    distance = np.linalg.norm(poses[0] - others[0], axis=-1).max() / radius
    between = np.einsum("nak,nam->nkm", poses[1], others[1])
    sine = np.sqrt(
        sum(
            (between[:, (k + 2) % 3, (k + 1) % 3] - between[:, (k + 1) % 3, (k + 2) % 3]) ** 2
            for k in range(3)
        )
    )
    cosine = np.trace(between, axis1=-2, axis2=-1) - 1.0
    return float(distance), float(np.arctan2(sine, cosine).max())
