"""What a resumed run starts from: the last checkpoint of its file, checked."""

from __future__ import annotations

from dataclasses import replace

from nrchain.errors import SceneError, TrajectoryError
from nrchain.inputs.arguments import ORTHONORMAL, rotations
from nrchain.outcome import Cause
from nrchain.planning.checked_start import refuse_far
from nrchain.planning.choice import Choice
from nrchain.run.preparation import Snapshots, Start
from nrchain.run.recording import snapshot_times
from nrchain.trajectory.checkpoint import Checkpoint
from nrchain.trajectory.trajectory import Trajectory


def start_from_checkpoint(done: Trajectory, unwatched: bool = False) -> Start:
    """The start of a run that continues ``done``.

    Raises :class:`~nrchain.errors.TrajectoryError` where there is no checkpoint, where none of this
    scene's runs can have written it, and for a run that stopped because of what its effects leave
    out, unless it is ``unwatched``.
    """
    checkpoint = done.latest_checkpoint()
    if checkpoint is None:
        raise TrajectoryError(
            f"{done.path}: was killed before its first checkpoint; run its scene again"
        )
    _refuse_damaged(checkpoint, done)
    choice = _choice(done, unwatched)
    earlier = None
    if done.scene.run.until == "settled":
        rows = slice(checkpoint.snapshot)
        earlier = Snapshots(done.time[rows], done.positions[rows], done.frames[rows])
    steps = done.counters["steps"]
    return Start(done.scene, checkpoint, choice, repeated_steps=steps, earlier=earlier)


def _choice(done: Trajectory, unwatched: bool) -> Choice | None:
    """The choice of effects for the rest of the run; refused where its bound is broken."""
    if done.cause is Cause.NEGLECTED and not unwatched:
        raise TrajectoryError(
            f"{done.path}: stopped {done.reason}. To continue it with the same effects and without "
            "a bound, set unwatched = True (nrchain resume --unwatched)"
        )
    choice = done.choice
    if unwatched and choice is not None:
        choice = replace(choice, watched_until=min(choice.watched_until, float(done.time[-1])))
    return choice


def _refuse_damaged(checkpoint: Checkpoint, done: Trajectory) -> None:
    """Refuse a checkpoint that no run of this scene can have written."""
    times = snapshot_times(done.scene)
    time, snapshot = checkpoint.time, checkpoint.snapshot
    where = f"{done.path}: damaged: its last checkpoint"
    if not (0 < snapshot < len(times) and times[snapshot - 1] <= time <= times[snapshot]):
        raise TrajectoryError(f"{where} is at t = {time:g}, before snapshot {snapshot}")
    try:
        rotations(checkpoint.frames, done.scene.chain.particles, to=ORTHONORMAL)
        refuse_far("positions", checkpoint.positions)
    except SceneError as error:
        raise TrajectoryError(f"{where} cannot be used: {error}") from error
