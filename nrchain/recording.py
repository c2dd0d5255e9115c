"""Who keeps what a run reaches: the interface, and the one that keeps it in memory."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from nrchain.outcome import Stop
from nrchain.scene import Scene
from nrchain.trajectory import Checkpoint, Trajectory


class Recorder(Protocol):
    """What the loop needs of whoever keeps the trajectory."""

    def write(
        self, index: int, time: float, positions: np.ndarray, frames: np.ndarray, step: int
    ) -> None: ...

    def checkpoint(self, checkpoint: Checkpoint) -> None: ...

    def update_counters(self, counters: dict[str, float]) -> None: ...


class Memory:
    """Keeps a trajectory as arrays."""

    def __init__(self, scene: Scene) -> None:
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
        done = np.isfinite(self.time)
        return Trajectory(
            self.time[done],
            self.positions[done],
            self.frames[done],
            scene,
            self.counters,
            "stopped" if stop else "completed",
            stop.reason if stop else "",
            cause=stop.cause if stop else None,
        )
