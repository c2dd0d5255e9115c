"""Trajectories: the poses of a chain at the snapshots of a run, in memory and on disk."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

import numpy as np

from nrchain.inputs.names import Named
from nrchain.outcome import Cause
from nrchain.planning.choice import Choice
from nrchain.scene.scene import Scene
from nrchain.trajectory.checked_datasets import damage_errors, require_array
from nrchain.trajectory.checkpoint import Checkpoint, latest_checkpoint
from nrchain.trajectory.file import locate, open_file
from nrchain.trajectory.reader import read_fields


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """The poses of a chain at the snapshots that a run has finished.

    Snapshots are at the times that the scene asks for. If the run stopped, the last one may hold
    the poses at which it stopped.

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

    def __post_init__(self) -> None:
        object.__setattr__(self, "counters", Named(self.counters))
        snapshots, particles = len(self.time), self.scene.chain.particles
        require_array(self.time, (snapshots,), "times")
        require_array(self.positions, (snapshots, particles, 3), "positions")
        require_array(self.frames, (snapshots, particles, 3, 3), "frames")

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

    def __repr__(self) -> str:
        reached = f"to t = {self.time[-1]:.6g}" if len(self.time) else "none finished"
        place = f", {str(self.path)!r}" if self.path else ""
        title = f" {self.scene.title!r}" if self.scene.title else ""
        return (
            f"<Trajectory{title}: {self.scene.chain.particles} spheres, "
            f"{len(self.time)} snapshots {reached}, {self.status}{place}>"
        )
