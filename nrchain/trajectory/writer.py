"""The recorder that keeps the trajectory of a run in a file, safe if the run is killed.

Each write goes into space that the file already owns: first the data, then the mark that makes it
valid. A snapshot is valid once all series of the file include it, a checkpoint once its sequence
number is the highest. A run killed at any moment keeps each finished snapshot and a checkpoint to
resume from, and programs that read meanwhile see only finished data.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack, suppress
from pathlib import Path
from types import TracebackType
from typing import Any, ClassVar, Self

import numpy as np

from nrchain.errors import TrajectoryError
from nrchain.outcome import Cause
from nrchain.planning.choice import Choice
from nrchain.scene.scene import Scene
from nrchain.trajectory import layout as h5md
from nrchain.trajectory.block import Block
from nrchain.trajectory.checked_datasets import damage_errors, dataset, require_array
from nrchain.trajectory.checkpoint import (
    Checkpoint,
    counter_numbers,
    counter_table,
    latest_checkpoint,
)
from nrchain.trajectory.data_file import DataFile
from nrchain.trajectory.file import create, file_errors, locate, lock_existing, open_file
from nrchain.trajectory.layout import COUNTERS
from nrchain.trajectory.provenance import Provenance
from nrchain.trajectory.reader import read_choice, read_fields, read_scene
from nrchain.trajectory.rows import write_whole
from nrchain.trajectory.snapshots import SnapshotSeries
from nrchain.trajectory.trajectory import Trajectory
from nrchain.trajectory.write_lock import WriteLock


class TrajectoryWriter:
    """Writes the trajectory of a run of ``scene`` with snapshots at ``times (T,)``.

    ``path`` is the file, or a directory in which to create ``trajectory.h5``. Raises
    :class:`~nrchain.errors.TrajectoryError` if the file exists and ``overwrite`` is not set, if
    another process is writing to it, or if it cannot be created. In a ``with`` statement, an
    exception marks the run as stopped and keeps its snapshots.
    """

    outlives_run: ClassVar[bool] = True
    takes_many: ClassVar[bool] = True

    def __init__(
        self,
        path: str | Path,
        scene: Scene,
        times: np.ndarray,
        *,
        overwrite: bool = False,
        choice: Choice | None = None,
        provenance: Provenance | None = None,
    ) -> None:
        path = locate(path)
        choice_json = choice.to_json() if choice else ""
        steps = provenance.to_json() if provenance else ""
        planned = np.asarray(times, dtype=np.float64)
        self._attach(path, create(path, scene, planned, choice_json, steps, overwrite=overwrite))

    @classmethod
    def reopen(
        cls, path: str | Path, lock: WriteLock | None = None, choice: Choice | None = None
    ) -> Self:
        """Open the file of a run that was killed or stopped, and mark it as running again.

        ``lock`` is its write lock, if the caller holds it already; closing the writer releases it.
        ``choice`` replaces the one in the file, if it differs.
        """
        writer = cls.__new__(cls)
        path = locate(path)
        writer._attach(path, lock or lock_existing(path))
        try:
            with file_errors(path, "cannot be written"):
                if choice is not None and choice != read_choice(writer._file):
                    h5md.replace_text(writer._file, h5md.CHOICE, choice.to_json())
                writer._set_status("running")
        except BaseException:
            writer._close()
            raise
        return writer

    def _attach(self, path: Path, lock: WriteLock) -> None:
        self.path = path
        with ExitStack() as undo:
            undo.callback(lock.release)
            with file_errors(path, "cannot be opened"):
                self._data = DataFile(path)
            undo.callback(self._data.close)
            self._file = open_file(path, "r+")
            try:
                with damage_errors(path):
                    self._find_arrays()
            except TrajectoryError:
                self._file.close()
                raise
            self._release = undo.pop_all()

    def _find_arrays(self) -> None:
        file = self._file
        self.scene = read_scene(file)
        self.times: np.ndarray = dataset(file, h5md.PLANNED, (None,))[()]
        self._series = SnapshotSeries(file, self.scene)
        self._counts = dataset(file, h5md.COUNTS, (len(COUNTERS),))
        self._counters: dict[str, float] = counter_table(self._counts[()])
        self._size = self._data.size()
        self._cut_to: int | None = None

    def write(self, index: int, block: Block) -> None:
        """Record snapshots, the first of them at ``index``.

        Their errors are recorded if the scene has ``run.verify``; without one they are not known.

        Snapshots that the file has already stay as they are. From the first that differs on, new
        ones replace it and all later ones.
        """
        count, particles = len(block.time), self.scene.chain.particles
        require_array(block.time, (count,), "time")
        require_array(block.positions, (count, particles, 3), "positions")
        require_array(block.frames, (count, particles, 3, 3), "frames")
        if index > self._series.count:
            raise ValueError(f"snapshot {index} comes after {self._series.count}, not yet written")
        with file_errors(self.path, "cannot be written"):
            self._refuse_changed()
            held = self._series.held(index, block)
            if held < count:
                self._series.cut(index + held)
                self._series.append(block.part(held, count))

    def checkpoint(self, checkpoint: Checkpoint) -> None:
        """Record where the run can resume, in place of the older of the two checkpoints."""
        state = [checkpoint.time, checkpoint.snapshot, checkpoint.spin, *checkpoint.drift]
        with file_errors(self.path, "cannot be written"):
            self._refuse_changed()
            group = self._file[h5md.CHECKPOINTS]
            sequence = group["sequence"][()]
            slot = int(np.argmin(sequence))
            group["position"][slot] = checkpoint.positions
            group["frame"][slot] = checkpoint.frames
            group["state"][slot] = [*state, *counter_numbers(checkpoint.counters)]
            self._commit(group["sequence"], slot, sequence.max() + 1)

    def latest_checkpoint(self) -> Checkpoint | None:
        """The newest complete checkpoint, or None before the first."""
        return latest_checkpoint(self._file, self.scene.chain.particles)

    def update_counters(self, counters: Mapping[str, float]) -> None:
        """Set some of the :data:`COUNTERS`; they reach the disk with the next snapshot or mark."""
        merged = {**self._counters, **counters}
        counts = counter_numbers(merged)
        with file_errors(self.path, "cannot be written"):
            self._refuse_cut()
            write_whole(self._counts, counts)
        self._counters = merged

    def mark(self, status: str, reason: str = "", cause: Cause | None = None) -> None:
        """Record how the run ended."""
        with file_errors(self.path, "cannot be written"):
            self._refuse_cut()
            self._set_status(status, reason, cause)

    def read(self) -> Trajectory:
        """The trajectory in the file; without a path if the file no longer has its name."""
        path = self.path if self._data.holds(self.path) else None
        with damage_errors(self.path):
            return Trajectory(path=path, **read_fields(self._file))

    def close(
        self, status: str | None = None, reason: str = "", cause: Cause | None = None
    ) -> None:
        """Close the file; ``status``, ``reason`` and ``cause`` say how the run ended, if it has."""
        try:
            if self._file and status is not None:
                self.mark(status, reason, cause)
        finally:
            self._close()

    def _close(self) -> None:
        try:
            with file_errors(self.path, "cannot be closed"):
                self._file.close()
            if self._cut_to is not None:
                # HDF5 has extended the file to its former length, with nothing in it
                self._data.cut(self._cut_to)
        finally:
            self._release.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if error is None:
            self.close()
        elif isinstance(error, KeyboardInterrupt):
            self.close("stopped", "interrupted", Cause.INTERRUPTED)
        else:
            # if the file cannot be written, the first error tells why
            with suppress(*(TrajectoryError,) if isinstance(error, TrajectoryError) else ()):
                self.close("stopped", f"{type(error).__name__}: {error}", Cause.ERROR)

    def _set_status(self, status: str, reason: str = "", cause: Cause | None = None) -> None:
        whole = reason.encode()[: h5md.REASON_BYTES].decode(errors="ignore")
        with file_errors(self.path, "cannot be written"):
            self._file[h5md.REASON][0] = whole.encode()
            self._file[h5md.CAUSE][0] = h5md.CAUSES.index(cause)
            self._commit(self._file[h5md.STATUS], 0, h5md.STATUSES.index(status))

    def _refuse_cut(self) -> None:
        size = self._data.size()
        if size < self._size and self._cut_to is None:
            self._cut_to = size
        if self._cut_to is not None:
            raise TrajectoryError(f"{self.path}: was cut short while it was written")

    def _refuse_changed(self) -> None:
        """Raise if somebody removed, replaced or truncated the file."""
        self._refuse_cut()
        if not self._data.holds(self.path):
            raise TrajectoryError(f"{self.path}: was removed or replaced while it was written")

    def _commit(self, marks: Any, place: int, value: float) -> None:
        """Set the mark that makes data valid, after the data itself has left this process."""
        self._file.flush()
        marks[place] = value
        self._file.flush()
