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
from nrchain.trajectory.reader import finished_snapshots, snapshot_rows


class SnapshotSeries:
    """The snapshots of a file that is open for writing; ``count`` of them are finished."""

    def __init__(self, file: Any, scene: Scene) -> None:
        particles = scene.chain.particles
        # kept, because looking them up costs as much as writing a snapshot of a small chain
        self._file = file
        self._positions = snapshot_rows(file, f"{h5md.POSITION}/value", (particles, 3))
        self._frames = snapshot_rows(file, f"{h5md.FRAME}/value", (particles, 3, 3))
        self._steps = snapshot_rows(file, f"{h5md.POSITION}/step", (), "i")
        self._times = snapshot_rows(file, f"{h5md.POSITION}/time", ())
        # H5MD wants an edge in each direction, although the box has none across the chain
        self._edges = (
            snapshot_rows(file, f"{h5md.EDGES}/value", (3,)) if h5md.EDGES in file else None
        )
        self._length = scene.length
        self._finished = dataset(file, h5md.FINISHED, (1,), "i")
        self._all = [file[name] for name in h5md.snapshot_series(file)]
        self.count = finished_snapshots(file)
        self.cut(self.count)

    def holds(
        self, index: int, time: float, positions: np.ndarray, frames: np.ndarray, step: int
    ) -> bool:
        """Whether snapshot ``index`` is finished and equal to this one to the last bit."""
        return (
            index < self.count
            and self._times[index] == time
            and self._steps[index] == step
            and np.array_equal(self._positions[index], positions)
            and np.array_equal(self._frames[index], frames)
        )

    def append(self, time: float, positions: np.ndarray, frames: np.ndarray, step: int) -> None:
        """Add one snapshot. Readers of the file see it once this returns."""
        try:
            for series in self._all:
                series.resize(self.count + 1, axis=0)
            self._positions[self.count] = positions
            self._frames[self.count] = frames
            self._steps[self.count] = step
            if self._edges is not None:
                self._edges[self.count] = self._length
            self._times[self.count] = time
            self._finished[0] = self.count + 1
        except BaseException:
            self.cut(self.count)
            raise
        self._file.flush()
        self.count += 1

    def cut(self, count: int) -> None:
        """Keep only the first ``count`` snapshots."""
        if any(len(series) > count for series in self._all):
            # HDF5 erases data beyond a size before it sets the size
            self._finished[0] = count
            self._file.flush()
            for series in self._all:
                series.resize(count, axis=0)
            self._file.flush()
        self.count = count
