"""Trajectories: what a run leaves, in memory and on disk."""

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
from nrchain.trajectory.checkpoint import Checkpoint, latest_checkpoint
from nrchain.trajectory.contents import contents
from nrchain.trajectory.file import locate, open_file
from nrchain.trajectory.stored import require, understanding


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
        Steps, evaluations and so on, see :data:`nrchain.trajectory.layout.COUNTERS`.
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
        object.__setattr__(self, "counters", Named(self.counters))
        snapshots, particles = len(self.time), self.scene.chain.particles
        require(self.time, (snapshots,), "times")
        require(self.positions, (snapshots, particles, 3), "positions")
        require(self.frames, (snapshots, particles, 3, 3), "frames")

    @classmethod
    def open(cls, path: str | Path) -> Self:
        """Read a trajectory from its file, or from the directory that holds ``trajectory.h5``.

        A run that is still going, was killed or stopped gives the snapshots it finished. Raises
        :class:`~nrchain.errors.TrajectoryError` for a file that is missing, damaged or not ours.
        """
        path = locate(path)
        with open_file(path, "r") as file, understanding(path):
            return cls(path=path, **contents(file))

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
        with open_file(self.path, "r") as file, understanding(self.path):
            return latest_checkpoint(file, self.scene.chain.particles)

    def __repr__(self) -> str:
        reached = f"to t = {self.time[-1]:.6g}" if len(self.time) else "none finished"
        place = f", {str(self.path)!r}" if self.path else ""
        return (
            f"<Trajectory {self.scene.title!r}: {self.scene.chain.particles} spheres, "
            f"{len(self.time)} snapshots {reached}, {self.status}{place}>"
        )
