"""The file of a new run, with room for all its snapshots.

The bytes of all snapshots asked for are taken when the file is made: HDF5 finds the chunks of a
data set of fixed largest size, without filters, allocated at once, by their number alone, and no
index changes as the series grow. A snapshot is then bytes written into their place, after which the
sizes of the series are set to include it.

The superblock is of version 2. Later ones mark a file that is being written. HDF5 refuses to read a
file with that mark, and a killed run leaves it behind.
"""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

import numpy as np

from nrchain.scene.scene import Scene
from nrchain.scene.toml import write_toml
from nrchain.trajectory.layout import (
    CAUSE,
    CAUSES,
    CHECKPOINT_STATE,
    CHECKPOINTS,
    CHOICE,
    CHOICE_ROOM,
    COUNTERS,
    COUNTS,
    EDGES,
    EFFECTS,
    ERRORS,
    FINISHED,
    FRAME,
    GROUP,
    LAYOUT,
    LENGTH,
    NAME,
    OURS,
    PLANNED,
    POSITION,
    PROVENANCE,
    REASON,
    REASON_BYTES,
    SCENE,
    STARTS,
    STATUS,
    STATUSES,
    TIME,
    VERSIONS,
)
from nrchain.version import __version__, versions

CHUNK_BYTES = 2**16
"""About the size of a chunk of a time series."""

BLOCK_BYTES = 2**20
"""Bytes of a new file that are written at once."""


def write_new_file(
    path: Path, scene: Scene, times: np.ndarray, choice: str, name: Path, provenance: str = ""
) -> None:
    """Write the file of a run with snapshots at ``times (T,)``, none of them finished.

    ``name`` is the final name of the file; ``choice`` and ``provenance`` are JSON, or empty.
    """
    import h5py

    # the first opening sets the version of the superblock, the second that of all else
    h5py.File(path, "w", libver=("v108", "v110"), locking=False).close()
    with h5py.File(path, "r+", libver=("v110", "v110"), locking=False) as file:
        _write_parameters(file, scene, choice, name, provenance)
        _allocate(file, scene, times)
    _occupy(path)


def _occupy(path: Path) -> None:
    """Write all bytes of a file once, so that the disk allocates the holes that HDF5 leaves.

    A full disk is then an error here. HDF5 may crash on one when it closes a file.
    """
    with path.open("r+b") as file:
        while block := file.read(BLOCK_BYTES):
            file.seek(-len(block), os.SEEK_CUR)
            file.write(block)


def _write_parameters(file: Any, scene: Scene, choice: str, name: Path, provenance: str) -> None:
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
    if provenance:
        _write_text(file, PROVENANCE, provenance)
    _write_effects(file, scene)
    file.create_group(VERSIONS).attrs.update(versions())


def _write_scene(file: Any, scene: Scene) -> None:
    """The scene as text; given poses as arrays, because text takes long to read."""
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
    # HDF5 keeps texts of any length in a heap without checksums, and may hang if it is damaged
    fixed = h5py.string_dtype(length=max(map(len, names), default=1))
    file.create_dataset(EFFECTS, data=names, dtype=fixed, shape=(len(names),))


def _write_text(file: Any, name: str, text: str, room: int = 0) -> None:
    """A text of fixed length, with room for a replacement that is ``room`` bytes longer."""
    import h5py

    encoded = text.encode(errors="replace")
    file.create_dataset(name, data=encoded, dtype=h5py.string_dtype(length=len(encoded) + room))


def _allocate(file: Any, scene: Scene, times: np.ndarray) -> None:
    snapshots, particles = len(times), scene.chain.particles
    _new_series(file, f"{POSITION}/value", (snapshots, particles, 3), unit=LENGTH)
    _new_series(file, f"{POSITION}/time", (snapshots,), unit=TIME)
    _new_series(file, f"{POSITION}/step", (snapshots,), np.int64)
    _new_series(file, f"{FRAME}/value", (snapshots, particles, 3, 3))
    _allocate_box(file, scene, snapshots)
    if scene.run.verify:
        for element, unit in zip(ERRORS.values(), (LENGTH, ""), strict=True):
            _new_series(file, f"{element}/value", (snapshots,), unit=unit)
    for element in (FRAME, EDGES, *ERRORS.values()):
        for name in ("time", "step") if element in file else ():
            file[f"{element}/{name}"] = file[f"{POSITION}/{name}"]

    file.create_dataset(PLANNED, data=times)
    _filled(file, FINISHED, (1,), np.int64, 0)
    _filled(file, COUNTS, (len(COUNTERS),), fill=0.0)
    file[COUNTS].attrs["names"] = COUNTERS
    _filled(file, STATUS, (1,), np.uint8, STATUSES.index("running"))
    file[STATUS].attrs["names"] = STATUSES
    _filled(file, CAUSE, (1,), np.uint8, 0)
    file[CAUSE].attrs["names"] = [str(cause or "none") for cause in CAUSES]
    _filled(file, REASON, (1,), np.dtype(f"S{REASON_BYTES}"), b"")

    _filled(file, f"{CHECKPOINTS}/sequence", (2,), np.int64, 0)
    _filled(file, f"{CHECKPOINTS}/position", (2, particles, 3))
    _filled(file, f"{CHECKPOINTS}/frame", (2, particles, 3, 3))
    _filled(file, f"{CHECKPOINTS}/state", (2, CHECKPOINT_STATE + len(COUNTERS)))


def _allocate_box(file: Any, scene: Scene, snapshots: int) -> None:
    box = file.create_group(f"{GROUP}/box")
    box.attrs["dimension"] = 3
    periodic = scene.chain.ends == "periodic"
    box.attrs["boundary"] = ["periodic" if periodic else "none", "none", "none"]
    if periodic:
        # the box does not change, but programs read its edges at each snapshot
        _new_series(file, f"{EDGES}/value", (snapshots, 3), unit=LENGTH)


def _new_series(
    file: Any,
    name: str,
    shape: tuple[int, ...],
    dtype: Any = np.float64,
    unit: str = "",
) -> None:
    """A data set with room for ``shape[0]`` snapshots, and none in it.

    HDF5 fills nothing in: all of it will be written. There is more than one chunk: HDF5 would give
    back the space of a single one.
    """
    row = np.dtype(dtype).itemsize * math.prod(shape[1:])
    rows = max(1, min(CHUNK_BYTES // row, (shape[0] + 1) // 2))
    chunks = (rows, *shape[1:])
    dataset = _allocated(file, name, shape, dtype, fill_time="never", maxshape=shape, chunks=chunks)
    dataset.resize(0, axis=0)
    if unit:
        dataset.attrs["unit"] = unit


def _filled(
    file: Any, name: str, shape: tuple[int, ...], dtype: Any = np.float64, fill: Any = np.nan
) -> None:
    """A contiguous data set, filled. Not a scalar: h5py ignores the layout of those."""
    _allocated(file, name, shape, dtype, fillvalue=fill, fill_time="alloc")


def _allocated(file: Any, name: str, shape: tuple[int, ...], dtype: Any, **how: Any) -> Any:
    """A data set whose space in the file is allocated at once."""
    import h5py

    layout = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    layout.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    return file.create_dataset(name, shape, dtype=dtype, dcpl=layout, **how)
