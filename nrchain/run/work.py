"""T = Σ over the steps of a run of the processor time of its thread: what a run costs.

The work of a run is counted first: steps, right-hand sides, Jacobians, solves. They are the same
on every machine, however busy it is. The time that goes with them is that of the processor, of the
one thread that integrates, step by step. Steps that take far longer per right-hand side than the
median are those in which kernels are compiled or loaded: they are charged at the median. So one
number is told before a run, by ``nrchain plan`` and ``nrchain cost``, and after it. Where pairs are
summed on all cores, what the thread waits for the others is in it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np

from nrchain.outcome import Cause
from nrchain.wording import digits, span

if TYPE_CHECKING:
    from nrchain.trajectory.trajectory import Trajectory

clock = time.thread_time
"""Seconds that the calling thread has had of a processor."""

DEFINITION = (
    "processor time is that of the thread that integrates, for the steps of a run; compilation, "
    "start-up, files and the choice of effects are apart"
)

STRANGE = 10.0
"""A step that takes this many times the median per right-hand side has compiled something. Steps
with a Jacobian take up to 7 times the median, in every shipped scene."""

LAPS = 1024
"""Laps kept: where there are twice as many, neighbours are joined, and later ones are as long. What
a compiled kernel adds to its lap is then left out, or is less than STRANGE/LAPS of the whole."""

FEWEST_STEPS = 8
"""Of fewer steps no median tells which of them compiled something: their time is not known."""

CARRIED = 10.0
"""No run is carried on to more than this many times what was run of it."""


class Work(NamedTuple):
    """What a run has done, by count."""

    steps: int
    evaluations: int
    jacobians: int
    solves: int

    @classmethod
    def of(cls, counters: Mapping[str, float]) -> Self:
        """That of the counters of a trajectory."""
        return cls(*(int(counters.get(name, 0)) for name in cls._fields))

    def words(self, least: float = 1.0, most: float = 1.0) -> str:
        """The counts in words, or so many times them."""
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
        self._laps: list[tuple[float, int]] = []
        self._open, self._since, self._counted = 0.0, math.nan, 0
        self._steps = self._width = 1

    def go(self) -> None:
        """Begin, with what was counted so far left out."""
        self._since = clock()

    @contextmanager
    def paused(self) -> Iterator[None]:
        """What is done meanwhile is not counted; nor is it where the watch is not going."""
        if math.isnan(self._since):
            yield
            return
        self._open += clock() - self._since
        try:
            yield
        finally:
            self._since = clock()

    def lap(self, evaluations: int) -> None:
        """End a lap at so many right-hand sides in all; one without any goes into the next."""
        now = clock()
        self._open += now - self._since
        self._since = now
        if evaluations == self._counted:
            return
        step = self._open, evaluations - self._counted
        self._open, self._counted = 0.0, evaluations
        if self._laps and self._steps < self._width:
            self._laps[-1] = _joined(self._laps[-1], step)
            self._steps += 1
            return
        if len(self._laps) == 2 * LAPS:
            self._laps = list(map(_joined, self._laps[::2], self._laps[1::2]))
            self._width *= 2
        self._laps.append(step)
        self._steps = 1

    @property
    def seconds(self) -> float:
        """Seconds of all laps, with the strange ones charged at the median."""
        if not self._laps:
            return 0.0
        spent, count = np.array(self._laps).T
        usual = float(np.median(spent / count)) * count
        return float(np.where(spent > STRANGE * usual, usual, spent).sum())


def _joined(lap: tuple[float, int], other: tuple[float, int]) -> tuple[float, int]:
    return lap[0] + other[0], lap[1] + other[1]


def carried(part: float, late: float) -> tuple[float, float] | None:
    """Whole run over the part of it that was run: least and most; None where that is not known.

    The rest is taken to go at the pace of the second half of what was run, which holds the part
    ``late`` of its work, or at that of all of it; and no further than :data:`CARRIED` times.
    """
    if part >= 1.0:
        return 1.0, 1.0
    if part * CARRIED < 1.0:
        return None
    rest, paces = 1.0 / part - 1.0, (1.0, 2.0 * late)
    return 1.0 + rest * min(paces), 1.0 + rest * max(paces)


@dataclass(frozen=True)
class RunCost:
    """What was run of a scene took, and what all of it will take.

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
        """How much of the run was run."""
        return 1.0 if self.reached >= self.end else self.reached / self.end

    @property
    def factors(self) -> tuple[float, float] | None:
        """The whole run over what was run, least and most; None where that is not known."""
        return carried(self.part, self.late)

    @property
    def whole(self) -> tuple[float, float] | None:
        """Seconds of the whole run, least and most; None where they are not known."""
        if self.factors is None or 0 < self.work.steps < FEWEST_STEPS:
            return None
        least, most = self.factors
        return least * self.seconds, most * self.seconds

    def words(self) -> str:
        """Work and time of the whole run, or why they are not known."""
        if self.factors is None:
            return (
                f"not known: {self.work.words()} reach t = {self.reached:.3g} of {self.end:.3g}, "
                f"and nothing is carried on to more than {CARRIED:g} times what was run"
            )
        told = self.work.words(*self.factors)
        if self.whole is None:
            return f"{told}; these are too few to tell their time"
        told = f"{told} in {span(*map(digits, self.whole))} s of processor time"
        if self.reached < self.end:
            told += f", carried on from t = {self.reached:.3g} of {self.end:.3g}"
        return told


def cost_of(trajectory: Trajectory, late: float = 0.5) -> RunCost:
    """What a run has cost, from its counters; the rest is open where a budget has ended it."""
    reached, end = float(trajectory.time[-1]), trajectory.scene.run.end
    if trajectory.cause not in (None, Cause.BUDGET, Cause.INTERRUPTED):
        end = reached
    seconds = trajectory.counters.get("processor_time", 0.0)
    return RunCost(Work.of(trajectory.counters), seconds, reached, end, late)


def medians(
    tasks: Sequence[Callable[[], object]], repeats: int, batches: Sequence[int]
) -> list[float]:
    """Median seconds of one call of each task, of ``repeats`` batches of calls that take turns."""
    found: list[list[float]] = [[] for _ in tasks]
    for _ in range(repeats):
        for task, count, times in zip(tasks, batches, found, strict=True):
            began = clock()
            for _ in range(count):
                task()
            times.append((clock() - began) / count)
    return [float(np.median(times)) for times in found]
