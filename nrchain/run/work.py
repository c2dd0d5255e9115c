"""T = Σ over the steps of a run of the processor time of its thread: what a run costs.

The work of a run is a count first: steps, right-hand sides, Jacobians, solves. The counts are the
same on every machine, however busy it is. The time of a run is the processor time of the thread
that integrates. Steps that take far longer per right-hand side than the median are those in which
kernels are compiled or loaded, and count at the median. ``nrchain plan`` and ``nrchain cost``
therefore give the same number before a run as the run does afterwards. Where all cores share the
sum over pairs, the time includes what the thread waits for the others.
"""

from __future__ import annotations

import math
import time
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np

from nrchain.outcome import Cause
from nrchain.wording import digits, span

if TYPE_CHECKING:
    from nrchain.trajectory.trajectory import Trajectory

clock = time.thread_time
"""Processor time of the calling thread, in seconds."""

DEFINITION = (
    "processor time is that of the thread that integrates, for the steps of a run; compilation, "
    "start-up, files and the choice of effects are not included"
)

STRANGE = 10.0
"""A step that takes this many times the median per right-hand side has compiled a kernel. Steps
with a Jacobian take up to 7 times the median in the shipped scenes."""

LAPS = 1024
"""Laps kept. Twice as many are joined in pairs, and later laps are as long as these. What a
compiled kernel adds to its lap is then left out, or is less than STRANGE/LAPS of the whole."""

FEWEST_STEPS = 8
"""In fewer steps the median cannot show which of them compiled a kernel: their time is unknown."""

LARGEST_FACTOR = 10.0
"""No estimate extends a run to more than this many times the part that was run."""


class Work(NamedTuple):
    """The counted work of a run."""

    steps: int
    evaluations: int
    jacobians: int
    solves: int

    @classmethod
    def of(cls, counters: Mapping[str, float]) -> Self:
        """That of the counters of a trajectory."""
        return cls(*(int(counters.get(name, 0)) for name in cls._fields))

    def words(self, least: float = 1.0, most: float = 1.0) -> str:
        """The counts in words, multiplied by ``least`` to ``most``."""
        names = "steps", "right-hand sides", "Jacobians", "solves"
        return ", ".join(
            f"{span(digits(least * count), digits(most * count))} {name}"
            for count, name in zip(self, names, strict=True)
        )


class Stopwatch:
    """Processor time of the calling thread, by laps of so many right-hand sides each.

    >>> watch = Stopwatch()
    >>> watch.go()
    >>> watch.lap(3)  # the right-hand sides counted since the watch was made
    >>> watch.seconds > 0.0
    True
    """

    def __init__(self) -> None:
        # seconds and right-hand sides of every lap
        self._spent, self._counts = array("d"), array("d")
        self._open, self._since, self._counted = 0.0, math.nan, 0
        self._steps = self._width = 1

    def go(self) -> None:
        """Start the first lap."""
        self._since = clock()

    @contextmanager
    def paused(self) -> Iterator[None]:
        """Stop the clock meanwhile, if it runs."""
        if math.isnan(self._since):
            yield
            return
        self._open += clock() - self._since
        try:
            yield
        finally:
            self._since = clock()

    def lap(self, evaluations: int) -> None:
        """End a lap at this total of right-hand sides; a lap without any is added to the next."""
        now = clock()
        self._open += now - self._since
        self._since = now
        if evaluations == self._counted:
            return
        spent, count = self._open, evaluations - self._counted
        self._open, self._counted = 0.0, evaluations
        if self._spent and self._steps < self._width:
            self._spent[-1] += spent
            self._counts[-1] += count
            self._steps += 1
            return
        if len(self._spent) == 2 * LAPS:
            self._spent, self._counts = _join(self._spent), _join(self._counts)
            self._width *= 2
        self._spent.append(spent)
        self._counts.append(count)
        self._steps = 1

    @property
    def seconds(self) -> float:
        """Seconds of all laps; those that compiled a kernel count at the median."""
        if not self._spent:
            return 0.0
        spent, count = np.frombuffer(self._spent), np.frombuffer(self._counts)
        usual = median((spent / count).tolist()) * count
        return float(np.where(spent > STRANGE * usual, usual, spent).sum())


