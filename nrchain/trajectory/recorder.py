"""Who keeps what a run reaches: the interface, and the one that keeps it in memory."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Protocol

import numpy as np

from nrchain.outcome import Stop
from nrchain.scene.memory import refuse_snapshots
from nrchain.scene.scene import Scene
from nrchain.trajectory.checkpoint import Checkpoint
from nrchain.trajectory.trajectory import Trajectory


class Recorder(Protocol):
    """What the loop needs of whoever keeps the trajectory."""

    def write(
        self, index: int, time: float, positions: np.ndarray, frames: np.ndarray, step: int
    ) -> None: ...

    def checkpoint(self, checkpoint: Checkpoint) -> None: ...

    def update_counters(self, counters: dict[str, float]) -> None: ...


class Memory:
    """Keeps a trajectory as arrays.

    Raises :class:`~nrchain.errors.SceneError` for more snapshots than there is memory for.
    """

    def __init__(self, scene: Scene) -> None:
        refuse_snapshots(scene, available_memory(), "free in memory")
        snapshots, count = scene.run.snapshots, scene.chain.particles
        self.time = np.full(snapshots, np.nan)
        self.positions = np.empty((snapshots, count, 3))
        self.frames = np.empty((snapshots, count, 3, 3))
        self.counters: dict[str, float] = {}

    def write(
        self, index: int, time: float, positions: np.ndarray, frames: np.ndarray, step: int
    ) -> None:
        self.positions[index], self.frames[index], self.time[index] = positions, frames, time

    def checkpoint(self, checkpoint: Checkpoint) -> None:
        """Nothing outlives the process."""

    def update_counters(self, counters: dict[str, float]) -> None:
        self.counters = dict(counters)

    def trajectory(self, scene: Scene, stop: Stop | None) -> Trajectory:
        """What was reached, and how it ended."""
        done = int(np.isfinite(self.time).sum())
        return Trajectory(
            self.time[:done],
            self.positions[:done],
            self.frames[:done],
            scene,
            self.counters,
            "stopped" if stop else "completed",
            stop.reason if stop else "",
            cause=stop.cause if stop else None,
        )


def available_memory() -> int:
    """Bytes that can be had without swapping: what Linux estimates, elsewhere the pages unused."""
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        return (
            next(int(line.split()[1]) for line in lines if line.startswith("MemAvailable")) * 1024
        )
    except (OSError, StopIteration):
        pages = "SC_AVPHYS_PAGES" if "SC_AVPHYS_PAGES" in os.sysconf_names else "SC_PHYS_PAGES"
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf(pages)
