"""Step, watch, record, and start afresh: the loop of a run.

The loop replaces the charts of the chain and restarts the integrator only at points that the run
itself determines: when a sphere has turned by a quarter turn against its base or is farther from it
than the chain is long, or after :data:`RESTART_STEPS` steps. It keeps every such point as a
checkpoint. A run that was killed resumes from the last checkpoint, repeats the snapshots since, and
ends bit for bit where the uninterrupted run does, if both load their kernels from disk: the first
run after an installation compiles them and differs from later ones in rounding.
"""

from __future__ import annotations

import time as clock

import numpy as np

from nrchain.errors import TrajectoryError
from nrchain.motion.chart_poses import TURN_LIMIT
from nrchain.motion.charts import ChartedChain
from nrchain.motion.integrators.base import IntegrationError, Integrator, Samples
from nrchain.outcome import Cause, Settled, Stop
from nrchain.run.budget import Budget, Pace
from nrchain.run.counters import Counters
from nrchain.run.recording import Recording
from nrchain.run.watches import Watches
from nrchain.types import Poses

RESTART_STEPS = 2000
"""Steps after which the integrator starts afresh: the most that a resumed run has to repeat."""

STALLED = 1e-9
"""A run that advances by less than this part of its time in :data:`RESTART_STEPS` steps fails."""

SAMPLE_BYTES = 2**22
"""Room for poses that are sampled between two looks at a run."""

CHART_LIMIT = 2e3
"""|θ| = 2 tan(α/2) above which a chart is not to be trusted: 1e-3 rad from a half turn."""


class Loop:
    """Integrates a charted chain from its poses at ``time`` until all snapshots are recorded."""

    def __init__(
        self,
        chain: ChartedChain,
        integrator: Integrator,
        watches: Watches,
        recording: Recording,
        counters: Counters,
        budget: Budget,
        time: float,
        poses: Poses,
    ) -> None:
        self.chain, self.integrator, self.watches = chain, integrator, watches
        self.recording, self.counters, self.budget = recording, counters, budget
        self.time, self.poses = time, poses
        self._restarted, self._fresh_steps = time, 0
        self._pace, self._checks = Pace(), watches.checks
        count = len(poses[0])
        room = max(SAMPLE_BYTES // (96 * count), 1)
        self._samples = Samples(min(room, len(recording.times)), count)

    def run(self) -> Stop | Settled | None:
        """Integrate to the end; return why the run stops or is complete, if it is so before."""
        stop = None
        try:
            # numbers beyond the range of floats are found in what they lead to
            with np.errstate(all="ignore"):
                if self.chain.dimension == 0:
                    self._hold()
                else:
                    self._integrate()
        except Settled as event:
            self.recording.write_counters()
            return event
        except Stop as event:
            stop = event
        except IntegrationError as error:
            stop = Stop(error.cause, self.time, str(error))
        except (ArithmeticError, np.linalg.LinAlgError) as error:
            stop = Stop(Cause.NOT_FINITE, self.time, str(error))
        except TrajectoryError as error:
            # nothing more can be written
            return Stop(Cause.ERROR, self.time, str(error))
        if stop is not None:
            self.recording.write_last(self.time, self.poses)
        self.recording.write_counters()
        return stop

    def _hold(self) -> None:
        """Record the first poses throughout: every sphere is clamped."""
        for due in self.recording.due(self.recording.end):
            self.recording.write(due, self.poses)

    def _integrate(self) -> None:
        stopwatch = self.counters.stopwatch
        stopwatch.go()
        self._start_integrator()
        while not self.recording.is_complete:
            self.budget.check(self.time, self.counters.steps)
            self._advance()
            reached = self.integrator.reached
            if reached == self.time:
                raise IntegrationError("steps have become too small to advance the time")
            y = self.integrator.at(reached)
            turned = self.chain.largest_turn(y)
            if turned > CHART_LIMIT:
                # before anything of this step is recorded: its poses mean nothing
                raise Stop(Cause.CHART, self.time, "a step has turned a sphere by a half turn")
            try:
                self._process_step(reached, y)
            finally:
                stopwatch.lap(self.chain.evaluations)
            if not self.recording.is_complete:
                left = turned > TURN_LIMIT or self.chain.has_outrun_base(y)
                self._restart_if_due(left and not self.integrator.renews_chart)

    def _advance(self) -> None:
        """Take steps up to the first that has to be looked at; ``time`` is then its beginning."""
        integrator, before = self.integrator, self.integrator.steps
        left = self.budget.steps_left(self.counters.steps)
        most = min(RESTART_STEPS - self._fresh_steps, self._pace.steps, left)
        began, samples = clock.perf_counter(), self._samples
        samples.want(self.recording.upcoming)
        try:
            integrator.advance(samples, most, self._checks)
        except Exception:
            self._record()
            self._pass(integrator.reached, integrator.steps - before)
            raise
        self._record()
        taken = integrator.steps - before
        self._pace.measure(taken, clock.perf_counter() - began)
        self._fresh_steps += 1
        if taken > 1:
            self._pass(integrator.begin, taken - 1)

    def _record(self) -> None:
        """Record what was sampled in steps that need no look."""
        samples, watched = self._samples, self.watches.look_at_snapshots
        if not samples.taken:
            return
        if self.recording.takes_many and not watched:
            self.recording.write_sampled(samples, 0, samples.taken)
            return
        for k in range(samples.taken):
            self.recording.write_sampled(samples, k, k + 1)
            poses = samples.positions[k], samples.frames[k]
            self.watches.check_snapshot(float(samples.times[k]), poses)

    def _pass(self, time: float, steps: int) -> None:
        """Note that so many steps led to ``time``, none of which has to be looked at."""
        if steps:
            self._fresh_steps += steps
            self.time, self.poses = time, self._poses_at(time)

    def _process_step(self, reached: float, y: np.ndarray) -> None:
        """Watch the step just taken and record the snapshots in it; raise the stop that ends it."""
        end = min(reached, self.recording.end)
        poses = self._poses_at(end)
        stop = self.watches.check_step(self.time, self.poses[0], end, poses, self._poses_at, y)
        until = end if stop is None else stop.time
        for due in self.recording.due(until):
            snapshot = self._poses_at(due)
            self.recording.write(due, snapshot)
            self.watches.check_snapshot(due, snapshot)
        if stop is None or stop.cause is not Cause.NOT_FINITE:
            self.time, self.poses = until, poses if stop is None else self._poses_at(until)
        if stop is not None:
            raise stop

    def _poses_at(self, time: float) -> Poses:
        """Poses at a time within the last step, in arrays of their own."""
        return self.integrator.poses_at(time)

    def _restart_if_due(self, has_left_chart: bool) -> None:
        """Take new charts about the poses reached, record them and restart the integrator."""
        many = self._fresh_steps >= RESTART_STEPS
        advance = self.time - self._restarted
        if many and advance < STALLED * self.recording.end:
            raise IntegrationError(f"{RESTART_STEPS} steps advanced the time by {advance:.3g}")
        if not (has_left_chart or many):
            return
        self.chain.rebase(self.time, *self.poses)
        self.counters.restarts += 1
        self._fresh_steps, self._restarted = 0, self.time
        self.recording.write_checkpoint(self.time, self.chain)
        self.watches.restart()
        self._start_integrator()

    def _start_integrator(self) -> None:
        self.integrator.start(self.time, np.zeros(self.chain.dimension))
