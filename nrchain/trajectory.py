"""Trajectories: what a run leaves, in memory and on disk, and the writer that keeps it safe.

Every write goes into space that the file already owns, data first and the mark that makes it count
second: a snapshot counts once its time is set, a checkpoint once its sequence number is the
highest. A run killed at any moment therefore keeps every finished snapshot and a checkpoint to go
on from.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from nrchain import h5md
from nrchain.choice import Choice
from nrchain.claim import Claim
from nrchain.errors import TrajectoryError
from nrchain.h5md import COUNTERS
from nrchain.outcome import Cause
from nrchain.scene import Scene
from nrchain.stored import dataset, meaning, text, understanding

__all__ = ["COUNTERS", "Checkpoint", "Trajectory", "TrajectoryWriter"]


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """All that a run needs to go on from ``time``.

    ``positions (N, 3)`` and ``frames (N, 3, 3)`` are the poses, ``snapshot`` the index of the next
    snapshot to write, ``spin`` and ``drift (3,)`` the angular velocity and the velocity of the
    frame of reference that the integrator works in, ``counters`` the counts so far.
    """

    time: float
    positions: np.ndarray
    frames: np.ndarray
    snapshot: int
    spin: float
    drift: np.ndarray
    counters: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """The poses of a chain at the snapshots that a run has finished.

    Snapshots are at the times the scene asks for; one of a run that stopped may come last, with
    the poses at which it did.

    Parameters
    ----------
    time
        ``(T,)``, in the units of the scene.
    positions
        ``(T, N, 3)``, the centres of the spheres.
    frames
        ``(T, N, 3, 3)``; ``frames[t, i, k]`` is the vector e_{k+1} of sphere i, in lab components.
    scene
        What was run.
    counters
        Steps, evaluations and so on, see :data:`COUNTERS`.
    status
        ``"completed"``; ``"stopped"``, with a ``cause`` and a ``reason``, one sentence; or
        ``"running"``, which is also how a killed run is left.
    cause
        Why a run stopped, with advice: see :class:`~nrchain.outcome.Cause`.
    path
        Where the file is, if there is one.
    choice
        What was left out, with its bound, if the effects were chosen for a tolerance.
    """

    time: np.ndarray
    positions: np.ndarray
    frames: np.ndarray
    scene: Scene
    counters: Mapping[str, float] = field(default_factory=dict)
    status: str = "completed"
    reason: str = ""
    path: Path | None = None
    cause: Cause | None = None
    choice: Choice | None = None

    def __post_init__(self) -> None:
        snapshots, particles = len(self.time), self.scene.chain.particles
        _require(self.time, (snapshots,), "times")
        _require(self.positions, (snapshots, particles, 3), "positions")
        _require(self.frames, (snapshots, particles, 3, 3), "frames")

    @classmethod
    def open(cls, path: str | Path) -> Self:
        """Read a trajectory from its file, or from the directory that holds ``trajectory.h5``.

        A run that is still going, was killed or stopped gives the snapshots it finished. Raises
        :class:`~nrchain.errors.TrajectoryError` for a file that is missing, damaged or not ours.
        """
        path = h5md.locate(path)
        with h5md.open_file(path, "r") as file, understanding(path):
            return cls(path=path, **_contents(file))

    @property
    def advice(self) -> str:
        """What to try after a run of this scene that stopped; empty if it did not."""
        if self.cause is None:
            return ""
        slips = any(np.any(mode.strength) for mode in self.scene.slip.modes.values())
        return self.cause.advice if slips else self.cause.advice_without_slip

    def latest_checkpoint(self) -> Checkpoint | None:
        """Where the run can be taken up again; None if it is not on disk or has no checkpoint."""
        if self.path is None:
            return None
        with h5md.open_file(self.path, "r") as file, understanding(self.path):
            return _latest_checkpoint(file, self.scene.chain.particles)

    def __repr__(self) -> str:
        reached = f"to t = {self.time[-1]:.6g}" if len(self.time) else "none finished"
        place = f", {str(self.path)!r}" if self.path else ""
        return (
            f"<Trajectory {self.scene.title!r}: {self.scene.chain.particles} spheres, "
            f"{len(self.time)} snapshots {reached}, {self.status}{place}>"
        )


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
        path = h5md.locate(path)
        told = choice.to_json() if choice else ""
        planned = np.asarray(times, dtype=np.float64)
        self._attach(path, h5md.create(path, scene, planned, told, overwrite=overwrite))

    @classmethod
    def reopen(cls, path: str | Path, choice: Choice | None = None) -> Self:
        """Go on with the file of a run that was killed or stopped, marking it as running again.

        ``choice`` is written over the one in the file, if it differs.
        """
        writer = cls.__new__(cls)
        path = h5md.locate(path)
        h5md.refuse_missing(path)
        with h5md.refusing(path, "cannot be opened"):
            claim = Claim(path)
        writer._attach(path, claim)
        try:
            with h5md.refusing(path, "cannot be written"):
                if choice is not None and choice != _choice(writer._file):
                    h5md.replace_text(writer._file, h5md.CHOICE, choice.to_json())
                writer._set_status("running")
        except BaseException:
            writer._close()
            raise
        return writer

    def _attach(self, path: Path, claim: Claim) -> None:
        self.path, self._claim = path, claim
        try:
            self._file = h5md.open_file(path, "r+")
            try:
                with understanding(path):
                    self._find_arrays()
            except TrajectoryError:
                self._file.close()
                raise
        except BaseException:
            claim.release()
            raise

    def _find_arrays(self) -> None:
        """Look up what every snapshot needs: on a small chain that costs as much as writing it."""
        file = self._file
        self.scene = _scene(file)
        count, any_number = self.scene.chain.particles, None
        self.times: np.ndarray = dataset(file, h5md.PLANNED, (any_number,))[()]
        snapshots = len(self.times)
        self._positions = dataset(file, f"{h5md.POSITION}/value", (snapshots, count, 3))
        self._frames = dataset(file, f"{h5md.FRAME}/value", (snapshots, count, 3, 3))
        self._steps = dataset(file, f"{h5md.POSITION}/step", (snapshots,), "i")
        self._times = dataset(file, f"{h5md.POSITION}/time", (snapshots,))
        self._finished = np.isfinite(self._times[()])
        self._counts = dataset(file, h5md.COUNTS, (len(COUNTERS),))
        self._counters: dict[str, float] = _counters(self._counts[()])
        self._size = self._claim.size()
        self._cut_to: int | None = None

    def write(
        self, index: int, time: float, positions: np.ndarray, frames: np.ndarray, step: int
    ) -> None:
        """Record snapshot ``index``: ``positions (N, 3)``, ``frames (N, 3, 3)`` after ``step``."""
        particles = self.scene.chain.particles
        _require(time, (), "time")
        _require(positions, (particles, 3), "positions")
        _require(frames, (particles, 3, 3), "frames")
        with h5md.refusing(self.path, "cannot be written"):
            self._refuse_changed()
            if self._finished[index]:
                self._commit(self._times, index, np.nan)
            self._positions[index] = positions
            self._frames[index] = frames
            self._steps[index] = step
            self._commit(self._times, index, time)
        self._finished[index] = True

    def checkpoint(self, checkpoint: Checkpoint) -> None:
        """Record where the run stands, over the older of the two checkpoints."""
        state = [checkpoint.time, checkpoint.snapshot, checkpoint.spin, *checkpoint.drift]
        with h5md.refusing(self.path, "cannot be written"):
            self._refuse_changed()
            group = self._file[h5md.CHECKPOINTS]
            sequence = group["sequence"][()]
            slot = int(np.argmin(sequence))
            group["position"][slot] = checkpoint.positions
            group["frame"][slot] = checkpoint.frames
            group["state"][slot] = [*state, *_counts(checkpoint.counters)]
            self._commit(group["sequence"], slot, sequence.max() + 1)

    def latest_checkpoint(self) -> Checkpoint | None:
        """The newest whole checkpoint, or None before the first."""
        return _latest_checkpoint(self._file, self.scene.chain.particles)

    def update_counters(self, counters: Mapping[str, float]) -> None:
        """Set the counts named, of :data:`COUNTERS`; they reach the disk with the next mark."""
        merged = {**self._counters, **counters}
        counts = _counts(merged)
        with h5md.refusing(self.path, "cannot be written"):
            self._refuse_cut()
            self._counts[:] = counts
        self._counters = merged

    def mark(self, status: str, reason: str = "", cause: Cause | None = None) -> None:
        """Record how the run ended."""
        with h5md.refusing(self.path, "cannot be written"):
            self._refuse_cut()
            self._set_status(status, reason, cause)

    def read(self) -> Trajectory:
        """What is in the file, without a path if it no longer has its name."""
        path = self.path if self._claim.holds(self.path) else None
        with understanding(self.path):
            return Trajectory(path=path, **_contents(self._file))

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
            with h5md.refusing(self.path, "cannot be closed"):
                self._file.close()
        finally:
            if self._cut_to is not None:
                # HDF5 has made it as long as before, with nothing in it
                self._claim.cut(self._cut_to)
            self._claim.release()

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
        with h5md.refusing(self.path, "cannot be written"):
            self._file[h5md.REASON][0] = whole.encode()
            self._file[h5md.CAUSE][0] = h5md.CAUSES.index(cause)
            self._commit(self._file[h5md.STATUS], 0, h5md.STATUSES.index(status))

    def _refuse_cut(self) -> None:
        size = self._claim.size()
        if size < self._size and self._cut_to is None:
            self._cut_to = size
        if self._cut_to is not None:
            raise TrajectoryError(f"{self.path}: was cut short while it was written")

    def _refuse_changed(self) -> None:
        """Refuse to go on with a file that somebody has taken away or cut short."""
        self._refuse_cut()
        if not self._claim.holds(self.path):
            raise TrajectoryError(f"{self.path}: was removed or replaced while it was written")

    def _commit(self, marks: Any, place: int, value: float) -> None:
        """Set the mark that makes data count, once the data itself has left this process."""
        self._file.flush()
        marks[place] = value
        self._file.flush()


def _contents(file: Any) -> dict[str, Any]:
    scene = _scene(file)
    count, any_number = scene.chain.particles, None
    times = dataset(file, f"{h5md.POSITION}/time", (any_number,))
    snapshots = len(times)
    # The times come first: data marked as finished by now stays as it is while a run goes on.
    time = times[()]
    finished = np.isfinite(time)
    positions = dataset(file, f"{h5md.POSITION}/value", (snapshots, count, 3))
    frames = dataset(file, f"{h5md.FRAME}/value", (snapshots, count, 3, 3))
    reason = dataset(file, h5md.REASON, (1,), "S")[0].decode(errors="replace")
    return {
        "time": time[finished],
        "positions": _finished(positions, finished),
        "frames": _finished(frames, finished),
        "scene": scene,
        "counters": _counters(dataset(file, h5md.COUNTS, (len(COUNTERS),))[()]),
        "status": meaning(file, h5md.STATUS, h5md.STATUSES),
        "reason": " ".join(reason.split()),
        "cause": meaning(file, h5md.CAUSE, h5md.CAUSES),
        "choice": _choice(file),
    }


def _finished(values: Any, finished: np.ndarray) -> np.ndarray:
    """The values of the finished snapshots, without reading those that a run did not get to."""
    end = int(finished.sum())
    return values[:end] if finished[:end].all() else values[finished]


def _scene(file: Any) -> Scene:
    return Scene.from_toml(text(file, h5md.SCENE))


def _choice(file: Any) -> Choice | None:
    return Choice.from_json(text(file, h5md.CHOICE)) if h5md.CHOICE in file else None


def _latest_checkpoint(file: Any, particles: int) -> Checkpoint | None:
    sequence = dataset(file, f"{h5md.CHECKPOINTS}/sequence", (2,), "i")[()]
    if not sequence.any():
        return None
    slot, width = int(np.argmax(sequence)), h5md.CHECKPOINT_STATE + len(COUNTERS)
    state = dataset(file, f"{h5md.CHECKPOINTS}/state", (2, width))[slot]
    positions = dataset(file, f"{h5md.CHECKPOINTS}/position", (2, particles, 3))[slot]
    frames = dataset(file, f"{h5md.CHECKPOINTS}/frame", (2, particles, 3, 3))[slot]
    for name, values in {"state": state, "position": positions, "frame": frames}.items():
        _require(values, values.shape, f"{h5md.CHECKPOINTS}/{name}")
    time, snapshot, spin, *rest = state.tolist()
    return Checkpoint(
        time=time,
        positions=positions,
        frames=frames,
        snapshot=int(snapshot),
        spin=spin,
        drift=np.array(rest[:3]),
        counters=_counters(rest[3:]),
    )


def _counts(counters: Mapping[str, float]) -> list[float]:
    """The numbers of a table of counters, in the order of the file."""
    unknown = sorted(counters.keys() - set(COUNTERS))
    if unknown:
        raise ValueError(f"no such counter as {unknown[0]!r}; known are {', '.join(COUNTERS)}")
    return [float(counters.get(name, 0)) for name in COUNTERS]


def _counters(counts: Iterable[float]) -> dict[str, float]:
    """The table of counters from its numbers; all but the times are whole."""
    table = dict(zip(COUNTERS, counts, strict=True))
    for name, count in table.items():
        if not 0 <= count < np.inf:
            raise ValueError(f"{h5md.COUNTS}: {name} = {count}")
    return {name: float(n) if name in h5md.TIMES else int(n) for name, n in table.items()}


def _require(array: np.ndarray | float, shape: tuple[int, ...], name: str) -> None:
    """Refuse an array of another shape, which HDF5 would spread out, and one with NaN or inf."""
    if np.shape(array) != shape:
        raise ValueError(f"{name}: shape {np.shape(array)}, not {shape}")
    if not np.all(np.isfinite(array)):
        raise ValueError(f"{name}: not all values are finite")
