"""A branch of cycles in one HDF5 file: every cycle with its poses."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from nrchain.scene.scene import Scene
from nrchain.scene.toml import read_toml, write_toml
from nrchain.states.cycles.branch import COLUMNS, CycleBranch, SpecialCycle
from nrchain.states.cycles.orbit import Orbit
from nrchain.states.varied import Line
from nrchain.trajectory.checked_datasets import damage_errors
from nrchain.trajectory.file import file_errors
from nrchain.version import __version__

FORMAT = "nrchain cycles 1"

NUMBERS = "value", "error", "angle", "multiplicity", "index"
"""Of a special cycle."""

ORBIT = "period", "elementary", "widths", "positions", "frames"
"""Of an orbit."""


def write_cycles(path: Path, branch: CycleBranch) -> None:
    """Write a branch; an older file is replaced as a whole."""
    import h5py

    partial = path.with_name(path.name + ".partial")
    with file_errors(path, "cannot be written"):
        with h5py.File(partial, "w") as file:
            file.attrs["format"] = FORMAT
            file.attrs["nrchain"] = __version__
            file.attrs["scene"] = write_toml(branch.line.scene.to_mapping())
            file.attrs["ranges"] = json.dumps(branch.line.ranges)
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
        os.replace(partial, path)


def read_cycles(path: Path) -> CycleBranch:
    """A branch from its file.

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
        first, last = json.loads(file.attrs["reasons"])
        orbits = {name: np.asarray(file[f"orbits/{name}"]) for name in ORBIT}
        rows = [
            {name: column[k] for name, column in orbits.items()}
            for k in range(len(orbits["period"]))
        ]
        return CycleBranch(
            line=Line(scene, ranges),
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
