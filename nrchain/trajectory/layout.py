"""The layout of a trajectory file: HDF5 laid out as H5MD, with room for a whole run.

    /h5md                          version (1, 1), author, creator
    /particles/trajectory/box      periodic along x, with edges (T, 3), or none
    /particles/trajectory/position value (T, N, 3), time (T,), step (T,)
    /particles/trajectory/frame    value (T, N, 3, 3), the same time and step by hard links
    /parameters                    scene (its TOML text), effects that act, versions (of what ran
                                   it), choice (JSON: what effects chosen for a tolerance leave
                                   out), and start, where the scene is given poses: position
                                   (N, 3), frame (N, 3, 3)
    /nrchain                       layout, units, the name of the file, times asked for, how many
                                   are finished, counters, status, cause, reason, two checkpoints

T counts the snapshots that are finished. The bytes of all those asked for are taken when the file
is made: HDF5 finds the chunks of a data set of fixed largest size, without filters, allocated at
once, by their number alone, and there is no index that would change as T grows. A snapshot is then
bytes written into their place, and the sizes T of the series set to include them.

The superblock is of version 2. Later ones have a mark that the file is being written, with which
HDF5 refuses to read it, and which a killed run leaves behind.

H5MD 1.1: P. de Buyl, P. H. Colberg, F. Höfling, Comput. Phys. Commun. 185, 1546 (2014).
"""

from __future__ import annotations

import math
import os
import platform
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from nrchain.outcome import Cause
from nrchain.scene.scene import Scene
from nrchain.scene.toml import write_toml
from nrchain.version import __version__

GROUP = "particles/trajectory"
POSITION = f"{GROUP}/position"
FRAME = f"{GROUP}/frame"
EDGES = f"{GROUP}/box/edges"
SCENE = "parameters/scene"
STARTS = {"positions": "parameters/start/position", "frames": "parameters/start/frame"}
"""The keys of ``[start]`` that are kept as arrays."""

CHOICE = "parameters/choice"
EFFECTS = "parameters/effects"
VERSIONS = "parameters/versions"
CHOICE_ROOM = 64
"""Bytes by which a choice may grow when a run goes on: the time to which it is watched."""

OURS = "nrchain"
LAYOUT = 2
"""Which layout this is; the attribute ``layout`` of the group ``nrchain`` says it."""

NAME = "nrchain/name"
PLANNED = "nrchain/times"
FINISHED = "nrchain/finished"
COUNTS = "nrchain/counters"
STATUS = "nrchain/status"
CAUSE = "nrchain/cause"
REASON = "nrchain/reason"
CHECKPOINTS = "nrchain/checkpoints"

TIMES = ("wall_time", "processor_time")
COUNTERS = ("steps", "evaluations", "jacobians", "solves", "restarts", *TIMES)
"""What a run counts: whole numbers, and the seconds of :data:`TIMES`, see :mod:`nrchain.work`."""

STATUSES = ("running", "completed", "stopped")
"""How a run can stand, by its code in the file; a killed run is left as running."""

CAUSES = (None, *Cause)
"""Why a run stopped, by its code in the file; the first stands for one that has not."""

REASON_BYTES = 1024
CHECKPOINT_STATE = 6
"""Numbers of a checkpoint besides its poses: time, snapshot, spin, drift; the counters follow."""

CHUNK_BYTES = 2**16
"""About what is read and written of a time series at once."""

BLOCK_BYTES = 2**20
"""Bytes of a new file that are written at once."""

LENGTH, TIME = "Angstrom", "ps"
"""What stands for the scene's units of length and time. Programs that know no reduced units, such
as MDAnalysis, refuse a file with none or with others than theirs, and take these as they are."""

_RECORDED = ("numpy", "scipy", "numba", "scikit-sundae", "pystokes", "h5py")


def series(file: Any) -> list[str]:
    """The names of the data sets with one row a snapshot."""
    names = [f"{POSITION}/value", f"{FRAME}/value", f"{POSITION}/step", f"{POSITION}/time"]
    return [*names, f"{EDGES}/value"] if EDGES in file else names


def fill(path: Path, scene: Scene, times: np.ndarray, choice: str, name: Path) -> None:
    """Make the file of a run with snapshots at ``times (T,)``, none of them reached.

    ``name`` is what the file is going to be called.
    """
    import h5py

    # the version of the superblock is that of the first opening, that of the rest of the second
    h5py.File(path, "w", libver=("v108", "v110"), locking=False).close()
    with h5py.File(path, "r+", libver=("v110", "v110"), locking=False) as file:
        _describe(file, scene, choice, name)
        _allocate(file, scene, times)
    _occupy(path)


def _occupy(path: Path) -> None:
    """Have the disk give the bytes of a file, which HDF5 leaves as a hole where it writes none.

    A full disk is an error here, and HDF5 may not survive one when it closes a file.
    """
    with path.open("r+b") as file:
        while block := file.read(BLOCK_BYTES):
            file.seek(-len(block), os.SEEK_CUR)
            file.write(block)


def _describe(file: Any, scene: Scene, choice: str, name: Path) -> None:
    root = file.create_group("h5md")
    root.attrs["version"] = np.array([1, 1], dtype=np.int32)
    root.create_group("author").attrs["name"] = "not given"
    creator = root.create_group("creator")
    creator.attrs["name"] = "nrchain"
    creator.attrs["version"] = __version__

    file.create_group(OURS).attrs["layout"] = LAYOUT
    file[OURS].attrs[f"unit {LENGTH}"] = (
        f"stands for the scene's unit of length: the radius of a sphere is {scene.chain.radius!r}"
    )
    file[OURS].attrs[f"unit {TIME}"] = (
        "stands for the scene's unit of time: with its units of length and force, that in which "
        f"the viscosity is {scene.chain.viscosity!r}"
    )
    _write_text(file, NAME, str(name))
    _write_scene(file, scene)
    if choice:
        _write_text(file, CHOICE, choice, room=CHOICE_ROOM)
    _write_effects(file, scene)
    versions = file.create_group(VERSIONS)
    versions.attrs["nrchain"] = __version__
    versions.attrs["python"] = platform.python_version()
    for package in _RECORDED:
        versions.attrs[package] = _version(package)


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"


