"""Steps, right-hand sides, Jacobians, solves and seconds: what a run counts."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping

from nrchain.motion.charts import ChartedChain
from nrchain.motion.integrators.base import Integrator
from nrchain.run.work import Stopwatch


class Counters:
    """The counts of one run, added to those of the ``earlier`` runs that it continues.

    The loop counts its ``restarts`` and times its steps with the ``stopwatch``; the chain and the
    integrator count the rest.
    """

    def __init__(
        self, chain: ChartedChain, integrator: Integrator, earlier: Mapping[str, float]
    ) -> None:
        self._chain, self._integrator, self._earlier = chain, integrator, dict(earlier)
        self._began = clock.perf_counter()
        self.stopwatch, self.restarts = Stopwatch(), 0

    @property
    def steps(self) -> float:
        """Steps so far."""
        return self.steps_after(self._integrator.steps)

    def steps_after(self, steps: int) -> float:
        """Steps after so many of the present run."""
        return steps + self._earlier.get("steps", 0)

    def at(self, steps: int, evaluations: int) -> dict[str, float]:
        """Steps and right-hand sides after so many of the present run."""
        counted = {"steps": steps, "evaluations": evaluations}
        return {name: count + self._earlier.get(name, 0) for name, count in counted.items()}

    def table(self) -> dict[str, float]:
        """All counts so far, by name."""
        new = {
            "steps": self._integrator.steps,
            "evaluations": self._chain.evaluations,
            "jacobians": self._chain.jacobians,
            "solves": self._integrator.solves,
            "restarts": self.restarts,
            "wall_time": clock.perf_counter() - self._began,
            "processor_time": self.stopwatch.seconds,
        }
        return {name: value + self._earlier.get(name, 0) for name, value in new.items()}
