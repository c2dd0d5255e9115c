"""Step, watch, record, checkpoint: the loop that takes a scene to a trajectory.

The charts of the chain are left for fresh ones, and the integrator is started again, only at
points that the run itself decides: when a sphere has turned by a quarter of a turn against its
base or come farther from it than the chain is long, or after :data:`RESTART_STEPS` steps. Every
such point is kept as a checkpoint. A run that was killed goes on from the last of them, repeats the
snapshots since, and so ends bit for bit where the uninterrupted run does, if both load their
kernels from disk: the first run after an installation compiles them, and differs from later ones in
rounding.
"""

from __future__ import annotations

import re
import time as clock
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from nrchain.errors import SceneError, TrajectoryError
from nrchain.inputs.arguments import ORTHONORMAL, rotations
from nrchain.motion.charts import TURN_LIMIT, ChartedChain
from nrchain.motion.integrators import find_integrator
from nrchain.motion.integrators.base import IntegrationError, Integrator
from nrchain.motion.model import Model
from nrchain.notices import Tell, warn
from nrchain.outcome import Cause, Stop
from nrchain.planning.choice import Choice, Watch
from nrchain.planning.flow_forces import stokeslet_warning
from nrchain.planning.start import refuse_far, starting_poses, with_start
from nrchain.run.folders import made
from nrchain.run.interruption import Interruption, deferred
from nrchain.run.work import Stopwatch
from nrchain.scene.scene import Scene
from nrchain.trajectory.checkpoint import Checkpoint
from nrchain.trajectory.claim import Claim
from nrchain.trajectory.file import FILE_NAME, claim_existing, locate, refuse_existing, refusing
from nrchain.trajectory.recorder import Memory, Recorder
from nrchain.trajectory.trajectory import Trajectory
from nrchain.trajectory.writer import TrajectoryWriter
from nrchain.types import Poses
from nrchain.watch.growth import GrowthWatch
from nrchain.watch.guard import Guard
from nrchain.watch.seed import seed_warning

RESTART_STEPS = 2000
"""Steps after which the integrator starts afresh: what a killed run has to repeat at most."""

STALLED = 1e-9
"""Less progress than this part of the run in :data:`RESTART_STEPS` steps: it will not get there."""

ENDINGS = (".h5", ".hdf5", ".h5md")
"""Of trajectory files."""

_ENDING = re.compile(r"\.[A-Za-z]\w*")

CHART_LIMIT = 2e3
"""|θ| = 2 tan(α/2) at which a chart is no longer to be trusted: 1e-3 rad from a half turn."""


@dataclass(frozen=True)
class Progress:
    """Where a run stands: time reached of the end time, snapshots written of all, and its cost."""

    time: float
    end: float
    snapshot: int
    snapshots: int
    counters: dict[str, float]
    wall_time: float


