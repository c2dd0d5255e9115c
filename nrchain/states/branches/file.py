"""The states of one branch in one file, with their poses."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from nrchain.states.branches.branch import COLUMNS, SpecialPoint, StateBranch
from nrchain.states.branches.curve import Direction
from nrchain.states.line_files import branch_file, new_branch_file

FORMAT = "nrchain branch 1"

NUMBERS = "value", "error", "frequency", "multiplicity", "index"
"""Of a special point."""


def write_branch(path: Path, branch: StateBranch, request: dict[str, Any]) -> None:
    """Write a branch and what was asked for; an older file is replaced."""
    with new_branch_file(path, FORMAT, branch.line) as file:
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


def read_branch(path: Path) -> tuple[StateBranch, dict[str, Any]]:
    """A branch, and what was asked for.

    Raises :class:`~nrchain.errors.TrajectoryError` for a file that is damaged or of another kind.
    """
    with branch_file(path, FORMAT) as (file, line):
        parent = json.loads(file.attrs["parent"])
        branch = StateBranch(
            line=line,
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
