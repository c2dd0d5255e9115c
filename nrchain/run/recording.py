"""t_0, t_1, …, t_end: the snapshots of a run, its checkpoints, and the report of its progress."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from nrchain.motion.charts import ChartedChain
from nrchain.motion.integrators.base import Samples
from nrchain.progress import Shown
from nrchain.run.counters import Counters
from nrchain.scene.scene import Scene
from nrchain.trajectory.block import Block
from nrchain.trajectory.checkpoint import Checkpoint
from nrchain.trajectory.recorder import Recorder
from nrchain.types import Poses


@dataclass(frozen=True)
class Progress:
    """How far a run is: time of the end time, snapshots written of all, and its counters."""

    time: float
    end: float
    snapshot: int
    snapshots: int
    counters: dict[str, float]
    wall_time: float

    def shown(self) -> Shown:
        """What the bar of a run shows: the time reached, and the steps taken."""
        steps = f"{self.counters.get('steps', 0):.0f} steps"
        return Shown(self.time, self.end, f"t = {self.time:.4g} of {self.end:.4g}", steps)


def snapshot_times(scene: Scene) -> np.ndarray:
    """The times (T,) at which a scene records its poses, from 0 to its end."""
    return np.linspace(0.0, scene.run.end, scene.run.snapshots)


class Recording:
    """Passes snapshots, checkpoints and counters to a recorder, and reports progress.

    Time spent here is no part of the work of a run, and the stopwatch pauses. ``progress`` runs
    with the treatment of floating-point errors that the caller of the run has set.

    Attributes
    ----------
    times
        (T,) at which snapshots are due.
    snapshot
        Index of the next one.
    """

    def __init__(
        self,
        recorder: Recorder,
        times: np.ndarray,
        counters: Counters,
        progress: Callable[[Progress], None] | None = None,
        snapshot: int = 0,
    ) -> None:
        self.times, self.snapshot = times, snapshot
        self._recorder, self._counters, self._progress = recorder, counters, progress
        self._caller = np.geterr()

    @property
    def end(self) -> float:
        """The time of the last snapshot."""
        return float(self.times[-1])

    @property
    def upcoming(self) -> np.ndarray:
        """The times of snapshots not yet written."""
        return self.times[self.snapshot :]

    @property
    def is_complete(self) -> bool:
        """Whether all snapshots are written."""
        return self.snapshot == len(self.times)

    def due(self, until: float) -> Iterator[float]:
        """The times up to ``until`` of snapshots not yet written; write each before the next."""
        while not self.is_complete and self.times[self.snapshot] <= until:
            yield float(self.times[self.snapshot])

    @property
    def takes_many(self) -> bool:
        """Whether several snapshots may be written at once."""
        return self._recorder.takes_many

    def write(self, time: float, poses: Poses) -> None:
        """Record the poses at ``time`` as the next snapshot."""
        self._write(Block.of_one(time, *poses, int(self._counters.steps)), None)

    def write_sampled(self, samples: Samples, begin: int, end: int) -> None:
        """Record some of the poses that steps have passed as the next snapshots."""
        rows = slice(begin, end)
        counted = samples.counted[rows]
        steps = counted[:, 0] + int(self._counters.steps_after(0))
        sampled = samples.times[rows], samples.positions[rows], samples.frames[rows]
        self._write(Block(*sampled, steps), counted)

    def _write(self, block: Block, counted: np.ndarray | None) -> None:
        """Record a block; ``counted`` are steps and right-hand sides of this run by each snapshot.

        None stands for the present ones.
        """
        first = self.snapshot
        if not (self._recorder.outlives_run or self._progress):
            # a copy in memory takes less time than two looks at the clock
            self._recorder.write(first, block)
            self.snapshot += len(block.time)
            return
        with self._counters.stopwatch.paused():
            self._recorder.write(first, block)
            if self._recorder.outlives_run:
                self.write_counters()
            self.snapshot += len(block.time)
            if self._progress:
                self._report(first, block, counted)

    def _report(self, first: int, block: Block, counted: np.ndarray | None) -> None:
        """Tell the caller of each snapshot of a block."""
        assert self._progress
        for k, time in enumerate(block.time.tolist()):
            counters = self._counters.table()
            if counted is not None:
                counters |= self._counters.at(*counted[k].tolist())
            where = time, self.end, first + k + 1, len(self.times)
            with np.errstate(**self._caller):
                self._progress(Progress(*where, counters, counters["wall_time"]))

    def write_last(self, time: float, poses: Poses) -> None:
        """Record the poses at which a run stops, in place of the snapshot that is due next."""
        if not self.is_complete and time > self.times[self.snapshot - 1]:
            self.write(time, poses)

    def write_checkpoint(self, time: float, chain: ChartedChain) -> None:
        """Record the base of the chain, from which a run can be resumed at ``time``."""
        with self._counters.stopwatch.paused():
            self._recorder.checkpoint(
                Checkpoint(
                    time,
                    chain.base_positions.copy(),
                    chain.base_frames.copy(),
                    self.snapshot,
                    chain.spin,
                    chain.drift.copy(),
                    self._counters.table(),
                )
            )

    def write_counters(self) -> None:
        """Record what the run has counted so far."""
        self._recorder.update_counters(self._counters.table())