def _write_scene(file: Any, scene: Scene) -> None:
    """The scene as text, but for the poses that it is given: as text they take long to read."""
    table = scene.to_mapping()
    for name, element in STARTS.items():
        given = table["start"].pop(name, None)
        if given is not None:
            file[element] = given.values
    _write_text(file, SCENE, write_toml(table))


def _write_effects(file: Any, scene: Scene) -> None:
    import h5py

    from nrchain.effects.registry import acting

    names = [effect.name.encode() for effect in acting(scene)]
    # texts of any length lie in a heap without checksums, and HDF5 may never end in a damaged one
    fixed = h5py.string_dtype(length=max(map(len, names), default=1))
    file.create_dataset(EFFECTS, data=names, dtype=fixed, shape=(len(names),))


def _write_text(file: Any, name: str, text: str, room: int = 0) -> None:
    """A text of fixed length, with room to be replaced by one of that many bytes more."""
    import h5py

    encoded = text.encode(errors="replace")
    file.create_dataset(name, data=encoded, dtype=h5py.string_dtype(length=len(encoded) + room))


def replace_text(file: Any, name: str, text: str) -> None:
    """Replace a text by one for which there is room."""
    import h5py

    encoded, length = text.encode(), h5py.check_string_dtype(file[name].dtype).length
    if length is not None and len(encoded) > length:
        raise ValueError(f"{name} holds {length} bytes, and {len(encoded)} are to be written")
    file[name][()] = encoded


def _allocate(file: Any, scene: Scene, times: np.ndarray) -> None:
    snapshots, particles = len(times), scene.chain.particles
    _series(file, f"{POSITION}/value", (snapshots, particles, 3), unit=LENGTH)
    _series(file, f"{POSITION}/time", (snapshots,), unit=TIME)
    _series(file, f"{POSITION}/step", (snapshots,), np.int64)
    _series(file, f"{FRAME}/value", (snapshots, particles, 3, 3))
    _allocate_box(file, scene, snapshots)
    for element in [FRAME, EDGES][: 1 + (EDGES in file)]:
        for name in ("time", "step"):
            file[f"{element}/{name}"] = file[f"{POSITION}/{name}"]

    file.create_dataset(PLANNED, data=times)
    _empty(file, FINISHED, (1,), np.int64, 0)
    _empty(file, COUNTS, (len(COUNTERS),), fill=0.0)
    file[COUNTS].attrs["names"] = COUNTERS
    _empty(file, STATUS, (1,), np.uint8, STATUSES.index("running"))
    file[STATUS].attrs["names"] = STATUSES
    _empty(file, CAUSE, (1,), np.uint8, 0)
    file[CAUSE].attrs["names"] = [str(cause or "none") for cause in CAUSES]
    _empty(file, REASON, (1,), np.dtype(f"S{REASON_BYTES}"), b"")

    _empty(file, f"{CHECKPOINTS}/sequence", (2,), np.int64, 0)
    _empty(file, f"{CHECKPOINTS}/position", (2, particles, 3))
    _empty(file, f"{CHECKPOINTS}/frame", (2, particles, 3, 3))
    _empty(file, f"{CHECKPOINTS}/state", (2, CHECKPOINT_STATE + len(COUNTERS)))


def _allocate_box(file: Any, scene: Scene, snapshots: int) -> None:
    box = file.create_group(f"{GROUP}/box")
    box.attrs["dimension"] = 3
    periodic = scene.chain.ends == "periodic"
    box.attrs["boundary"] = ["periodic" if periodic else "none", "none", "none"]
    if periodic:
        # the box does not change, but programs look for its edges in every snapshot
        _series(file, f"{EDGES}/value", (snapshots, 3), unit=LENGTH)


def _series(
    file: Any,
    name: str,
    shape: tuple[int, ...],
    dtype: Any = np.float64,
    unit: str = "",
) -> None:
    """A data set with room for ``shape[0]`` snapshots, and none in it.

    Nothing is filled in, here and when it grows: all of it is written. There is more than one
    chunk: the space of a single one HDF5 would give back.
    """
    row = np.dtype(dtype).itemsize * math.prod(shape[1:])
    rows = max(1, min(CHUNK_BYTES // row, (shape[0] + 1) // 2))
    chunks = (rows, *shape[1:])
    made = _taken(file, name, shape, dtype, fill_time="never", maxshape=shape, chunks=chunks)
    made.resize(0, axis=0)
    if unit:
        made.attrs["unit"] = unit


def _empty(
    file: Any, name: str, shape: tuple[int, ...], dtype: Any = np.float64, fill: Any = np.nan
) -> None:
    """A contiguous data set, filled.

    Not a scalar: h5py makes those without regard to the layout asked for.
    """
    _taken(file, name, shape, dtype, fillvalue=fill, fill_time="alloc")


def _taken(file: Any, name: str, shape: tuple[int, ...], dtype: Any, **how: Any) -> Any:
    """A data set whose space in the file is taken at once."""
    import h5py

    layout = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    layout.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    return file.create_dataset(name, shape, dtype=dtype, dcpl=layout, **how)
