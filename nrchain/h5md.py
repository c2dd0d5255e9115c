"""The trajectory file: HDF5 laid out as H5MD, with every byte in its place before a run starts.

    /h5md                        version (1, 1), author, creator
    /particles/chain/box         periodic along x, or none
    /particles/chain/position    value (T, N, 3), time (T,), step (T,)
    /particles/chain/frame       value (T, N, 3, 3), the same time and step by hard links
    /parameters                  scene (its TOML text), effects that act, versions (of what ran it),
                                 and choice (JSON: what effects chosen for a tolerance leave out)
    /nrchain                     times asked for, counters, status, cause, reason, two checkpoints

All arrays are contiguous and written once, filled with NaN, when the file is made. A run then only
overwrites numbers in place and never touches the structure of the file, so that a process killed
at any moment leaves a file that opens. A time that is NaN marks a snapshot that was not reached.

H5MD 1.1: P. de Buyl, P. H. Colberg, F. Höfling, Comput. Phys. Commun. 185, 1546 (2014).
"""

from __future__ import annotations

import os
import platform
import re
import shutil
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from nrchain import __version__
from nrchain.claim import Claim
from nrchain.errors import SceneError, TrajectoryError
from nrchain.outcome import Cause
from nrchain.scene import Scene
from nrchain.stored import understanding

FILE_NAME = "trajectory.h5"

POSITION = "particles/chain/position"
FRAME = "particles/chain/frame"
SCENE = "parameters/scene"
CHOICE = "parameters/choice"
EFFECTS = "parameters/effects"
VERSIONS = "parameters/versions"
CHOICE_ROOM = 64
"""Bytes by which a choice may grow when a run goes on: the time to which it is watched."""

OURS = "nrchain"
PLANNED = "nrchain/times"
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

CHECKPOINT_POSES = 2
"""Poses of the chain that a file keeps besides its snapshots."""

SNAPSHOT_MARKS = 3 * 8
"""Bytes of a snapshot besides its poses: its time, the time asked for, its step."""

LEAST_SNAPSHOTS = 2
"""A run records its start and its end."""

_RECORDED = ("numpy", "scipy", "numba", "scikit-sundae", "pystokes", "h5py")


def locate(path: str | Path) -> Path:
    """The file that a path means: itself, or ``trajectory.h5`` in a directory."""
    path = Path(path)
    with refusing(path, "cannot be opened"):
        return path / FILE_NAME if path.is_dir() else path


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"


def create(
    path: Path, scene: Scene, times: np.ndarray, choice: str = "", *, overwrite: bool = False
) -> Claim:
    """Make the file of a run of ``scene`` with snapshots at ``times (T,)``, all of them empty.

    The file appears under its name only once it is whole; an older one is replaced in that moment,
    if ``overwrite`` is set. The claim on it is held from before its first byte, so that of several
    runs begun at once one has it, and the others are refused.

    Raises :class:`~nrchain.errors.SceneError` for more snapshots than the disk has room for, and
    :class:`~nrchain.errors.TrajectoryError` for a file that exists or cannot be made.
    """
    refuse_existing(path, overwrite)
    _refuse_more_than_fits(path, scene)
    with refusing(path, "cannot be created"):
        partial = path.with_name(path.name + ".partial")
        claim = _claim_new(path, partial)
        try:
            # whoever had the claim before may just have finished
            refuse_existing(path, overwrite)
            with _claim_old(path):
                _fill(partial, scene, times, choice)
                os.replace(partial, path)
        except BaseException:
            partial.unlink(missing_ok=True)
            claim.release()
            raise
    return claim


def refuse_existing(path: Path, overwrite: bool) -> None:
    """Refuse a place that is taken; a run asks before it spends time on anything else."""
    if path.exists() and not overwrite:
        raise TrajectoryError(
            f"{path}: exists; an existing result is only replaced with overwrite=True (--overwrite)"
        )


def _claim_new(path: Path, partial: Path) -> Claim:
    try:
        return Claim(partial, create=True)
    except TrajectoryError as error:
        raise TrajectoryError(f"{path}: another process is writing to it") from error


def _claim_old(path: Path) -> AbstractContextManager[object]:
    """The claim on a file about to be replaced: it must not be in use, or write-protected."""
    try:
        return Claim(path)
    except FileNotFoundError:
        return nullcontext()
    except PermissionError as error:
        raise TrajectoryError(f"{path}: exists, and is protected from being written to") from error


def _fill(partial: Path, scene: Scene, times: np.ndarray, choice: str) -> None:
    import h5py

    # Newer formats mark a file while it is written, and a killed run would leave it so.
    with h5py.File(partial, "w", libver=("v108", "v110"), locking=False) as file:
        _describe(file, scene, choice)
        _allocate(file, scene, times)


def _refuse_more_than_fits(path: Path, scene: Scene) -> None:
    folder = path.absolute().parent
    with refusing(path, "cannot be created"):
        free = shutil.disk_usage(folder).free
    refuse_snapshots(scene, free - CHECKPOINT_POSES * pose_bytes(scene), f"free in {folder}")


