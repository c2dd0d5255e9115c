"""The snapshots in the file of a run. They grow, and readers see only finished ones.

Snapshots are written into bytes that the file already owns, and then the sizes of all series are
set to include them. In a flush HDF5 writes data before sizes, and the sizes one after the other. If
a run is killed in between, only some of them are set: a snapshot is finished if all include it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nrchain.scene.scene import Scene
from nrchain.trajectory import layout as h5md
from nrchain.trajectory.block import Block
from nrchain.trajectory.checked_datasets import dataset
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

    def held(self, index: int, block: Block) -> int:
        """How many of the first snapshots of a block, from ``index`` on, the file holds.

        They are finished, and equal to the last bit.
        """
        most = min(len(block.time), self.count - index)
        if most <= 0:
            return 0
        rows, new = slice(index, index + most), block.part(0, most)
        errors = new.errors_known()
        there = [self._times, self._steps, self._positions, self._frames, *self._errors]
        here = [new.time, new.steps, new.positions, new.frames, *errors.T]
        equal = np.ones(most, bool)
        for series, values in zip(there, here, strict=False):
            kept = series.data[rows]
            same = (kept == values) | ((kept != kept) & (values != values))
            equal &= same.reshape(most, -1).all(axis=1)
        return most if equal.all() else int(np.argmin(equal))

    def append(self, block: Block) -> None:
        """Add snapshots. Readers of the file see them once this returns."""
        first, count = self.count, self.count + len(block.time)
        try:
            for series in self._all:
                series.resize(count)
            self._positions.write(first, block.positions)
            self._frames.write(first, block.frames)
            self._steps.write(first, block.steps)
            if self._edges is not None:
                self._edges.write(first, np.full((len(block.time), 3), self._length))
            for series, values in zip(self._errors, block.errors_known().T, strict=False):
                series.write(first, values)
            self._times.write(first, block.time)
            self._finished.write(0, [count])
        except BaseException:
            self.cut(first)
            raise
        self._file.flush()
        self.count = count

    def cut(self, count: int) -> None:
        """Keep only the first ``count`` snapshots."""
        if any(len(series.data) > count for series in self._all):
            # HDF5 erases data beyond a size before it sets the size
            self._finished.write(0, [count])
            self._file.flush()
            for series in self._all:
                series.resize(count)
            self._file.flush()
        self.count = count
