"""The snapshots in the file of a run, which grow one by one and never show an unfinished one.

A snapshot is written into bytes that the file already owns, and then the sizes of all series are
set to include it. HDF5 writes data before sizes in a flush, and the sizes in a row: a run killed
in between leaves some of them set, and what all of them include is what is finished.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nrchain.scene.scene import Scene
from nrchain.trajectory import layout as h5md
from nrchain.trajectory.contents import finished, rows
from nrchain.trajectory.stored import dataset


class Series:
    """The series of a file that is open for writing; ``count`` snapshots of it are finished."""

    def __init__(self, file: Any, scene: Scene) -> None:
        particles = scene.chain.particles
        # looking them up costs as much as writing the snapshot of a small chain
        self._file = file
        self._positions = rows(file, f"{h5md.POSITION}/value", (particles, 3))
        self._frames = rows(file, f"{h5md.FRAME}/value", (particles, 3, 3))
        self._steps = rows(file, f"{h5md.POSITION}/step", (), "i")
        self._times = rows(file, f"{h5md.POSITION}/time", ())
        # H5MD asks for an edge in every direction; those across the chain bound nothing
        self._edges = rows(file, f"{h5md.EDGES}/value", (3,)) if h5md.EDGES in file else None
        self._length = scene.length
        self._finished = dataset(file, h5md.FINISHED, (1,), "i")
        self._all = [file[name] for name in h5md.series(file)]
        self.count = finished(file)
        self.cut(self.count)

    def holds(
        self, index: int, time: float, positions: np.ndarray, frames: np.ndarray, step: int
    ) -> bool:
        """Whether snapshot ``index`` is finished, and is this one to the last bit."""
        return (
            index < self.count
            and self._times[index] == time
            and self._steps[index] == step
            and np.array_equal(self._positions[index], positions)
            and np.array_equal(self._frames[index], frames)
        )

    def append(self, time: float, positions: np.ndarray, frames: np.ndarray, step: int) -> None:
        """Add one snapshot; it counts for whoever reads the file once this returns."""
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
        """Leave no more than the first snapshots."""
        if any(len(series) > count for series in self._all):
            # HDF5 wipes what is beyond a size before it sets the size
            self._finished[0] = count
            self._file.flush()
            for series in self._all:
                series.resize(count, axis=0)
            self._file.flush()
        self.count = count
