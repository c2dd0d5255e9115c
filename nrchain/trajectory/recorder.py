"""What a run writes its snapshots to: the interface, and the recorder that keeps them in memory."""

from __future__ import annotations

import os
from pathlib import Path
from typing import ClassVar, Protocol

import numpy as np

from nrchain.outcome import Settled, Stop
from nrchain.planning.choice import Choice
from nrchain.scene.memory import refuse_snapshots, snapshot_bytes
from nrchain.scene.scene import Scene
from nrchain.trajectory.block import Block
from nrchain.trajectory.checkpoint import Checkpoint
from nrchain.trajectory.error_estimate import NOT_KNOWN
from nrchain.trajectory.provenance import FROM_SCENE, Provenance
from nrchain.trajectory.trajectory import Trajectory

SMALL = 2**24
"""Bytes of a trajectory below which it is not compared with what is free."""


class Recorder(Protocol):
    """What a run needs of the object that keeps its trajectory.

    Attributes
    ----------
    outlives_run
        Whether what is written remains if the run is killed: then counters go with every block.
    takes_many
        Whether a block may have more than one snapshot.
    """

    @property
    def outlives_run(self) -> bool: ...

    @property
    def takes_many(self) -> bool: ...

    def write(self, index: int, block: Block) -> None: ...

    def checkpoint(self, checkpoint: Checkpoint) -> None: ...

    def update_counters(self, counters: dict[str, float]) -> None: ...


class MemoryRecorder:
    """Keeps a trajectory as arrays in memory.

    Raises :class:`~nrchain.errors.SceneError` for more snapshots than fit the memory.
    """

    outlives_run: ClassVar[bool] = False
    takes_many: ClassVar[bool] = True

    def __init__(self, scene: Scene) -> None:
        if snapshot_bytes(scene) * scene.run.snapshots > SMALL:
            refuse_snapshots(scene, available_memory(), "free in memory")
        snapshots, count = scene.run.snapshots, scene.chain.particles
        self.time = np.full(snapshots, np.nan)
        self.positions = np.empty((snapshots, count, 3))
        self.frames = np.empty((snapshots, count, 3, 3))
        self.errors = np.full((snapshots, 2), NOT_KNOWN) if scene.run.verify else None
        self.counters: dict[str, float] = {}

    def write(self, index: int, block: Block) -> None:
        rows = slice(index, index + len(block.time))
        self.positions[rows], self.frames[rows] = block.positions, block.frames
        self.time[rows] = block.time
        if self.errors is not None and block.errors is not None:
            self.errors[rows] = block.errors

    def checkpoint(self, checkpoint: Checkpoint) -> None:
        """Do nothing: memory does not outlive the process."""

    def update_counters(self, counters: dict[str, float]) -> None:
        self.counters = dict(counters)

    def trajectory(
        self,
        scene: Scene,
        stop: Stop | Settled | None,
        choice: Choice | None = None,
        provenance: Provenance = FROM_SCENE,
    ) -> Trajectory:
        """The snapshots so far, how the run ended, and what it left out and started from."""
        cause = stop.cause if isinstance(stop, Stop) else None
        done = int(np.isfinite(self.time).sum())
        return Trajectory(
            self.time[:done],
            self.positions[:done],
            self.frames[:done],
            scene,
            self.counters,
            "completed" if cause is None else "stopped",
            stop.reason if stop else "",
            cause=cause,
            choice=choice,
            provenance=provenance,
            position_error=None if self.errors is None else self.errors[:done, 0],
            frame_error=None if self.errors is None else self.errors[:done, 1],
        )


def available_memory() -> int:
    """Bytes free without swapping: the estimate of Linux, elsewhere the unused pages."""
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        return (
            next(int(line.split()[1]) for line in lines if line.startswith("MemAvailable")) * 1024
        )
    except (OSError, StopIteration):
        pages = "SC_AVPHYS_PAGES" if "SC_AVPHYS_PAGES" in os.sysconf_names else "SC_PHYS_PAGES"
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf(pages)
