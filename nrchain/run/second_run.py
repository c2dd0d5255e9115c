"""A second run of a scene with tighter tolerances, beside the first, snapshot by snapshot."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass, replace
from queue import Empty, Full, Queue
from typing import ClassVar

import numpy as np

from nrchain.hydrodynamics import sharing
from nrchain.notices import ignore
from nrchain.planning.checked_start import starting_poses
from nrchain.run.interruption import GLANCE, FromThread, Interruption
from nrchain.run.preparation import Start, prepare
from nrchain.run.recording import snapshot_times
from nrchain.scene.chain_sections import LEAST_TOLERANCE, TIGHTER
from nrchain.scene.scene import Scene
from nrchain.trajectory.block import Block
from nrchain.trajectory.checkpoint import Checkpoint
from nrchain.types import Poses

AHEAD = 2
"""Snapshots that the second run may be ahead of the first."""


@dataclass(frozen=True)
class Snapshot:
    """The poses of a snapshot, in arrays of their own."""

    index: int
    poses: Poses


@dataclass(frozen=True)
class Ended:
    """The end of the second run, in words."""

    how: str


class SecondRun:
    """Runs a scene in a thread of its own, with tolerances :data:`TIGHTER` times tighter.

    It begins where a fresh run does, also for one that is resumed. It stops with its thread when
    :meth:`leave` is called.
    """

    def __init__(self, start: Start) -> None:
        scene = _tighter(start.scene)
        begin = start.begin
        if isinstance(begin, Checkpoint):
            begin = starting_poses(scene)
        self._start = Start(scene, begin, warned_of_straight=True)
        self._interruption = FromThread("the run that it verifies")
        self._found = Queue[Snapshot | Ended](AHEAD)
        self._arithmetic, self._alone = np.geterr(), sharing.is_alone()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def next(self, interruption: Interruption) -> Snapshot | Ended | None:
        """Wait for the next snapshot, or for the end; None if an interruption comes first."""
        while not interruption.name:
            try:
                return self._found.get(timeout=GLANCE)
            except Empty:
                continue
        return None

    def leave(self) -> None:
        """Stop the run at its next step, and wait for its thread to end."""
        self._interruption.leave()
        self._thread.join()

    def _run(self) -> None:
        feed = _Feed(snapshot_times(self._start.scene), self._hand_over)
        alone = sharing.one_thread() if self._alone else nullcontext()
        try:
            with np.errstate(**self._arithmetic), alone:
                stop = prepare(self._start, feed, None, self._interruption, ignore).run()
            how = "has ended" if stop is None else f"stopped {stop.reason}"
        except Exception as error:
            how = f"failed: {error}"
        self._hand_over(Ended(how))

    def _hand_over(self, found: Snapshot | Ended) -> None:
        while not self._interruption.name:
            try:
                self._found.put(found, timeout=GLANCE)
            except Full:
                continue
            return


def _tighter(scene: Scene) -> Scene:
    """The scene with tighter tolerances, and without a budget."""
    run = replace(
        scene.run,
        rtol=max(scene.run.rtol / TIGHTER, LEAST_TOLERANCE),
        atol=max(scene.run.atol / TIGHTER, LEAST_TOLERANCE),
        verify=False,
        until="end",
        max_steps=None,
        max_seconds=None,
    )
    return replace(scene, run=run)


class _Feed:
    """The recorder of the second run, which hands over each snapshot that is due."""

    outlives_run: ClassVar[bool] = False
    takes_many: ClassVar[bool] = True

    def __init__(self, times: np.ndarray, hand_over: Callable[[Snapshot], None]) -> None:
        self._times, self._hand_over = times, hand_over

    def write(self, index: int, block: Block) -> None:
        for k, (time, positions, frames) in enumerate(zip(*block[:3], strict=True), index):
            # the poses at which a run stops are no snapshot that is due
            if time == self._times[k]:
                self._hand_over(Snapshot(k, (positions.copy(), frames.copy())))

    def checkpoint(self, checkpoint: Checkpoint) -> None:
        """Do nothing: the second run of a resumed one starts anew."""

    def update_counters(self, counters: dict[str, float]) -> None:
        """Do nothing: the trajectory has the counters of the first run."""