class _Run:
    """One scene being integrated, from starting poses or from a checkpoint."""

    def __init__(
        self,
        scene: Scene,
        recorder: Recorder,
        progress: Callable[[Progress], None] | None,
        interruption: Interruption,
        begin: Checkpoint | Poses,
        repeated: float = 0,
        choice: Choice | None = None,
        told: bool = False,
        tell: Tell = warn,
    ) -> None:
        self.scene, self.recorder, self.progress = scene, recorder, progress
        self.caller = np.geterr()
        self.interruption = interruption
        self.times = snapshot_times(scene)
        self.chain = ChartedChain(Model(scene))
        self.neglected = Watch(scene, choice, self.chain.model)
        self.integrator = make_integrator(scene, self.chain)
        self.began = self.spending = clock.perf_counter()
        self.stopwatch = Stopwatch()
        self.repeated = repeated
        self.restarts = self.fresh_steps = 0
        if isinstance(begin, Checkpoint):
            self.earlier = dict(begin.counters)
            self.time, self.next, self.restarted = begin.time, begin.snapshot, begin.time
            self.chain.set_base(begin.time, begin.positions, begin.frames, begin.drift, begin.spin)
            self.positions, self.frames = begin.positions, begin.frames
        else:
            self.earlier = {}
            self.time, self.next, self.restarted = 0.0, 0, 0.0
            self.positions, self.frames = begin
            self.chain.rebase(0.0, *begin)
            self._record(0.0, *begin)
            self._checkpoint()
        self.guard = Guard(scene, self.positions)
        self.growth = GrowthWatch(scene, self.integrator, tell, told=told)

    @property
    def counters(self) -> dict[str, float]:
        new = {
            "steps": self.integrator.steps,
            "evaluations": self.chain.evaluations,
            "jacobians": self.chain.jacobians,
            "solves": self.integrator.solves,
            "restarts": self.restarts,
            "wall_time": clock.perf_counter() - self.began,
            "processor_time": self.stopwatch.seconds,
        }
        return {name: value + self.earlier.get(name, 0) for name, value in new.items()}

    def go(self) -> Stop | None:
        """Integrate to the end, or until nothing more can be done, and tell why."""
        stop = None
        try:
            # numbers beyond the range of floats are found in what they lead to
            with np.errstate(all="ignore"):
                if self.chain.dimension == 0:
                    self._hold()
                else:
                    self._integrate()
        except Stop as event:
            stop = event
        except IntegrationError as error:
            stop = Stop(error.cause, self.time, str(error))
        except (ArithmeticError, np.linalg.LinAlgError) as error:
            stop = Stop(Cause.NOT_FINITE, self.time, str(error))
        except TrajectoryError as error:
            # nothing more can be written
            return Stop(Cause.ERROR, self.time, str(error))
        if stop is not None:
            self._record_last()
        self.recorder.update_counters(self.counters)
        return stop

    def _hold(self) -> None:
        """Every sphere is clamped: all snapshots are the first."""
        for due in self.times[self.next :]:
            self._record(due, self.positions, self.frames)

    def _integrate(self) -> None:
        self.stopwatch.go()
        still = np.zeros(self.chain.dimension)
        self.integrator.start(self.time, still)
        while self.next < len(self.times):
            self._keep_to_budget()
            reached = self.integrator.step()
            self.fresh_steps += 1
            if reached == self.time:
                raise IntegrationError("steps have become too small to advance the time")
            y = self.integrator.at(reached)
            turned = self.chain.largest_turn(y)
            if turned > CHART_LIMIT:
                # before anything in this step is recorded: its poses mean nothing
                raise Stop(Cause.CHART, self.time, "a step has turned a sphere by a half turn")
            try:
                self._go_over(reached, y)
            finally:
                self.stopwatch.lap(self.chain.evaluations)
            if self.next == len(self.times):
                break
            if self.fresh_steps >= RESTART_STEPS and self._stalled():
                raise IntegrationError(
                    f"{RESTART_STEPS} steps advanced the time by {self.time - self.restarted:.3g}"
                )
            left = turned > TURN_LIMIT or self.chain.has_outrun_base(y)
            if left or self.fresh_steps >= RESTART_STEPS:
                self.chain.rebase(self.time, self.positions, self.frames)
                self.restarts += 1
                self._checkpoint()
                self.growth.restart()
                self.integrator.start(self.time, still)

    def _keep_to_budget(self) -> None:
        limits = self.scene.run
        if self.interruption.name:
            raise Stop(Cause.INTERRUPTED, self.time, f"interrupted by {self.interruption.name}")
        steps = self.integrator.steps + self.earlier.get("steps", 0)
        if steps < self.repeated:
            # what an earlier run reached is free, or small budgets would never come past it
            self.spending = clock.perf_counter()
            return
        if limits.max_steps is not None and steps - self.repeated >= limits.max_steps:
            raise Stop(Cause.BUDGET, self.time, f"{limits.max_steps} steps are spent")
        spent = clock.perf_counter() - self.spending
        if limits.max_seconds is not None and spent > limits.max_seconds:
            raise Stop(Cause.BUDGET, self.time, f"{limits.max_seconds:g} s are spent")

    def _go_over(self, reached: float, y: np.ndarray) -> None:
        """Record what is due in the step just taken; end it where an event does."""
        end = min(reached, float(self.times[-1]))
        poses = self._poses_at(end)
        stop = self.guard.watch(self.time, self.positions, end, poses, self._poses_at)
        if stop is None:
            stop = self.growth.watch(self.time, end, poses, y)
        until = end if stop is None else stop.time
        while self.next < len(self.times) and self.times[self.next] <= until:
            due = float(self.times[self.next])
            positions, frames = self._poses_at(due)
            self._record(due, positions, frames)
            self.guard.judge_friction(due, positions)
            self.neglected.check(due, (positions, frames))
        if stop is None or stop.cause is not Cause.NOT_FINITE:
            self.time = until
            self.positions, self.frames = poses if stop is None else self._poses_at(until)
        if stop is not None:
            raise stop

    def _poses_at(self, time: float) -> Poses:
        """Poses at a time within the last step, in arrays of their own."""
        positions, frames = self.chain.poses(time, self.integrator.at(time))
        return positions.copy(), frames.copy()

    def _stalled(self) -> bool:
        return self.time - self.restarted < STALLED * self.times[-1]

    def _record(self, time: float, positions: np.ndarray, frames: np.ndarray) -> None:
        with self.stopwatch.paused():
            self._tell(time, positions, frames)

    def _tell(self, time: float, positions: np.ndarray, frames: np.ndarray) -> None:
        """What others do with a snapshot: it is no part of the work of a run."""
        self.recorder.write(self.next, time, positions, frames, int(self.counters["steps"]))
        self.recorder.update_counters(self.counters)
        self.next += 1
        if self.progress:
            counters = self.counters
            where = time, float(self.times[-1]), self.next, len(self.times)
            # what is called is the caller's, with the caller's treatment of floating-point errors
            with np.errstate(**self.caller):
                self.progress(Progress(*where, counters, counters["wall_time"]))

    def _record_last(self) -> None:
        """The poses at which a run stops, in the place of the snapshot it was on the way to."""
        last = self.times[self.next - 1]
        if self.next < len(self.times) and self.time > last:
            self._record(self.time, self.positions, self.frames)

    def _checkpoint(self) -> None:
        self.fresh_steps = 0
        self.restarted = self.time
        chain = self.chain
        with self.stopwatch.paused():
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
    """The integrator of a scene: ``atol`` in radii and radians, ``rtol`` of the coordinates y.

    The error of a step is held below one in the norm √mean((e/w)²) over all coordinates of all
    spheres, w = ``atol`` + ``rtol`` |y|: y is how far a sphere has come and turned from a base that
    drifts and spins as the chain does, in the units of ``atol``.
    """
    pose = np.repeat([scene.run.atol * scene.chain.radius, scene.run.atol], 3)
    scheme = find_integrator(scene.run.integrator)
    return scheme(chain, scene.run.end, scene.run.rtol, np.tile(pose, chain.dimension // 6))


def simulate(
    scene: Scene,
    *,
    output: str | Path | None = None,
    overwrite: bool = False,
    progress: Callable[[Progress], None] | None = None,
    positions: np.ndarray | None = None,
    frames: np.ndarray | None = None,
    choice: Choice | None = None,
) -> Trajectory:
    """Integrate v = F/γ_T + Σu, ω = T/γ_R + Σw from the start of a scene to its end.

    Parameters
    ----------
    scene
        What to simulate; see :func:`nrchain.load_scene`.
    output
        File (``.h5``, ``.hdf5`` or ``.h5md``), or directory for a ``trajectory.h5``, which is made
        if need be, to write as the run goes; none: memory only.
    overwrite
        Whether an existing file may be replaced.
    progress
        Called with a :class:`Progress` at every snapshot.
    positions, frames
        (N, 3) and (N, 3, 3): poses to start from in place of the scene's. Positions of a periodic
        chain may be wrapped: each link takes the image that is nearest to its rest length along x
        (:func:`nrchain.scene.unwrapping.unwrapped`), and the trajectory holds the unwrapped chain.
        Of frames rounded to 32 bits the nearest rotations are taken.
    choice
        What the effects of the scene leave out, as :func:`nrchain.auto.choose` found it: kept
        beside the scene, and watched. A scene with ``effects = "auto"`` makes its own.

    Returns
    -------
    Trajectory
        With ``status`` "completed", or "stopped" with a ``cause`` and a ``reason`` when the run
        cannot go on or has spent its budget; what was reached is kept, with the poses at which it
        stopped for a last snapshot.

    Warns
    -----
    SceneWarning
        For a start that is straight, or hardly above ``run.atol``, on a chain whose waves grow, and
        for spheres held or pushed against a background flow with one-body friction.

    Raises
    ------
    SceneError
        Before any time is spent, for a start that cannot be simulated, such as wrapped positions
        of which the image is not clear.
    TrajectoryError
        When ``output`` exists and ``overwrite`` is not set, or cannot be made. Of a file that is
        removed or replaced meanwhile what was reached is returned, with no ``path``; one that is
        cut short meanwhile is lost.
    KeyboardInterrupt
        On Ctrl-C and SIGTERM, once the step under way is done and the file is closed in order.
    """
    return simulate_telling(
        warn,
        scene,
        output=output,
        overwrite=overwrite,
        progress=progress,
        positions=positions,
        frames=frames,
        choice=choice,
    )


def simulate_telling(
    tell: Tell,
    scene: Scene,
    *,
    output: str | Path | None = None,
    overwrite: bool = False,
    progress: Callable[[Progress], None] | None = None,
    positions: np.ndarray | None = None,
    frames: np.ndarray | None = None,
    choice: Choice | None = None,
) -> Trajectory:
    """:func:`simulate`, which calls ``tell`` with the text of what it would warn of."""
    place = None if output is None else output_file(output, overwrite)
    poses = starting_poses(scene, positions, frames)
    if positions is not None or frames is not None:
        scene = with_start(scene, *poses)
    if scene.effects == "auto":
        from nrchain.planning.auto import choose

        scene, choice = choose(scene, poses)
    straight = seed_warning(scene, *poses)
    # where effects were chosen, what they drop is bounded
    held = stokeslet_warning(scene, *poses) if choice is None else ""
    for text in filter(None, (straight, held)):
        tell(text)

    def run(recorder: Recorder, interruption: Interruption) -> Stop | None:
        with interruption.second_at_once():
            return _Run(
                scene,
                recorder,
                progress,
                interruption,
                poses,
                choice=choice,
                told=bool(straight),
                tell=tell,
            ).go()

    if place is None:
        memory = Memory(scene)
        with deferred() as interruption:
            stop = run(memory, interruption)
        return replace(memory.trajectory(scene, stop), choice=choice)
    folder, path = place
    with (
        deferred() as interruption,
        made(folder) if folder else nullcontext(),
        TrajectoryWriter(
            path, scene, snapshot_times(scene), overwrite=overwrite, choice=choice
        ) as writer,
    ):
        return _finish(writer, run(writer, interruption))


def output_file(output: str | Path, overwrite: bool = False) -> tuple[Path | None, Path]:
    """The folder to make, if one is named, and the file: ``output`` itself if it ends as one.

    A dot and a number, as in ``runs/R1e7.5``, make no ending. Raises
    :class:`~nrchain.errors.TrajectoryError` for the ending of another kind of file, and for a file
    that exists and is not to be replaced.
    """
    path = Path(output)
    with refusing(path, "cannot be made"):
        is_folder = path.is_dir() or not _ENDING.fullmatch(path.suffix)
        if not is_folder and path.suffix.lower() not in ENDINGS:
            raise TrajectoryError(
                f"{path}: must be a folder, or a file that ends in {', '.join(ENDINGS)}"
            )
        file = path / FILE_NAME if is_folder else path
        refuse_existing(file, overwrite)
    return path if is_folder else None, file


def resume(
    path: str | Path,
    *,
    unwatched: bool = False,
    progress: Callable[[Progress], None] | None = None,
) -> Trajectory:
    """Go on with a run that was killed or interrupted, from its last checkpoint to its end.

    The result is that of the uninterrupted run, bit for bit. A run that is complete is returned
    as it is. The budget of the scene holds for what is new.

    A run keeps its effects to its end. One that stopped because of what ``effects = "auto"`` left
    out goes on with ``unwatched`` alone: no bound is kept from there on, and its ``choice`` says
    so. Raises :class:`~nrchain.errors.TrajectoryError` without it, with the keys that name what is
    left out: a run of the scene with those is another run.
    """
    done = Trajectory.open(path)
    if done.status == "completed":
        return done
    with claim_existing(locate(path)) as claim:
        # what it holds now that nobody else writes to it
        done = Trajectory.open(path)
        begin = done.latest_checkpoint()
        if begin is None:
            raise TrajectoryError(f"{done.path}: was killed before it began; run its scene again")
        _refuse_unsound(begin, done)
        return _go_on(done, begin, _kept_choice(done, unwatched), progress, claim)


def _kept_choice(done: Trajectory, unwatched: bool) -> Choice | None:
    """The choice with which a run goes on; refused where it broke its bound and is watched."""
    if done.cause is Cause.NEGLECTED and not unwatched:
        raise TrajectoryError(
            f"{done.path}: stopped {done.reason}. As it is, and without a bound, it goes on with"
            " unwatched = True (nrchain resume --unwatched)"
        )
    choice = done.choice
    if unwatched and choice is not None:
        choice = replace(choice, watched_until=min(choice.watched_until, float(done.time[-1])))
    return choice


def _go_on(
    done: Trajectory,
    begin: Checkpoint,
    choice: Choice | None,
    progress: Callable[[Progress], None] | None,
    claim: Claim,
) -> Trajectory:
    assert done.path is not None
    with deferred() as interruption, TrajectoryWriter.reopen(done.path, claim, choice) as writer:
        repeated = done.counters["steps"]
        with interruption.second_at_once():
            run = _Run(done.scene, writer, progress, interruption, begin, repeated, choice)
            stop = run.go()
        return _finish(writer, stop)


def _refuse_unsound(begin: Checkpoint, done: Trajectory) -> None:
    """Refuse a checkpoint that no run of this scene has written."""
    times = snapshot_times(done.scene)
    passed, snapshot = begin.time, begin.snapshot
    where = f"{done.path}: damaged: its last checkpoint"
    if not (0 < snapshot < len(times) and times[snapshot - 1] <= passed <= times[snapshot]):
        raise TrajectoryError(f"{where} is at t = {passed:g}, before snapshot {snapshot}")
    try:
        rotations(begin.frames, done.scene.chain.particles, to=ORTHONORMAL)
        refuse_far("positions", begin.positions)
    except SceneError as error:
        raise TrajectoryError(f"{where} cannot be used: {error}") from error


def _finish(writer: TrajectoryWriter, stop: Stop | None) -> Trajectory:
    """Mark how the run ended, and read what it leaves: also from a file that has lost its name."""
    if stop is None:
        writer.mark("completed")
    else:
        writer.mark("stopped", stop.reason, stop.cause)
    return writer.read()
