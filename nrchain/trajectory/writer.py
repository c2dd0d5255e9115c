"""The writer that keeps the trajectory of a run safe, whenever the run is killed.

Every write goes into space that the file already owns, data first and the mark that makes it count
second: a snapshot counts once the series of the file are long enough to include it, a checkpoint
once its sequence number is the highest. A run killed at any moment therefore keeps every finished
snapshot and a checkpoint to go on from, and programs that read meanwhile find nothing unfinished.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack, suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from nrchain.errors import TrajectoryError
from nrchain.outcome import Cause
from nrchain.planning.choice import Choice
from nrchain.scene.scene import Scene
from nrchain.trajectory import layout as h5md
from nrchain.trajectory.checkpoint import (
    Checkpoint,
    counter_numbers,
    counter_table,
    latest_checkpoint,
)
from nrchain.trajectory.claim import Claim
from nrchain.trajectory.contents import contents, stored_choice, stored_scene
from nrchain.trajectory.data_file import DataFile
from nrchain.trajectory.file import claim_existing, create, locate, open_file, refusing
from nrchain.trajectory.layout import COUNTERS
from nrchain.trajectory.series import Series
from nrchain.trajectory.stored import dataset, require, understanding
from nrchain.trajectory.trajectory import Trajectory


class TrajectoryWriter:
    """Writes the trajectory of a run of ``scene`` with snapshots at ``times (T,)``.

    ``path`` is the file, or a directory in which to make ``trajectory.h5``. Raises
    :class:`~nrchain.errors.TrajectoryError` if the file exists and ``overwrite`` is not set, if
    another process is writing to it, or if it cannot be made. Used in a ``with`` statement, an
    exception marks the run as stopped and keeps what it has.
    """

    def __init__(
        self,
        path: str | Path,
        scene: Scene,
        times: np.ndarray,
        *,
        overwrite: bool = False,
        choice: Choice | None = None,
    ) -> None:
        path = locate(path)
        told = choice.to_json() if choice else ""
        planned = np.asarray(times, dtype=np.float64)
        self._attach(path, create(path, scene, planned, told, overwrite=overwrite))

    @classmethod
    def reopen(
        cls, path: str | Path, claim: Claim | None = None, choice: Choice | None = None
    ) -> Self:
        """Go on with the file of a run that was killed or stopped, marking it as running again.

        ``claim`` is the claim on it, if the caller has that already; closing the writer gives it
        up. ``choice`` is written over the one in the file, if it differs.
        """
        writer = cls.__new__(cls)
        path = locate(path)
        writer._attach(path, claim or claim_existing(path))
        try:
            with refusing(path, "cannot be written"):
                if choice is not None and choice != stored_choice(writer._file):
                    h5md.replace_text(writer._file, h5md.CHOICE, choice.to_json())
                writer._set_status("running")
        except BaseException:
            writer._close()
            raise
        return writer

    def _attach(self, path: Path, claim: Claim) -> None:
        self.path = path
        with ExitStack() as undo:
            undo.callback(claim.release)
            with refusing(path, "cannot be opened"):
                self._data = DataFile(path)
            undo.callback(self._data.close)
            self._file = open_file(path, "r+")
            try:
                with understanding(path):
                    self._find_arrays()
            except TrajectoryError:
                self._file.close()
                raise
            self._release = undo.pop_all()

    def _find_arrays(self) -> None:
        file = self._file
        self.scene = stored_scene(file)
        self.times: np.ndarray = dataset(file, h5md.PLANNED, (None,))[()]
        self._series = Series(file, self.scene)
        self._counts = dataset(file, h5md.COUNTS, (len(COUNTERS),))
        self._counters: dict[str, float] = counter_table(self._counts[()])
        self._size = self._data.size()
        self._cut_to: int | None = None

    def write(
        self, index: int, time: float, positions: np.ndarray, frames: np.ndarray, step: int
    ) -> None:
        """Record snapshot ``index``: ``positions (N, 3)``, ``frames (N, 3, 3)`` after ``step``.

        One that the file has already is left as it is; in place of another one, it is the last.
        """
        particles = self.scene.chain.particles
        require(time, (), "time")
        require(positions, (particles, 3), "positions")
        require(frames, (particles, 3, 3), "frames")
        if index > self._series.count:
            raise ValueError(f"snapshot {index} comes after {self._series.count}, not yet written")
        with refusing(self.path, "cannot be written"):
            self._refuse_changed()
            if not self._series.holds(index, time, positions, frames, step):
                self._series.cut(index)
                self._series.append(time, positions, frames, step)

    def checkpoint(self, checkpoint: Checkpoint) -> None:
        """Record where the run stands, over the older of the two checkpoints."""
        state = [checkpoint.time, checkpoint.snapshot, checkpoint.spin, *checkpoint.drift]
        with refusing(self.path, "cannot be written"):
            self._refuse_changed()
            group = self._file[h5md.CHECKPOINTS]
            sequence = group["sequence"][()]
            slot = int(np.argmin(sequence))
            group["position"][slot] = checkpoint.positions
            group["frame"][slot] = checkpoint.frames
            group["state"][slot] = [*state, *counter_numbers(checkpoint.counters)]
            self._commit(group["sequence"], slot, sequence.max() + 1)

    def latest_checkpoint(self) -> Checkpoint | None:
        """The newest whole checkpoint, or None before the first."""
        return latest_checkpoint(self._file, self.scene.chain.particles)

    def update_counters(self, counters: Mapping[str, float]) -> None:
        """Set the counts named, of :data:`COUNTERS`; they reach the disk with the next mark."""
        merged = {**self._counters, **counters}
        counts = counter_numbers(merged)
        with refusing(self.path, "cannot be written"):
            self._refuse_cut()
            self._counts[:] = counts
        self._counters = merged

    def mark(self, status: str, reason: str = "", cause: Cause | None = None) -> None:
        """Record how the run ended."""
        with refusing(self.path, "cannot be written"):
            self._refuse_cut()
            self._set_status(status, reason, cause)

    def read(self) -> Trajectory:
        """What is in the file, without a path if it no longer has its name."""
        path = self.path if self._data.holds(self.path) else None
        with understanding(self.path):
            return Trajectory(path=path, **contents(self._file))

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
            with refusing(self.path, "cannot be closed"):
                self._file.close()
            if self._cut_to is not None:
                # HDF5 has made it as long as before, with nothing in it
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
            # of a file that cannot be written it is the first failure that tells why
            with suppress(*(TrajectoryError,) if isinstance(error, TrajectoryError) else ()):
                self.close("stopped", f"{type(error).__name__}: {error}", Cause.ERROR)

    def _set_status(self, status: str, reason: str = "", cause: Cause | None = None) -> None:
        whole = reason.encode()[: h5md.REASON_BYTES].decode(errors="ignore")
        with refusing(self.path, "cannot be written"):
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
        """Refuse to go on with a file that somebody has taken away or cut short."""
        self._refuse_cut()
        if not self._data.holds(self.path):
            raise TrajectoryError(f"{self.path}: was removed or replaced while it was written")

    def _commit(self, marks: Any, place: int, value: float) -> None:
        """Set the mark that makes data count, once the data itself has left this process."""
        self._file.flush()
        marks[place] = value
        self._file.flush()
