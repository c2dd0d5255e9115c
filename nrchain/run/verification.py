"""error(t) ≈ max |r(t) − r′(t)| over the spheres: r′ is a run with tighter tolerances.

The second run takes ``run.rtol`` and ``run.atol`` over
:data:`~nrchain.scene.chain_sections.TIGHTER`, from the same start, in a thread of its own. The
first waits for it at each snapshot and records the distance between the two. Its own steps are
those of a run that is not verified.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import ClassVar

import numpy as np

from nrchain.geometry.distances import pose_distances
from nrchain.notices import Report
from nrchain.outcome import Cause, Stop
from nrchain.run.interruption import Interruption
from nrchain.run.preparation import Start
from nrchain.run.recording import snapshot_times
from nrchain.run.second_run import Ended, SecondRun, Snapshot
from nrchain.scene.chain_sections import TIGHTER
from nrchain.trajectory.block import Block
from nrchain.trajectory.error_estimate import NOT_KNOWN, ErrorEstimate
from nrchain.trajectory.recorder import Recorder
from nrchain.types import Poses


@contextmanager
def verified(
    start: Start, recorder: Recorder, interruption: Interruption, report: Report
) -> Iterator[Recorder]:
    """The recorder of a run; where ``run.verify`` is set, one that adds the errors."""
    if not start.scene.run.verify:
        yield recorder
        return
    second = SecondRun(start)
    try:
        times = snapshot_times(start.scene)
        yield _VerifiedRecorder(recorder, times, second, interruption, report)
    finally:
        second.leave()


class _VerifiedRecorder:
    """Records each snapshot with its distance from that of the second run."""

    takes_many: ClassVar[bool] = False

    def __init__(
        self,
        recorder: Recorder,
        times: np.ndarray,
        second: SecondRun,
        interruption: Interruption,
        report: Report,
    ) -> None:
        self._recorder, self._times, self._second = recorder, times, second
        self._interruption, self._report = interruption, report
        self.outlives_run = recorder.outlives_run
        self._latest: Snapshot | Ended | None = None
        self.checkpoint, self.update_counters = recorder.checkpoint, recorder.update_counters

    def write(self, index: int, block: Block) -> None:
        poses = block.positions[0], block.frames[0]
        errors = np.array([self._error(index, float(block.time[0]), poses)])
        self._recorder.write(index, block._replace(errors=errors))

    def _error(self, index: int, time: float, poses: Poses) -> ErrorEstimate:
        if time != self._times[index]:
            # a run that stops between two snapshots
            return NOT_KNOWN
        if index == 0:
            # both runs begin at the same poses: a signal at the start need not wait for the second
            return ErrorEstimate(0.0, 0.0)
        there = self._wait(index, time)
        if isinstance(there, Ended):
            return NOT_KNOWN
        apart, turned = pose_distances(poses, there.poses)
        return ErrorEstimate(float(apart.max()), float(turned.max()))

    def _wait(self, index: int, time: float) -> Snapshot | Ended:
        """The snapshot of the second run, or its end if it does not get there.

        Raises :class:`~nrchain.outcome.Stop` if a signal arrives first.
        """
        while not isinstance(self._latest, Ended):
            if self._latest is not None and self._latest.index == index:
                return self._latest
            self._latest = self._second.next(self._interruption)
            if self._latest is None:
                name = self._interruption.name
                raise Stop(Cause.INTERRUPTED, time, f"interrupted by {name}")
            if isinstance(self._latest, Ended):
                self._report(
                    f"the error is not known from t = {time:.6g} on: the run with tolerances "
                    f"{TIGHTER:g} times tighter {self._latest.how}"
                )
        return self._latest
