"""What an exported file says of the run it comes from: its scene and its provenance, as JSON."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np

from nrchain.errors import TrajectoryError
from nrchain.geometry.quaternions import frames_of
from nrchain.scene.toml import write_toml
from nrchain.trajectory.labelled import keys_without_poses
from nrchain.trajectory.provenance import (
    FROM_SCENE,
    Provenance,
    Step,
    pose_hash,
    scene_hash,
    source_name,
)
from nrchain.trajectory.trajectory import Trajectory

UNIT = 1e-3
"""Largest distance of the length of a quaternion from 1: programs write three digits or more."""

_APOSTROPHE = "\\u0027"
"""An apostrophe in a string of JSON."""


@dataclass(frozen=True)
class Record:
    """The scene of an exported trajectory, as TOML without given poses, and its provenance."""

    scene: str = ""
    provenance: Provenance = FROM_SCENE

    @classmethod
    def of(cls, trajectory: Trajectory) -> Self:
        """The record of a trajectory that is to be exported."""
        scene = trajectory.scene
        step = Step(
            "exported",
            source_name(trajectory.path),
            "run",
            trajectory.indices[-1],
            float(trajectory.time[-1]),
            scene_hash(scene),
            pose_hash(trajectory.positions, trajectory.frames),
        )
        return cls(write_toml(keys_without_poses(scene)), trajectory.provenance.then(step))

    def to_json(self) -> str:
        """The record in one line of ASCII."""
        return json.dumps({"scene": self.scene, "steps": self.provenance.to_table()})

    @classmethod
    def from_json(cls, text: str) -> Self:
        """The record of a text. Empty text, of a file of another program, is an empty record."""
        if not text:
            return cls()
        table = json.loads(text)
        return cls(table["scene"], Provenance.from_table(table["steps"]))

    def unquoted(self) -> str:
        """The record in one line of ASCII without quotation marks: apostrophes in their place."""
        return self.to_json().replace("'", _APOSTROPHE).replace('"', "'")

    @classmethod
    def from_unquoted(cls, text: str) -> Self:
        """The record of such a line."""
        return cls.from_json(text.replace("'", '"'))

    @property
    def scene_hash(self) -> str:
        """The hash of the scene that was exported; empty if there is none."""
        return self.provenance.steps[-1].scene if self.provenance else ""


@dataclass(frozen=True, eq=False)
class FramePoses:
    """One frame of an exported file: positions (N, 3), frames (N, 3, 3) and their source.

    ``index`` is its place in the file, ``time`` its time if the file has one.
    """

    positions: np.ndarray
    frames: np.ndarray
    index: int
    time: float | None
    record: Record
    precision: str = "float64"


def turned_frames(path: Path, quaternions: np.ndarray) -> np.ndarray:
    """Frames (N, 3, 3) of quaternions (N, 4), scalar first, rounded to any precision.

    Raises :class:`~nrchain.errors.TrajectoryError` for one that is far from length 1, which is no
    rotation.
    """
    lengths = np.linalg.norm(quaternions, axis=-1)
    off = ~(abs(lengths - 1.0) <= UNIT)
    if off.any():
        sphere = int(np.argmax(off))
        raise TrajectoryError(
            f"{path}: the orientation of sphere {sphere} must be a quaternion of length 1, and has "
            f"length {lengths[sphere]:.6g}"
        )
    return frames_of(quaternions)


def pick_frame(path: Path, index: int, count: int) -> int:
    """The place from 0 of frame ``index`` of ``count``, which may count from the end."""
    if not -count <= index < count:
        have = f"it has frames 0 to {count - 1}, or -1 for the last" if count else "it has none"
        raise TrajectoryError(f"{path}: there is no frame {index}; {have}")
    return index % count
