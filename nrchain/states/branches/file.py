"""One branch in one HDF5 file: every state with its poses, replaced as a whole while it grows.

The file is written beside its place and moved there, so that a program that is killed leaves the
file of a moment ago.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from nrchain.scene.scene import Scene
from nrchain.scene.toml import read_toml, write_toml
from nrchain.states.branches.branch import COLUMNS, SpecialPoint, StateBranch
from nrchain.states.branches.curve import Direction
from nrchain.states.varied import Line
from nrchain.trajectory.checked_datasets import damage_errors
from nrchain.trajectory.file import file_errors
from nrchain.version import __version__

FORMAT = "nrchain branch 1"

NUMBERS = "value", "error", "frequency", "multiplicity", "index"
"""Of a special point."""


def write_branch(path: Path, branch: StateBranch, request: dict[str, Any]) -> None:
    """Write a branch and what was asked for; an older file is replaced."""
    import h5py

    partial = path.with_name(path.name + ".partial")
    with file_errors(path, "cannot be written"):
        with h5py.File(partial, "w") as file:
            file.attrs["format"] = FORMAT
            file.attrs["nrchain"] = __version__
            file.attrs["scene"] = write_toml(branch.line.scene.to_mapping())
            file.attrs["ranges"] = json.dumps(branch.line.ranges)
            file.attrs["request"] = json.dumps(request)
            file.attrs["reason"] = branch.reason
            file.attrs["parent"] = json.dumps(branch.parent)
            for name in COLUMNS:
                file[name] = getattr(branch, name)
            file["leaves/change"] = branch.leaves.change
            file["leaves/value"] = branch.leaves.value
            for k, special in enumerate(branch.special):
                group = file.create_group(f"special/{k:03}")
                group.attrs["kind"] = special.kind
                group.attrs.update({name: getattr(special, name) for name in NUMBERS})
                group["positions"], group["frames"] = special.poses
        os.replace(partial, path)


def read_branch(path: Path) -> tuple[StateBranch, dict[str, Any]]:
    """A branch, and what was asked for.

    Raises :class:`~nrchain.errors.TrajectoryError` for a file that is damaged or of another kind.
    """
    import h5py

    with file_errors(path, "cannot be opened"):
        opened = h5py.File(path, "r")
    with opened as file, damage_errors(path):
        if file.attrs.get("format") != FORMAT:
            raise ValueError(f"its format is not {FORMAT!r}")
        ranges = {key: tuple(ends) for key, ends in json.loads(file.attrs["ranges"]).items()}
        scene = Scene.from_mapping(read_toml(file.attrs["scene"]))
        parent = json.loads(file.attrs["parent"])
        branch = StateBranch(
            line=Line(scene, ranges),
            **{name: np.asarray(file[name]) for name in COLUMNS},
            special=tuple(_special(group) for _, group in sorted(file.get("special", {}).items())),
            reason=str(file.attrs["reason"]),
            parent=None if parent is None else (int(parent[0]), int(parent[1])),
            leaves=Direction(np.asarray(file["leaves/change"]), float(file["leaves/value"][()])),
        )
        return branch, json.loads(file.attrs["request"])


def _special(group: Any) -> SpecialPoint:
    numbers = {name: group.attrs[name].item() for name in NUMBERS}
    return SpecialPoint(
        kind=str(group.attrs["kind"]),
        **numbers,
        positions=np.asarray(group["positions"]),
        frames=np.asarray(group["frames"]),
    )
