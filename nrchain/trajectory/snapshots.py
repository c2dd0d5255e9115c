"""The snapshots in the file of a run. They grow one by one, and readers see only finished ones.

A snapshot is written into bytes that the file already owns, and then the sizes of all series are
set to include it. In a flush HDF5 writes data before sizes, and the sizes one after the other. If a
run is killed in between, only some of them are set: a snapshot is finished if all include it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nrchain.scene.scene import Scene
from nrchain.trajectory import layout as h5md
from nrchain.trajectory.checked_datasets import dataset
from nrchain.trajectory.error_estimate import ErrorEstimate
from nrchain.trajectory.reader import finished_snapshots, snapshot_rows
from nrchain.trajectory.rows import Rows


class SnapshotSeries:
    """The snapshots of a file that is open for writing; ``count`` of them are finished."""

    def __init__(self, file: Any, scene: Scene) -> None:
        particles = scene.chain.particles
        # kept, because looking them up costs as much as writing a snapshot of a small chain
        self._file = file
        self._positions = Rows(snapshot_rows(file, f"{h5md.POSITION}/value", (particles, 3)))
        self._frames = Rows(snapshot_rows(file, f"{h5md.FRAME}/value", (particles, 3, 3)))
        self._steps = Rows(snapshot_rows(file, f"{h5md.POSITION}/step", (), "i"))
        self._times = Rows(snapshot_rows(file, f"{h5md.POSITION}/time", ()))
        self._all = [self._positions, self._frames, self._steps, self._times]
        self._edges = None
        if h5md.EDGES in file:
            # H5MD wants an edge in each direction, although the box has none across the chain
            self._edges = Rows(snapshot_rows(file, f"{h5md.EDGES}/value", (3,)))
            self._all.append(self._edges)
        self._errors = [
            Rows(snapshot_rows(file, f"{element}/value", ()))
            for element in h5md.ERRORS.values()
            if element in file
        ]
        self._all += self._errors
        self._length = scene.length
        self._finished = Rows(dataset(file, h5md.FINISHED, (1,), "i"))
        self.count = finished_snapshots(file)
        self.cut(self.count)

    def holds(
        self,
        index: int,
        time: float,
        positions: np.ndarray,
        frames: np.ndarray,
        step: int,
        error: ErrorEstimate,
    ) -> bool:
        """Whether snapshot ``index`` is finished and equal to this one to the last bit."""
        return (
            index < self.count
            and self._times.data[index] == time
            and self._steps.data[index] == step
            and np.array_equal(self._positions.data[index], positions)
            and np.array_equal(self._frames.data[index], frames)
            and all(
                np.array_equal(series.data[index], value, equal_nan=True)
                for series, value in zip(self._errors, error, strict=False)
            )
        )

    def append(
        self,
        time: float,
        positions: np.ndarray,
        frames: np.ndarray,
        step: int,
        error: ErrorEstimate,
    ) -> None:
        """Add one snapshot. Readers of the file see it once this returns."""
        try:
            for series in self._all:
                series.resize(self.count + 1)
            self._positions.write(self.count, positions)
            self._frames.write(self.count, frames)
            self._steps.write(self.count, step)
            if self._edges is not None:
                self._edges.write(self.count, self._length)
            for series, value in zip(self._errors, error, strict=False):
                series.write(self.count, value)
            self._times.write(self.count, time)
            self._finished.write(0, self.count + 1)
        except BaseException:
            self.cut(self.count)
            raise
        self._file.flush()
        self.count += 1

    def cut(self, count: int) -> None:
        """Keep only the first ``count`` snapshots."""
        if any(len(series.data) > count for series in self._all):
            # HDF5 erases data beyond a size before it sets the size
            self._finished.write(0, count)
            self._file.flush()
            for series in self._all:
                series.resize(count)
            self._file.flush()
        self.count = count
