"""A frame of a run, of an exported file, or in memory: the start of another run."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias, Union

import numpy as np

from nrchain.errors import NrchainError, SceneError, TrajectoryError
from nrchain.exchange.record import FramePoses, pick_frame
from nrchain.inputs.arguments import finite_array
from nrchain.planning.checked_start import starting_poses, with_start
from nrchain.scene.loading import require_scene
from nrchain.scene.scene import Scene
from nrchain.trajectory.provenance import (
    FROM_SCENE,
    Provenance,
    Step,
    array_step,
    pose_hash,
    scene_hash,
    source_name,
)
from nrchain.trajectory.trajectory import Snapshot, Trajectory

StartLike: TypeAlias = Union[
    "StartingFrame", Trajectory, Snapshot, tuple[np.ndarray, np.ndarray], str, os.PathLike[str]
]
"""What a run can start from; a path may end in ``:frame``."""

Reader: TypeAlias = Callable[[Path, int], FramePoses]
"""What reads one frame of a file."""

LAST = -1
"""The frame that is taken where none is given."""

_NUMBERED = re.compile(r"(.+):(-?\d+)")

_ACCEPTED = (
    "must be a snapshot, a trajectory, (positions, frames), or the path of a run or of a file that "
    "nrchain export writes, with :frame if it is not the last"
)


@dataclass(frozen=True, eq=False)
class StartingFrame:
    """Positions (N, 3) and frames (N, 3, 3) to start from, with the steps that led to them.

    ``name`` says in messages where they come from.
    """

    positions: np.ndarray
    frames: np.ndarray
    provenance: Provenance
    name: str

    def refusal(self, error: SceneError) -> SceneError:
        """The error of a start at these poses, which names their source."""
        if not error.key.startswith(("positions", "frames")):
            return error
        return SceneError(f"start from {self.name}: {error.key}", error.value, error.allowed)


def starting_frame(given: StartLike, scene: Scene) -> StartingFrame:
    """The frame that is given for the start of a run of ``scene``.

    Raises :class:`~nrchain.errors.SceneError` if it has not as many spheres as the scene, or for
    something that is no start, and :class:`~nrchain.errors.TrajectoryError` for a file that cannot
    be read and for a frame that is not there.
    """
    found = _find(given)
    spheres, wanted = len(found.positions), require_scene(scene).chain.particles
    if spheres != wanted:
        allowed = f"has {spheres} spheres, and chain.particles is {wanted}"
        raise SceneError("start", found.name, allowed)
    return found


def scene_at(source: StartingFrame, scene: Scene) -> Scene:
    """The scene with the poses of a source as its start, checked as those of any start."""
    found = starting_frame(source, scene)
    try:
        return with_start(scene, *starting_poses(scene, found.positions, found.frames))
    except SceneError as error:
        raise found.refusal(error) from error


def _find(given: Any) -> StartingFrame:
    if isinstance(given, StartingFrame):
        return given
    if isinstance(given, Snapshot):
        return _from_snapshot(given)
    if isinstance(given, Trajectory):
        return _from_trajectory(given, LAST)
    if isinstance(given, (str, os.PathLike)):
        return read_start(given)
    if isinstance(given, (tuple, list)) and len(given) == 2:
        positions = finite_array("start: positions", given[0], (None, 3))
        frames = finite_array("start: frames", given[1], (len(positions), 3, 3))
        provenance = FROM_SCENE.then(array_step(positions, frames))
        return StartingFrame(positions, frames, provenance, "arrays")
    raise SceneError("start", given, _ACCEPTED)


def read_start(place: str | os.PathLike[str]) -> StartingFrame:
    """The frame at ``PATH`` or ``PATH:frame``: the folder or file of a run, or an exported file.

    Frames count from 0, and from the end if they are negative. Without a number it is the last.
    """
    from nrchain.exchange.formats import FORMATS

    path, index = split_frame(place)
    if path.suffix.lower() not in FORMATS:
        return _from_trajectory(Trajectory.open(path), index)
    return _from_exported(path, index, FORMATS[path.suffix.lower()].read)


def split_frame(place: str | os.PathLike[str]) -> tuple[Path, int]:
    """The path and the frame of ``PATH:frame``; a file of that very name is a path alone.

    >>> split_frame("runs/mine:-2")
    (PosixPath('runs/mine'), -2)
    """
    text = os.fspath(place)
    numbered = _NUMBERED.fullmatch(text)
    if numbered is None or os.path.exists(text):
        _refuse_other_frames(text)
        return Path(text), LAST
    return Path(numbered[1]), int(numbered[2])


def _refuse_other_frames(text: str) -> None:
    """Refuse ``PATH:frame`` where the path is there and the frame is no whole number."""
    path, colon, frame = text.rpartition(":")
    if colon and not os.path.exists(text) and os.path.exists(path):
        raise TrajectoryError(f"{path}: there is no frame {frame!r}; frames are whole numbers")


def _from_trajectory(trajectory: Trajectory, index: int) -> StartingFrame:
    name = trajectory.path or Path("trajectory")
    return _from_snapshot(trajectory[pick_frame(name, index, len(trajectory))])


def _from_snapshot(snapshot: Snapshot) -> StartingFrame:
    poses = snapshot.positions, snapshot.frames
    step = Step(
        "started",
        source_name(snapshot.path),
        "run",
        snapshot.index,
        snapshot.time,
        scene_hash(snapshot.scene),
        pose_hash(*poses),
    )
    name = f"{snapshot.path or 'the snapshot'}:{snapshot.index}"
    return StartingFrame(*poses, snapshot.provenance.then(step), name)


def _from_exported(path: Path, index: int, read: Reader) -> StartingFrame:
    if not path.exists():
        raise TrajectoryError(f"{path}: there is no such file")
    ending = path.suffix.lower()
    try:
        found = read(path, index)
    except NrchainError:
        raise
    except Exception as error:
        # each library has errors of its own for a file that is damaged or of another kind
        raise TrajectoryError(f"{path}: cannot be read as {ending[1:]}: {error}") from error
    step = Step(
        "started",
        source_name(path),
        ending[1:],
        found.index,
        found.time,
        found.record.scene_hash,
        pose_hash(found.positions, found.frames),
        found.precision,
    )
    provenance = found.record.provenance.then(step)
    return StartingFrame(found.positions, found.frames, provenance, f"{path}:{found.index}")
