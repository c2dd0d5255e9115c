"""The trajectory file on the disk: made whole or not at all, opened whoever else reads it."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import Any

import numpy as np

from nrchain.errors import TrajectoryError
from nrchain.scene.memory import CHECKPOINT_POSES, pose_bytes, refuse_snapshots
from nrchain.scene.scene import Scene
from nrchain.trajectory import layout as h5md
from nrchain.trajectory.claim import Claim, holder, is_held, lock_of
from nrchain.trajectory.data_file import DataFile
from nrchain.trajectory.stored import text, understanding

FILE_NAME = "trajectory.h5"

_OTHERWISE = "locking flag values don't match"
"""What HDF5 says of a file that the same process has open with other locks."""


def locate(path: str | Path) -> Path:
    """The file that a path means: itself, or ``trajectory.h5`` in a directory."""
    path = Path(path)
    with refusing(path, "cannot be opened"):
        return path / FILE_NAME if path.is_dir() else path


def create(
    path: Path, scene: Scene, times: np.ndarray, choice: str = "", *, overwrite: bool = False
) -> Claim:
    """Make the file of a run of ``scene`` with snapshots at ``times (T,)``, none of them reached.

    The file appears under its name only once it is whole; an older one is replaced in that moment,
    if ``overwrite`` is set. The claim on it is held from before its first byte, so that of several
    runs begun at once one has it, and the others are refused.

    Raises :class:`~nrchain.errors.SceneError` for more snapshots than the disk has room for, and
    :class:`~nrchain.errors.TrajectoryError` for a file that exists or cannot be made.
    """
    refuse_existing(path, overwrite)
    with refusing(path, "cannot be created"):
        target = Path(os.path.realpath(path))
        free = shutil.disk_usage(target.parent).free
    free -= CHECKPOINT_POSES * pose_bytes(scene)
    refuse_snapshots(scene, free, f"free in {target.parent}", len(times))
    with refusing(path, "cannot be created"):
        partial = target.with_name(target.name + ".partial")
        claim = Claim(path)
        try:
            # whoever had the claim before may just have finished
            refuse_existing(path, overwrite)
            with _unwritten(path):
                h5md.fill(partial, scene, times, choice, target)
                os.replace(partial, target)
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


def _unwritten(path: Path) -> AbstractContextManager[object]:
    """A file about to be replaced: nobody may be writing to it, nor may it be write-protected."""
    try:
        return DataFile(path)
    except FileNotFoundError:
        return nullcontext()
    except PermissionError as error:
        raise TrajectoryError(f"{path}: exists, and is protected from being written to") from error


def claim_existing(path: Path) -> Claim:
    """The claim on a file that a run is to go on with.

    Raises :class:`~nrchain.errors.TrajectoryError` for a file that is not there, and for one that
    another run writes to, also under a name that the file had before.
    """
    refuse_missing(path)
    with refusing(path, "cannot be opened"):
        claim = Claim(path)
    try:
        with open_file(path, "r") as file, understanding(path):
            begun = Path(text(file, h5md.NAME))
            if lock_of(begun) != claim.lock and is_held(lock_of(begun)) and _is_not(begun, path):
                by = holder(lock_of(begun))
                raise TrajectoryError(f"{path}: {by} is writing to it, which was called {begun}")
    except BaseException:
        claim.release()
        raise
    return claim


def _is_not(begun: Path, path: Path) -> bool:
    """Whether no other file has the name that this one began with; it is no copy then."""
    return not begun.exists() or os.path.samefile(begun, path)


def open_file(path: Path, mode: str) -> Any:
    """The open file of a run, to read ``"r"`` or, for who has the claim on it, to write ``"r+"``.

    HDF5's own locks are left out: a file that is being written can be read. Raises
    :class:`~nrchain.errors.TrajectoryError` for a file that is not HDF5, cut short, of another
    program, or of another layout.
    """
    refuse_missing(path)
    with refusing(path, "cannot be opened"):
        file = _open(path, mode)
    try:
        with understanding(path):
            _refuse_foreign(path, file)
    except TrajectoryError:
        file.close()
        raise
    return file


def _open(path: Path, mode: str) -> Any:
    import h5py

    try:
        return h5py.File(path, mode, locking=False)
    except OSError as error:
        # a file that this process has open already is opened again in the same way
        if mode != "r" or _OTHERWISE not in str(error):
            raise
        return h5py.File(path, mode)


def _refuse_foreign(path: Path, file: Any) -> None:
    if h5md.OURS not in file:
        raise TrajectoryError(f"{path}: an HDF5 file, but not one written by nrchain")
    layout = int(file[h5md.OURS].attrs.get("layout", 1))
    if layout != h5md.LAYOUT:
        raise TrajectoryError(
            f"{path}: laid out by another nrchain, as number {layout}; this one reads number "
            f"{h5md.LAYOUT}"
        )


def refuse_missing(path: Path) -> None:
    """Raise for a file that is not there, or is empty: HDF5 would make that one of its own."""
    with refusing(path, "cannot be opened"):
        if not path.exists():
            raise TrajectoryError(f"{path}: there is no such trajectory")
        if path.stat().st_size == 0:
            raise TrajectoryError(f"{path}: it is empty")


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
    here = "this process has it open"
    for known, plain in {
        "file signature not found": "it is not an HDF5 file",
        "truncated file": "it is cut short",
        "already open for read-only": f"{here} for reading, through HDF5; close it there",
        _OTHERWISE: f"{here}, through HDF5; close it there",
    }.items():
        if known in text:
            return plain
    return text
