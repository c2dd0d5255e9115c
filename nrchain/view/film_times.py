"""Which snapshots of a run a film shows: equally spaced in time, or in its logarithm.

A film shows snapshots and interpolates nothing. No snapshot is shown twice.
"""

from __future__ import annotations

import numpy as np

from nrchain.errors import SceneError
from nrchain.inputs.rules import choice, whole
from nrchain.trajectory.trajectory import Trajectory
from nrchain.view.shown import Spacing

MOST_FRAMES = 250
"""Number of frames of a film if none is asked for and the run has more snapshots."""


def pick_frames(time: np.ndarray, count: int | None, spacing: Spacing) -> np.ndarray:
    """Indices (F,) of the snapshots nearest to F times from the first to the last, all different.

    ``"logarithmic"`` times have even ratios of the time since the first, which is shown too. Where
    the run has fewer snapshots than that asks for, each of them is one frame.

    Raises :class:`~nrchain.errors.SceneError` for more frames than snapshots.

    >>> pick_frames(np.arange(9.0), 3, "linear"), pick_frames(np.arange(9.0), 5, "logarithmic")
    (array([0, 4, 8]), array([0, 1, 2, 4, 8]))
    """
    choice(Spacing)("spacing", spacing)
    given = len(time)
    frames = min(given, MOST_FRAMES) if count is None else whole(least=1)("times", count)
    if frames > given:
        allowed = (
            f"there are {given} snapshots, and each frame is one; ask for at most {given}, or run"
            " the scene again with a larger run.snapshots"
        )
        raise SceneError("times", count, allowed)
    if frames == 1:
        return np.array([given - 1])
    since = np.asarray(time) - time[0]
    wanted = np.linspace(0.0, since[-1], frames)
    if spacing == "logarithmic" and frames > 2:
        wanted[1:] = np.geomspace(since[1], since[-1], frames - 1)
    nearest = np.abs(since[None, :] - wanted[:, None]).argmin(axis=1)
    # strictly increasing: forward from the first, and not beyond what leaves one for each later one
    steps = np.arange(frames)
    nearest = np.maximum.accumulate(nearest - steps) + steps
    return np.minimum(nearest, given - frames + steps)


def chosen_snapshots(trajectory: Trajectory, indices: np.ndarray) -> Trajectory:
    """The trajectory of the snapshots at ``indices`` (F,)."""
    return Trajectory(
        trajectory.time[indices],
        trajectory.positions[indices],
        trajectory.frames[indices],
        trajectory.scene,
    )
