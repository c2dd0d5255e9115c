"""The formats of exported files, by the ending of their names."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from nrchain.errors import SceneError
from nrchain.exchange import gsd_files, netcdf_files, numpy_files, vtk_files, xyz_files
from nrchain.exchange.record import FramePoses, Record
from nrchain.inputs.names import did_you_mean
from nrchain.trajectory.trajectory import Trajectory


class Format(NamedTuple):
    """How files of one format are read, and written if they hold a whole trajectory."""

    read: Callable[[Path, int], FramePoses]
    write: Callable[[Trajectory, Record, Path], None] | None


FORMATS = {
    ".gsd": Format(gsd_files.read, gsd_files.write),
    ".xyz": Format(xyz_files.read, xyz_files.write),
    ".pvd": Format(vtk_files.read_collection, vtk_files.write),
    ".vtp": Format(vtk_files.read_frame, None),
    ".npz": Format(numpy_files.read, numpy_files.write),
    ".nc": Format(netcdf_files.read, netcdf_files.write),
}


def writer_of(path: Path) -> Callable[[Trajectory, Record, Path], None]:
    """What writes the format of a path. Raises SceneError for an ending that is none of these."""
    found = FORMATS.get(path.suffix.lower())
    if found is None or found.write is None:
        endings = [ending for ending, one in FORMATS.items() if one.write]
        hint = did_you_mean(path.suffix.lower(), endings)
        raise SceneError("output", str(path), f"must end in {', '.join(endings)}{hint}")
    return found.write
