"""Trajectories: the poses of a chain at the snapshots of a run, in memory and on disk."""

from __future__ import annotations

import operator
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Self, SupportsIndex, overload

import numpy as np

from nrchain.inputs.names import Named
from nrchain.notebook import table_html
from nrchain.outcome import Cause
from nrchain.planning.choice import Choice
from nrchain.scene.scene import Scene
from nrchain.trajectory.checked_datasets import damage_errors, require_array
from nrchain.trajectory.checkpoint import Checkpoint, latest_checkpoint
from nrchain.trajectory.file import locate, open_file
from nrchain.trajectory.provenance import FROM_SCENE, Provenance
from nrchain.trajectory.reader import read_fields

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, eq=False, repr=False)
class Snapshot:
    """The pose of a chain at one time of a run: an item of a :class:`Trajectory`.

    Parameters
    ----------
    time
        In the units of the scene.
    positions
        ``(N, 3)``, the centres of the spheres.
    frames
        ``(N, 3, 3)``; ``frames[i, k]`` is the vector e_{k+1} of sphere i, in lab components.
    scene
        The scene that was run.
    index
        Which snapshot of the run this is, from 0.
    path
        The file of the run, if there is one.
    position_error, frame_error
        The estimated errors at this time, with ``run.verify``; otherwise None.
    provenance
        What the run started from.

    >>> trajectory = nrchain.simulate(nrchain.load_scene("passive", **{"run.end": 1.0}))
    >>> trajectory[-1].time, trajectory[-1].positions.shape
    (1.0, (20, 3))
    """

    time: float
    positions: np.ndarray
    frames: np.ndarray
    scene: Scene
    index: int
    path: Path | None = None
    position_error: float | None = None
    frame_error: float | None = None
    provenance: Provenance = FROM_SCENE

    def __repr__(self) -> str:
        particles = self.scene.chain.particles
        return f"<Snapshot {self.index} at t = {self.time:.6g}: {particles} spheres>"

    def _repr_html_(self) -> str:
        rows = [("t", self.time), ("scene", repr(self.scene)), ("file", str(self.path or "none"))]
        return table_html(f"Snapshot {self.index}", rows)


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """The poses of a chain at the snapshots that a run has finished.

    Snapshots are at the times that the scene asks for. If the run stopped, the last one may hold
    the poses at which it stopped.

    ``trajectory[-1]`` is a :class:`Snapshot`, ``trajectory[10:20]`` the trajectory of these
    snapshots. The arrays of both are views of those of the whole trajectory and take no memory.
    ``len(trajectory)`` is the number of snapshots, and a loop goes through them in order.

    Parameters
    ----------
    time
        ``(T,)``, in the units of the scene.
    positions
        ``(T, N, 3)``, the centres of the spheres.
    frames
        ``(T, N, 3, 3)``; ``frames[t, i, k]`` is the vector e_{k+1} of sphere i, in lab components.
    scene
        The scene that was run.
    counters
        Steps, evaluations and so on; see :data:`nrchain.trajectory.layout.COUNTERS`.
    status
        ``"completed"``, with a ``reason`` if it settled before its end; ``"stopped"``, with a
        ``cause`` and a ``reason``, one sentence; or ``"running"``, also for a run that was killed.
    cause
        Why a run stopped, with advice: see :class:`~nrchain.outcome.Cause`.
    path
        The file, if there is one.
    choice
        The effects that effects = "auto" left out, with the bound of the error.
    position_error, frame_error
        ``(T,)``, the estimated error of the integration: the largest over the spheres, in the
        scene's unit of length and in radians. NaN where it is not known. None without
        ``run.verify``.
    provenance
        What the run started from, step by step; empty if it started from its scene alone.
    indices
        Which snapshots of the run these are; ``range(T)`` unless the trajectory is a part.

    >>> trajectory = nrchain.simulate(nrchain.load_scene("passive", **{"run.end": 1.0}))
    >>> late = trajectory[50:]
    >>> len(late), late.indices, late[0].index
    (51, range(50, 101), 50)
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
    position_error: np.ndarray | None = None
    frame_error: np.ndarray | None = None
    indices: range = range(0)
    provenance: Provenance = FROM_SCENE

    def __post_init__(self) -> None:
        object.__setattr__(self, "counters", Named(self.counters))
        snapshots, particles = len(self.time), self.scene.chain.particles
        require_array(self.time, (snapshots,), "times")
        require_array(self.positions, (snapshots, particles, 3), "positions")
        require_array(self.frames, (snapshots, particles, 3, 3), "frames")
        if not self.indices:
            object.__setattr__(self, "indices", range(snapshots))
        if len(self.indices) != snapshots:
            raise ValueError(f"indices: {len(self.indices)} of them, not {snapshots}")

    def __len__(self) -> int:
        return len(self.time)

    @overload
    def __getitem__(self, which: SupportsIndex) -> Snapshot: ...

    @overload
    def __getitem__(self, which: slice) -> Self: ...

    def __getitem__(self, which: SupportsIndex | slice) -> Snapshot | Self:
        """One snapshot, also counted from the end, or the trajectory of a slice of them."""
        if isinstance(which, slice):
            return replace(
                self,
                time=self.time[which],
                positions=self.positions[which],
                frames=self.frames[which],
                position_error=_part(self.position_error, which),
                frame_error=_part(self.frame_error, which),
                indices=self.indices[which],
            )
        row = operator.index(which)
        try:
            index = self.indices[row]
        except IndexError:
            have = f"0 to {len(self) - 1}, or -1 for the last" if len(self) else "none is finished"
            raise IndexError(f"there is no snapshot {row}: {have}") from None
        return Snapshot(
            time=float(self.time[row]),
            positions=self.positions[row],
            frames=self.frames[row],
            scene=self.scene,
            index=index,
            path=self.path,
            position_error=_item(self.position_error, row),
            frame_error=_item(self.frame_error, row),
            provenance=self.provenance,
        )

    def __iter__(self) -> Iterator[Snapshot]:
        return (self[row] for row in range(len(self)))

    @classmethod
    def open(cls, path: str | Path) -> Self:
        """Read a trajectory from its file, or from the directory that holds ``trajectory.h5``.

        The file of a run that is still going, was killed or stopped has the snapshots it finished.
        Raises :class:`~nrchain.errors.TrajectoryError` for a file that is missing, damaged or not
        written by nrchain.
        """
        path = locate(path)
        with open_file(path, "r") as file, damage_errors(path):
            return cls(path=path, **read_fields(file))

    def to_xarray(self) -> xarray.Dataset:
        """A labelled dataset: ``position`` (time, sphere, axis), ``frame`` (…, vector, axis).

        Units are attributes of the variables. The keys of the scene, such as ``slip.2s``, are
        attributes of the dataset, and so are ``scene``, its TOML without given poses, and
        ``provenance``. Needs the extra ``exchange``; raises
        :class:`~nrchain.errors.MissingLibraryError` without it.

        >>> trajectory = nrchain.simulate(nrchain.load_scene("passive", **{"run.end": 1.0}))
        >>> trajectory.to_xarray()["position"].sel(axis="x").dims
        ('time', 'sphere')
        """
        from nrchain.trajectory.labelled import labelled_dataset

        names = ("time", "positions", "frames", "position_error", "frame_error")
        series = {name: getattr(self, name) for name in names}
        steps = self.provenance.to_json()
        return labelled_dataset(self.scene, series, status=self.status, provenance=steps)

    @property
    def advice(self) -> str:
        """What to try if the run stopped; empty if it did not."""
        if self.cause is None:
            return ""
        slips = any(np.any(mode.strength) for mode in self.scene.slip.modes.values())
        return self.cause.advice if slips else self.cause.advice_without_slip

    def latest_checkpoint(self) -> Checkpoint | None:
        """Where the run can be resumed; None if it is not on disk or has no checkpoint."""
        if self.path is None:
            return None
        with open_file(self.path, "r") as file, damage_errors(self.path):
            return latest_checkpoint(file, self.scene.chain.particles)

    def _repr_html_(self) -> str:
        times = f"{self.time[0]:.6g} to {self.time[-1]:.6g}" if len(self) else "none finished"
        rows: list[tuple[str, object]] = [
            ("scene", repr(self.scene)),
            ("status", ": ".join(filter(None, (self.status, self.reason)))),
            ("snapshots", len(self)),
            ("t", times),
            *((name, value) for name, value in self.counters.items() if value),
            ("file", str(self.path or "none")),
        ]
        if self.provenance:
            rows.append(("start", self.provenance.line))
        if self.cause is not None:
            rows.append(("advice", self.advice))
        return table_html("Trajectory", rows)

    def __repr__(self) -> str:
        reached = f"to t = {self.time[-1]:.6g}" if len(self.time) else "none finished"
        place = f", {str(self.path)!r}" if self.path else ""
        title = f" {self.scene.title!r}" if self.scene.title else ""
        return (
            f"<Trajectory{title}: {self.scene.chain.particles} spheres, "
            f"{len(self.time)} snapshots {reached}, {self.status}{place}>"
        )


def _part(errors: np.ndarray | None, which: slice) -> np.ndarray | None:
    return None if errors is None else errors[which]


def _item(errors: np.ndarray | None, row: int) -> float | None:
    return None if errors is None else float(errors[row])
