"""The cycles of one branch in one file, with their poses."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from nrchain.states.cycles.branch import COLUMNS, CycleBranch, SpecialCycle
from nrchain.states.cycles.orbit import Orbit
from nrchain.states.line_files import branch_file, new_branch_file

FORMAT = "nrchain cycles 1"

NUMBERS = "value", "error", "angle", "multiplicity", "index"
"""Of a special cycle."""

ORBIT = "period", "elementary", "widths", "positions", "frames"
"""Of an orbit."""


def write_cycles(path: Path, branch: CycleBranch) -> None:
    """Write a branch; an older file is replaced."""
    with new_branch_file(path, FORMAT, branch.line) as file:
        file.attrs["reasons"] = json.dumps(branch.reasons)
        file["origin"] = branch.origin
        for name in COLUMNS:
            file[name] = getattr(branch, name)
        for name in ORBIT:
            file[f"orbits/{name}"] = np.array([getattr(one, name) for one in branch.orbits])
        for k, special in enumerate(branch.special):
            group = file.create_group(f"special/{k:03}")
            group.attrs["kind"] = special.kind
            group.attrs.update({name: getattr(special, name) for name in NUMBERS})
            for name in ORBIT:
                group[name] = getattr(special.orbit, name)


def read_cycles(path: Path) -> CycleBranch:
    """A branch from its file.

    Raises :class:`~nrchain.errors.TrajectoryError` for a file that is damaged or of another kind.
    """
    with branch_file(path, FORMAT) as (file, line):
        first, last = json.loads(file.attrs["reasons"])
        orbits = {name: np.asarray(file[f"orbits/{name}"]) for name in ORBIT}
        rows = [
            {name: column[k] for name, column in orbits.items()}
            for k in range(len(orbits["period"]))
        ]
        return CycleBranch(
            line=line,
            **{name: np.asarray(file[name]) for name in COLUMNS},
            special=tuple(_special(group) for _, group in sorted(file.get("special", {}).items())),
            reasons=(first, last),
            origin=np.asarray(file["origin"]),
            orbits=tuple(_orbit(row) for row in rows),
        )


def _orbit(row: Any) -> Orbit:
    return Orbit(float(row["period"]), *(np.asarray(row[name]) for name in ORBIT[1:]))


def _special(group: Any) -> SpecialCycle:
    numbers = {name: group.attrs[name].item() for name in NUMBERS}
    row = {name: group[name][()] for name in ORBIT}
    return SpecialCycle(kind=str(group.attrs["kind"]), **numbers, orbit=_orbit(row))
