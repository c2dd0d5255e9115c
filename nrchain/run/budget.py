"""run.max_steps, run.max_seconds and signals: what ends a run between two steps."""

from __future__ import annotations

import sys
import time as clock

from nrchain.outcome import Cause, Stop
from nrchain.run.interruption import Interruption

LOOK = 0.02
"""Seconds between two looks at signals and budgets, where steps take less."""


class Pace:
    """How many steps fit between two looks, by the time that the last ones took.

    >>> pace = Pace()
    >>> pace.steps
    1
    >>> pace.measure(1, 0.001)
    >>> pace.steps
    10
    """

    def __init__(self) -> None:
        self.steps = 1

    def measure(self, taken: int, seconds: float) -> None:
        """Note that so many steps took so many seconds."""
        fit = int(taken * LOOK / max(seconds, 1e-9))
        self.steps = min(max(fit, 1), 10 * self.steps)


class Budget:
    """Stops a run that has used up its steps or its seconds, or that a signal interrupts.

    ``max_steps`` and ``max_seconds`` set no limit where they are None. The first ``repeated`` steps
    of a resumed run repeat an earlier one. They are free: a budget shorter than the way from
    checkpoint to checkpoint would otherwise never get past them.
    """

    def __init__(
        self,
        max_steps: int | None,
        max_seconds: float | None,
        interruption: Interruption,
        repeated: float = 0,
    ) -> None:
        self._max_steps, self._max_seconds = max_steps, max_seconds
        self._interruption, self._repeated = interruption, repeated
        self._since = clock.perf_counter()

    def check(self, time: float, steps: float) -> None:
        """Raise :class:`~nrchain.outcome.Stop` if the run, now at ``time``, must end."""
        if self._interruption.name:
            raise Stop(Cause.INTERRUPTED, time, f"interrupted by {self._interruption.name}")
        if steps < self._repeated:
            self._since = clock.perf_counter()
            return
        if self._max_steps is not None and steps - self._repeated >= self._max_steps:
            raise Stop(Cause.BUDGET, time, f"its {self._max_steps} steps are used up")
        spent = clock.perf_counter() - self._since
        if self._max_seconds is not None and spent > self._max_seconds:
            raise Stop(Cause.BUDGET, time, f"its {self._max_seconds:g} s are used up")

    def steps_left(self, steps: float) -> int:
        """How many steps may follow the first ``steps``."""
        if self._max_steps is None:
            return sys.maxsize
        return max(int(self._repeated + self._max_steps - steps), 1)
