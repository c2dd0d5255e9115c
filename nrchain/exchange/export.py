"""Trajectories as files of other programs."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from nrchain.errors import SceneError, TrajectoryError
from nrchain.exchange.formats import writer_of
from nrchain.exchange.record import Record
from nrchain.exchange.vtk_files import frames_folder
from nrchain.trajectory.file import file_errors
from nrchain.trajectory.trajectory import Trajectory


def export(trajectory: Trajectory, path: str | Path, *, overwrite: bool = False) -> Path:
    """Write a trajectory as a file of another program, in the format of the path's ending.

    =========  =====================================================================
    ``.gsd``   HOOMD's schema, for OVITO and HOOMD: 32-bit numbers; quaternions with
               the scalar first; a periodic chain is wrapped into its box
    ``.xyz``   extended XYZ, for OVITO and ASE: quaternions with the scalar last
    ``.pvd``   VTK, for ParaView: a ``.vtp`` for each frame, in a folder beside it
    ``.npz``   NumPy
    ``.nc``    netCDF, the dataset of :meth:`nrchain.Trajectory.to_xarray`
    =========  =====================================================================

    All but GSD keep 64-bit numbers. Each file holds the keys of the scene and the provenance of
    the run. GSD and netCDF need the extra ``exchange``.

    Parameters
    ----------
    trajectory
        The whole, or a slice such as ``trajectory[::10]``.
    path
        The file to write.
    overwrite
        Whether an existing file may be replaced.

    Returns the path.

    Raises
    ------
    SceneError
        For another ending, and for a trajectory without snapshots.
    TrajectoryError
        For a file that exists, or cannot be written.
    MissingLibraryError
        Without the library of the format.

    >>> trajectory = nrchain.simulate(nrchain.load_scene("passive", **{"run.end": 1.0}))
    >>> str(nrchain.export(trajectory, "passive.npz", overwrite=True))
    'passive.npz'
    """
    path = Path(path)
    write = writer_of(path)
    refuse_taken(path, overwrite)
    if not len(trajectory):
        raise SceneError("trajectory", trajectory, "must have at least one snapshot")
    partial = path.with_name(path.name + ".partial")
    with file_errors(path, "cannot be written"):
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            write(trajectory, Record.of(trajectory), partial)
            partial.replace(path)
        except BaseException:
            with suppress(OSError):
                partial.unlink(missing_ok=True)
            raise
    return path


def refuse_taken(path: Path, overwrite: bool) -> None:
    """Raise :class:`TrajectoryError` for a file that exists, unless it may be replaced."""
    taken = [path, frames_folder(path)] if path.suffix.lower() == ".pvd" else [path]
    with file_errors(path, "cannot be written"):
        for one in taken:
            if one.exists() and not overwrite:
                raise TrajectoryError(
                    f"{one}: exists; it is replaced only with overwrite=True (--overwrite)"
                )