def _join(laps: array[float]) -> array[float]:
    """Laps twice as long: the sums of neighbours."""
    return array("d", np.frombuffer(laps).reshape(-1, 2).sum(axis=1))


def extrapolation_factors(part: float, late: float) -> tuple[float, float] | None:
    """The cost of a whole run over that of the part run, least and most; None where it is unknown.

    The rest is assumed to proceed at the pace of the second half of what was run, which took the
    fraction ``late`` of its work, or at the pace of all of it; up to :data:`LARGEST_FACTOR` times.
    """
    if part >= 1.0:
        return 1.0, 1.0
    if part * LARGEST_FACTOR < 1.0:
        return None
    rest, paces = 1.0 / part - 1.0, (1.0, 2.0 * late)
    return 1.0 + rest * min(paces), 1.0 + rest * max(paces)


@dataclass(frozen=True)
class RunCost:
    """What the part of a scene that was run has cost, and what the whole run will cost.

    Attributes
    ----------
    work
        Counts of what was run, from 0 to ``reached``.
    seconds
        Its processor time; see :data:`DEFINITION`.
    reached, end
        Time simulated, and that at which the run ends.
    late
        Part of the right-hand sides that fell in the second half of the time reached.
    """

    work: Work
    seconds: float
    reached: float
    end: float
    late: float = 0.5

    @property
    def part(self) -> float:
        """The fraction of the run that was run."""
        return 1.0 if self.reached >= self.end else self.reached / self.end

    @property
    def factors(self) -> tuple[float, float] | None:
        """The cost of the whole run over that of the part run, least and most, or None."""
        return extrapolation_factors(self.part, self.late)

    @property
    def whole(self) -> tuple[float, float] | None:
        """Seconds of the whole run, least and most; None where unknown."""
        if self.factors is None or 0 < self.work.steps < FEWEST_STEPS:
            return None
        least, most = self.factors
        return least * self.seconds, most * self.seconds

    def words(self) -> str:
        """Work and time of the whole run, or why they are unknown."""
        if self.factors is None:
            return (
                f"not known: {self.work.words()} reach t = {self.reached:.3g} of {self.end:.3g}, "
                f"and no estimate extends a run to more than {LARGEST_FACTOR:g} times its part"
            )
        text = self.work.words(*self.factors)
        if self.whole is None:
            return f"{text}; the time of so few steps is not known"
        text = f"{text} in {span(*map(digits, self.whole))} s of processor time"
        if self.reached < self.end:
            text += f", extrapolated from t = {self.reached:.3g} of {self.end:.3g}"
        return text


def cost_of(trajectory: Trajectory, late: float = 0.5) -> RunCost:
    """What a run has cost, from its counters; the rest is estimated where a budget ended it."""
    reached, end = float(trajectory.time[-1]), trajectory.scene.run.end
    if trajectory.cause not in (None, Cause.BUDGET, Cause.INTERRUPTED):
        end = reached
    seconds = trajectory.counters.get("processor_time", 0.0)
    return RunCost(Work.of(trajectory.counters), seconds, reached, end, late)


def medians(
    tasks: Sequence[Callable[[], object]], repeats: int, batches: Sequence[int]
) -> list[float]:
    """Median seconds of one call of each task, over ``repeats`` batches of calls in turn."""
    found: list[list[float]] = [[] for _ in tasks]
    for _ in range(repeats):
        for task, count, times in zip(tasks, batches, found, strict=True):
            began = clock()
            for _ in range(count):
                task()
            times.append((clock() - began) / count)
    return [float(np.median(times)) for times in found]
