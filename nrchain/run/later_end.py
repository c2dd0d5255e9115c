"""A run with a later end: the scene it then has, and its file made anew for it."""

from __future__ import annotations

from dataclasses import replace

from nrchain.errors import SceneError, TrajectoryError
from nrchain.inputs.rules import number
from nrchain.planning.checked_start import starting_poses
from nrchain.planning.choice import Choice, as_keys
from nrchain.run.recording import snapshot_times
from nrchain.scene.scene import Scene
from nrchain.trajectory.extension import extend_file
from nrchain.trajectory.provenance import Step, pose_hash, scene_hash, source_name
from nrchain.trajectory.trajectory import Trajectory

WHOLE = 1e-9
"""Largest distance of a later end from a whole number of intervals between snapshots, relative."""


def extend(done: Trajectory, until: float, unwatched: bool = False) -> Trajectory:
    """The run of ``done``, not finished yet, with the end ``until``; its file is made anew.

    Raises :class:`~nrchain.errors.SceneError` for an end that is not later or no whole number of
    intervals, and where the scene would be refused with that end, and
    :class:`~nrchain.errors.TrajectoryError` for a run that has settled. So it does for chosen
    effects that do not suffice up to that end, unless the run is to go on ``unwatched``.
    """
    assert done.path is not None
    if done.status == "completed" and done.reason:
        raise TrajectoryError(
            f"{done.path}: {done.reason}, and a later end changes nothing; start a run with "
            f"run.until = 'end' from its last snapshot (nrchain run SCENE --from {done.path})"
        )
    scene = later_scene(done.scene, until)
    starting_poses(scene)
    choice = done.choice
    if choice is not None and not unwatched:
        choice = _choice(scene, choice)
    run, last = done.scene.run, done[-1]
    step = Step(
        "extended",
        source_name(done.path),
        "run",
        run.snapshots - 1,
        run.end,
        scene_hash(done.scene),
        pose_hash(last.positions, last.frames),
    )
    extend_file(done.path, scene, snapshot_times(scene), choice, done.provenance.then(step))
    return Trajectory.open(done.path)


def later_scene(scene: Scene, until: float) -> Scene:
    """The scene with the end ``until``, and snapshots at the same intervals as before.

    >>> later_scene(nrchain.load_scene("passive", **{"run.end": 10.0}), 25.0).run.snapshots
    251
    """
    run = scene.run
    end = number(above=0)("until", until)
    if end <= run.end:
        raise SceneError("until", until, f"must be later than run.end = {run.end:g}")
    interval = run.end / (run.snapshots - 1)
    count = round(end / interval)
    if abs(count * interval - end) > WHOLE * end:
        below = int(end / interval)
        near = " or ".join(f"{k * interval:.12g}" for k in (below, below + 1) if k >= run.snapshots)
        allowed = f"snapshots are {interval:.12g} apart, and it must be a multiple of that: {near}"
        raise SceneError("until", until, allowed)
    return replace(scene, run=replace(run, end=end, snapshots=count + 1))


def _choice(scene: Scene, choice: Choice) -> Choice:
    """The choice of effects for the later end; refused if it takes other effects."""
    from nrchain.planning.auto import choose_again

    chosen, again = choose_again(scene, choice)
    if keys := as_keys(scene, chosen):
        raise TrajectoryError(
            f"to t = {scene.run.end:g}, effects = 'auto' with tolerance {choice.tolerance:g} takes "
            f"{keys}; run the scene again with that end"
        )
    return replace(again, watched_until=choice.watched_until)
