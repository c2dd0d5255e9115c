"""Runs side by side: how far each is from a reference, and the wall time it takes."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from statistics import median
from typing import Any
from warnings import catch_warnings

import numpy as np

from nrchain.errors import SceneError, SceneWarning
from nrchain.run import Progress, simulate
from nrchain.scene import Scene, load_scene
from nrchain.trajectory import Trajectory

REPEATS = 5

FIRST_STEPS = 3
"""Steps by which everything that a run compiles has been called."""


@dataclass(frozen=True)
class Measured:
    """One setting: its distance from the reference, and what it costs.

    ``position`` is the largest distance of a sphere in radii, over all snapshots, and ``frame`` the
    largest angle between frames, in radians; infinite if the run did not reach its end. ``seconds``
    are those of all repetitions; ``late`` is the part of them that fell in the second half of the
    time simulated.
    """

    position: float
    frame: float
    seconds: tuple[float, ...]
    late: float
    steps: int
    evaluations: int
    jacobians: int

    @property
    def error(self) -> float:
        """The larger of the two, in radii and radians."""
        return max(self.position, self.frame)

    @property
    def median(self) -> float:
        return median(self.seconds)


def distance(trajectory: Trajectory, reference: Trajectory) -> tuple[float, float]:
    """max |r − r′|/a and max ∠(frame, frame′) over spheres and snapshots, in radii and radians.

    The angle is that of the rotation between frames, exact down to rounding. Infinite where the
    snapshots are not those of the reference, as of a run that stopped before its end.
    """
    if not np.array_equal(trajectory.time, reference.time):
        return math.inf, math.inf
    apart = np.linalg.norm(trajectory.positions - reference.positions, axis=-1)
    between = np.einsum("tnak,tnam->tnkm", trajectory.frames, reference.frames)
    sine = np.linalg.norm(
        [between[..., (k + 2) % 3, (k + 1) % 3] - between[..., (k + 1) % 3, (k + 2) % 3]
         for k in range(3)],
        axis=0,
    )  # fmt: skip
    cosine = np.trace(between, axis1=-2, axis2=-1) - 1.0
    radius = reference.scene.chain.radius
    return float(apart.max() / radius), float(np.arctan2(sine, cosine).max())


def simulate_quietly(scene: Scene, **options: Any) -> Trajectory:
    """A run in memory, without warnings of settings that are tried to be measured."""
    with catch_warnings(action="ignore", category=SceneWarning):
        return simulate(scene, **options)


def prepare(scene: Scene) -> None:
    """Take a few steps, so that the kernels of a scene are compiled before anything is timed."""
    simulate_quietly(load_scene(scene, **{"run.max_steps": FIRST_STEPS}))


def run_timed(scene: Scene) -> tuple[Trajectory, float, float]:
    """A run in memory, its wall time in seconds, and the part of it in the second half of t."""
    half = 0.0

    def watch(progress: Progress) -> None:
        nonlocal half
        if progress.time <= 0.5 * progress.end:
            half = progress.wall_time

    began = clock.perf_counter()
    trajectory = simulate_quietly(scene, progress=watch)
    seconds = clock.perf_counter() - began
    return trajectory, seconds, 1.0 - half / seconds


def measure_all(
    scenes: Mapping[str, Scene],
    reference: Trajectory,
    *,
    repeats: int = REPEATS,
    seconds: float = math.inf,
    skip: Callable[[str, Mapping[str, Measured]], bool] | None = None,
) -> dict[str, Measured]:
    """Run scenes side by side, and again and again, against a reference with their snapshots.

    Repetitions are interleaved, so that what else the machine does falls on all alike. Every scene
    runs once, unless ``skip`` of its name and of what has been measured so far says no; repetitions
    begin until ``seconds`` have passed. A scene whose integrator refuses it, or whose start its
    tolerance does not resolve, is left out.
    """
    began = clock.perf_counter()
    found: dict[str, Measured] = {}
    for name, scene in scenes.items():
        if skip and skip(name, found):
            continue
        try:
            prepare(scene)
            trajectory, took, late = run_timed(scene)
        except SceneError as error:
            if error.key not in ("run.integrator", "run.atol"):
                raise
            continue
        counts = (int(trajectory.counters[k]) for k in ("steps", "evaluations", "jacobians"))
        found[name] = Measured(*distance(trajectory, reference), (took,), late, *counts)
    for _ in range(repeats - 1):
        for name, measured in found.items():
            if clock.perf_counter() - began + measured.seconds[0] < seconds:
                took = run_timed(scenes[name])[1]
                found[name] = replace(measured, seconds=(*measured.seconds, took))
    return found
