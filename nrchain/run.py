"""Step, record, checkpoint, report: the loop that takes a scene to a trajectory.

The charts of the chain are left for fresh ones, and the integrator is started again, only at
points that the run itself decides: when a sphere has turned by a quarter of a turn against its
base, or after :data:`RESTART_STEPS` steps. Every such point is kept as a checkpoint. A run that
was killed goes on from the last of them, repeats the snapshots since, and so ends bit for bit
where the uninterrupted run does.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from nrchain.chain import closest_pair, initial_poses
from nrchain.charts import TURN_LIMIT, ChartedChain
from nrchain.errors import SceneError, TrajectoryError
from nrchain.integrators import find_integrator
from nrchain.integrators.base import IntegrationError, Integrator
from nrchain.model import Model
from nrchain.regime import warnings
from nrchain.scene import Scene
from nrchain.trajectory import Checkpoint, Trajectory, TrajectoryWriter

RESTART_STEPS = 2000
"""Steps after which the integrator starts afresh: what a killed run has to repeat at most."""

STALLED = 1e-9
"""Less progress than this part of the run in :data:`RESTART_STEPS` steps: it will not get there."""


@dataclass(frozen=True)
class Progress:
    """Where a run stands: time reached of the end time, snapshots written of all, and its cost."""

    time: float
    end: float
    snapshot: int
    snapshots: int
    counters: dict[str, float]
    wall_time: float


class Recorder(Protocol):
    """What the loop needs of whoever keeps the trajectory."""

    def write(
        self, index: int, time: float, positions: np.ndarray, frames: np.ndarray, step: int
    ) -> None: ...

    def checkpoint(self, checkpoint: Checkpoint) -> None: ...

    def update_counters(self, counters: dict[str, float]) -> None: ...


class _Memory:
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

    def trajectory(self, scene: Scene, status: str, reason: str) -> Trajectory:
        done = np.isfinite(self.time)
        return Trajectory(
            self.time[done],
            self.positions[done],
            self.frames[done],
            scene,
            self.counters,
            status,
            reason,
        )


class _Run:
    """One scene being integrated, from a start or from a checkpoint."""

    def __init__(
        self,
        scene: Scene,
        recorder: Recorder,
        progress: Callable[[Progress], None] | None,
        begin: Checkpoint | None,
        poses: tuple[np.ndarray, np.ndarray],
    ) -> None:
        self.scene, self.recorder, self.progress = scene, recorder, progress
        self.times = snapshot_times(scene)
        self.model = Model(scene)
        self.chain = ChartedChain(self.model)
        self.integrator = make_integrator(scene, self.chain)
        self.earlier = dict(begin.counters) if begin else {}
        self.began = clock.perf_counter()
        self.restarts = 0
        self.fresh_steps = 0
        if begin is None:
            self.time, self.next = 0.0, 0
            self.restarted = 0.0
            self.chain.rebase(0.0, *poses)
            self._record(*poses)
            self._checkpoint()
        else:
            self.time, self.next = begin.time, begin.snapshot
            self.restarted = begin.time
            self.chain.set_base(begin.time, begin.positions, begin.frames, begin.drift, begin.spin)

    @property
    def counters(self) -> dict[str, float]:
        new = {
            "steps": self.integrator.steps,
            "evaluations": self.chain.evaluations,
            "jacobians": self.chain.jacobians,
            "solves": self.integrator.solves,
            "restarts": self.restarts,
            "wall_time": clock.perf_counter() - self.began,
        }
        return {name: value + self.earlier.get(name, 0) for name, value in new.items()}

    def go(self) -> tuple[str, str]:
        """Integrate to the end, or until nothing more can be done: (status, reason)."""
        status, reason = "completed", ""
        try:
            if self.chain.dimension == 0:
                self._hold()
            else:
                self._integrate()
        except IntegrationError as error:
            status, reason = "stopped", f"at t = {self.time:.6g}: {error}"
        self.recorder.update_counters(self.counters)
        return status, reason

    def _hold(self) -> None:
        """Every sphere is clamped: all snapshots are the first."""
        for due in self.times[self.next :]:
            self._record(self.chain.base_positions, self.chain.base_frames, time=due)

    def _integrate(self) -> None:
        still = np.zeros(self.chain.dimension)
        self.integrator.start(self.time, still)
        while self.next < len(self.times):
            before = self.time
            self.time = self.integrator.step()
            self.fresh_steps += 1
            if self.time == before:
                raise IntegrationError("steps have become too small to advance the time")
            while self.next < len(self.times) and self.times[self.next] <= self.time:
                due = self.times[self.next]
                self._record(*self.chain.poses(due, self.integrator.at(due)), time=due)
            if self.next == len(self.times):
                break
            y = self.integrator.at(self.time)
            poses = self.chain.poses(self.time, y)
            self._refuse_contact(poses[0])
            turned = self.chain.largest_turn(y) > TURN_LIMIT
            if self.fresh_steps >= RESTART_STEPS and self._stalled():
                raise IntegrationError(
                    f"{RESTART_STEPS} steps advanced the time by {self.time - self.chain.time:.3g}"
                )
            if turned or self.fresh_steps >= RESTART_STEPS:
                self.chain.rebase(self.time, *poses)
                self._checkpoint()
                self.restarts += 1
                self.integrator.start(self.time, still)

    def _stalled(self) -> bool:
        return self.time - self.restarted < STALLED * self.times[-1]

    def _refuse_contact(self, positions: np.ndarray) -> None:
        distance, i, j = closest_pair(positions, self.model.period)
        if distance <= 2.0 * self.scene.chain.radius:
            raise IntegrationError(
                f"spheres {i} and {j} touch (distance {distance / self.scene.chain.radius:.4g} a)"
            )

    def _record(self, positions: np.ndarray, frames: np.ndarray, time: float | None = None) -> None:
        when = self.time if time is None else float(time)
        self.recorder.write(self.next, when, positions, frames, self.integrator.steps)
        self.recorder.update_counters(self.counters)
        self.next += 1
        if self.progress:
            self.progress(
                Progress(
                    when,
                    float(self.times[-1]),
                    self.next,
                    len(self.times),
                    self.counters,
                    self.counters["wall_time"],
                )
            )

    def _checkpoint(self) -> None:
        self.fresh_steps = 0
        self.restarted = self.time
        chain = self.chain
        self.recorder.checkpoint(
            Checkpoint(
                self.time,
                chain.base_positions,
                chain.base_frames,
                self.next,
                chain.spin,
                chain.drift,
                self.counters,
            )
        )


def snapshot_times(scene: Scene) -> np.ndarray:
    """The times (T,) at which a scene records its poses, from 0 to its end."""
    return np.linspace(0.0, scene.run.end, scene.run.snapshots)


def make_integrator(scene: Scene, chain: ChartedChain) -> Integrator:
    """The integrator of a scene: ``rtol`` of y, ``atol`` in sphere radii and radians."""
    pose = np.repeat([scene.run.atol * scene.chain.radius, scene.run.atol], 3)
    scheme = find_integrator(scene.run.integrator)
    return scheme(chain, scene.run.end, scene.run.rtol, np.tile(pose, chain.dimension // 6))


def starting_poses(
    scene: Scene, positions: np.ndarray | None = None, frames: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """The poses a run starts from: the scene's, or the ones given, checked.

    Raises :class:`~nrchain.errors.SceneError` for poses of the wrong shape, that are not finite,
    frames that are not right-handed and orthonormal to 1e-8, and spheres that overlap.
    """
    built = initial_poses(scene)
    count = scene.chain.particles
    poses = tuple(
        own if given is None else np.array(given, float)
        for given, own in zip((positions, frames), built, strict=True)
    )
    for name, array, shape in zip(
        ("positions", "frames"), poses, ((count, 3), (count, 3, 3)), strict=True
    ):
        if array.shape != shape:
            raise SceneError(name, array.shape, f"the shape must be {shape}")
        if not np.isfinite(array).all():
            raise SceneError(name, "NaN or inf", "all numbers must be finite")
    gram = np.einsum("nak,nbk->nab", poses[1], poses[1])
    if np.abs(gram - np.eye(3)).max() > 1e-8 or np.linalg.det(poses[1]).min() < 0:
        raise SceneError(
            "frames", "not rotations", "rows must be orthonormal and right-handed to 1e-8"
        )
    period = scene.length if scene.chain.ends == "periodic" else 0.0
    distance, i, j = closest_pair(poses[0], period)
    if distance <= 2.0 * scene.chain.radius:
        raise SceneError(
            "start",
            scene.start.shape if positions is None else "positions",
            f"spheres {i} and {j} overlap: they are {distance:.6g} apart and must be more than "
            f"{2 * scene.chain.radius:g}",
        )
    return poses[0], poses[1]


def simulate(
    scene: Scene,
    *,
    output: str | Path | None = None,
    overwrite: bool = False,
    progress: Callable[[Progress], None] | None = None,
    positions: np.ndarray | None = None,
    frames: np.ndarray | None = None,
) -> Trajectory:
    """Integrate v = F/γ_T + Σu, ω = T/γ_R + Σw from the start of a scene to its end.

    Parameters
    ----------
    scene
        What to simulate; see :func:`nrchain.load_scene`.
    output
        File, or directory for a ``trajectory.h5``, to write as the run goes; none: memory only.
    overwrite
        Whether an existing file may be replaced.
    progress
        Called with a :class:`Progress` at every snapshot.
    positions, frames
        (N, 3) and (N, 3, 3): poses to start from in place of the scene's.

    Returns
    -------
    Trajectory
        With ``status`` "completed", or "stopped" with a ``reason`` when the run cannot go on; what
        was reached is kept.

    Raises
    ------
    SceneError
        Before any time is spent, for a start that cannot be simulated.
    TrajectoryError
        When ``output`` exists and ``overwrite`` is not set, or cannot be written.
    """
    poses = starting_poses(scene, positions, frames)
    if output is None:
        memory = _Memory(scene)
        status, reason = _Run(scene, memory, progress, None, poses).go()
        return memory.trajectory(scene, status, reason)
    with TrajectoryWriter(output, scene, snapshot_times(scene), overwrite=overwrite) as writer:
        status, reason = _Run(scene, writer, progress, None, poses).go()
        writer.close(status, reason)
    return Trajectory.open(output)


def resume(path: str | Path, *, progress: Callable[[Progress], None] | None = None) -> Trajectory:
    """Go on with a run that was killed or interrupted, from its last checkpoint to its end.

    The result is that of the uninterrupted run, bit for bit. A run that is complete is returned
    as it is.
    """
    done = Trajectory.open(path)
    if done.status == "completed":
        return done
    begin = done.latest_checkpoint()
    if begin is None:
        raise TrajectoryError(f"{done.path}: was killed before it began; run its scene again")
    with TrajectoryWriter.reopen(path) as writer:
        run = _Run(done.scene, writer, progress, begin, (begin.positions, begin.frames))
        status, reason = run.go()
        writer.close(status, reason)
    return Trajectory.open(path)


@dataclass(frozen=True)
class Description:
    """What a scene simulates and what it leaves out: (effect, one line) each, and warnings."""

    simulated: list[tuple[str, str]]
    left_out: list[tuple[str, str]]
    warnings: list[str]


def describe(scene: Scene) -> Description:
    """The effects a scene names, those it does without, and whether it is in the beam limit."""
    simulated: list[tuple[str, str]] = []
    left_out: list[tuple[str, str]] = []
    for name, modulus in zip(scene.moduli._fields, scene.moduli, strict=True):
        (simulated if modulus else left_out).append(
            (name, f"modulus {modulus:.4g}" if modulus else "modulus 0")
        )
    reach = scene.slip.neighbours
    where = _reach_text(reach)
    for label, mode in scene.slip.modes.items():
        strength = np.unique(mode.strength)
        text = f"{strength[0]:g}" if len(strength) == 1 else f"{strength[0]:g} to {strength[-1]:g}"
        if np.any(strength):
            simulated.append((f"slip {label}", f"strength {text}, {where}"))
        else:
            left_out.append((f"slip {label}", "strength 0"))
    if scene.slip.modes:
        (simulated if scene.slip.finite_size else left_out).append(
            ("finite size", "(a/r)² in the velocity of 2s")
        )
        if reach != "all":
            left_out.append(("long range", f"slip flows beyond {where}"))
    friction = scene.friction
    if friction.kind == "one-body":
        simulated.append(("friction", "one-body"))
        left_out.append(("friction between spheres", "Rotne–Prager–Yamakawa mobilities"))
    else:
        simulated.append(("friction", f"pairwise, {_reach_text(friction.neighbours)}"))
        left_out.append(("near field", "lubrication and reflections, of order (a/r)⁴"))
    left_out.append(("other effects", "Brownian motion, steric repulsion, external fields"))
    return Description(simulated, left_out, warnings(scene))


def _reach_text(neighbours: int | str) -> str:
    if neighbours == "all":
        return "all pairs"
    return f"{neighbours} neighbour{'s' * (neighbours != 1)} a side"