def pose_bytes(scene: Scene) -> int:
    """What the poses of one snapshot take: three coordinates and nine frame components a sphere."""
    return 12 * 8 * scene.chain.particles


def refuse_snapshots(scene: Scene, free: int, where: str) -> None:
    """Raise :class:`~nrchain.errors.SceneError` if the snapshots need more than ``free`` bytes."""
    each, snapshots = pose_bytes(scene) + SNAPSHOT_MARKS, scene.run.snapshots
    if each * snapshots <= free:
        return
    free = max(free, 0)
    fit = free // each
    told = f"{_size(each * snapshots)}, where {_size(free)} are {where}"
    if fit < LEAST_SNAPSHOTS:
        count = scene.chain.particles
        raise SceneError("chain.particles", count, f"not even the first and last poses fit: {told}")
    raise SceneError("run.snapshots", snapshots, f"needs {told}; {fit} would fit")


def _size(count: int) -> str:
    unit, power = ("GiB", 30) if count >= 2**30 else ("MiB", 20) if count >= 2**20 else ("kiB", 10)
    return f"{count / 2**power:.3g} {unit}"


@contextmanager
def refusing(path: Path, what: str) -> Iterator[None]:
    """Turn failures of the file system and of HDF5 into one that names the file."""
    try:
        yield
    except TrajectoryError:
        raise
    except (OSError, RuntimeError, ValueError, LookupError, OverflowError, MemoryError) as error:
        raise TrajectoryError(f"{path}: {what}: {_cause(error)}") from error


def _cause(error: Exception) -> str:
    """The plain cause in an error of HDF5, which tells it in brackets behind what it attempted."""
    if isinstance(error, OSError) and error.errno:
        return os.strerror(error.errno)
    text = str(error)
    if told := re.search(r"errno = (\d+)", text):
        return os.strerror(int(told[1]))
    for known, plain in {
        "file signature not found": "it is not an HDF5 file",
        "truncated file": "it is cut short",
    }.items():
        if known in text:
            return plain
    return text


def _describe(file: Any, scene: Scene, choice: str) -> None:
    root = file.create_group("h5md")
    root.attrs["version"] = np.array([1, 1], dtype=np.int32)
    root.create_group("author").attrs["name"] = "not given"
    creator = root.create_group("creator")
    creator.attrs["name"] = "nrchain"
    creator.attrs["version"] = __version__

    box = file.create_group("particles/chain/box")
    box.attrs["dimension"] = 3
    periodic = scene.chain.ends == "periodic"
    box.attrs["boundary"] = ["periodic" if periodic else "none", "none", "none"]
    if periodic:
        # H5MD asks for an edge in every direction; those across the chain bound nothing.
        box.create_dataset("edges", data=np.full(3, scene.length))

    _write_text(file, SCENE, scene.to_toml())
    if choice:
        _write_text(file, CHOICE, choice, room=CHOICE_ROOM)
    _write_effects(file, scene)
    versions = file.create_group(VERSIONS)
    versions.attrs["nrchain"] = __version__
    versions.attrs["python"] = platform.python_version()
    for package in _RECORDED:
        versions.attrs[package] = _version(package)


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

    encoded = text.encode()
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
    _empty(file, f"{POSITION}/value", (snapshots, particles, 3))
    _empty(file, f"{POSITION}/time", (snapshots,))
    _empty(file, f"{POSITION}/step", (snapshots,), np.int64, -1)
    _empty(file, f"{FRAME}/value", (snapshots, particles, 3, 3))
    for name in ("time", "step"):
        file[f"{FRAME}/{name}"] = file[f"{POSITION}/{name}"]

    file.create_dataset(PLANNED, data=times)
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


def _empty(
    file: Any, name: str, shape: tuple[int, ...], dtype: Any = np.float64, fill: Any = np.nan
) -> None:
    """A contiguous dataset whose space on the disk is taken, and filled, at once.

    Not a scalar: h5py makes those without regard to the layout asked for.
    """
    import h5py

    layout = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    layout.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    file.create_dataset(name, shape, dtype=dtype, fillvalue=fill, fill_time="alloc", dcpl=layout)


def open_file(path: Path, mode: str) -> Any:
    """The open file of a run, to read ``"r"`` or, for who has the claim on it, to write ``"r+"``.

    A file that is being written can be read, since its structure no longer changes. Raises
    :class:`~nrchain.errors.TrajectoryError` for a file that is not HDF5, cut short, or of another
    program.
    """
    import h5py

    refuse_missing(path)
    with refusing(path, "cannot be opened"):
        file = h5py.File(path, mode, locking=False)
    with understanding(path):
        if OURS in file:
            return file
    file.close()
    raise TrajectoryError(f"{path}: an HDF5 file, but not one written by nrchain")


def refuse_missing(path: Path) -> None:
    """Raise for a file that is not there, or is empty: HDF5 would make that one of its own."""
    with refusing(path, "cannot be opened"):
        if not path.exists():
            raise TrajectoryError(f"{path}: there is no such trajectory")
        if path.stat().st_size == 0:
            raise TrajectoryError(f"{path}: it is empty")
