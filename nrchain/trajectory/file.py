"""The trajectory file on the disk: created whole or not at all, locked, opened."""

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
from nrchain.trajectory.checked_datasets import damage_errors, read_text
from nrchain.trajectory.data_file import DataFile
from nrchain.trajectory.new_file import write_new_file
from nrchain.trajectory.write_lock import WriteLock, is_locked, lock_holder, lock_path

FILE_NAME = "trajectory.h5"

_OTHER_LOCKS = "locking flag values don't match"
"""The error of HDF5 for a file that the same process has open with other locks."""


def locate(path: str | Path) -> Path:
    """The trajectory file at a path: the path itself, or ``trajectory.h5`` in a directory."""
    path = Path(path)
    with file_errors(path, "cannot be opened"):
        return path / FILE_NAME if path.is_dir() else path


def create(
    path: Path,
    scene: Scene,
    times: np.ndarray,
    choice: str = "",
    provenance: str = "",
    *,
    overwrite: bool = False,
) -> WriteLock:
    """Create the file of a run of ``scene`` with snapshots at ``times (T,)``, none finished yet.

    The file appears under its name once it is complete, and replaces an older one then, if
    ``overwrite`` is set. The write lock is held from before the first byte, so that of several runs
    that start at once only one gets the file. Returns the lock.

    Raises :class:`~nrchain.errors.SceneError` for more snapshots than the disk has room for, and
    :class:`~nrchain.errors.TrajectoryError` for a file that exists or cannot be made.
    """
    refuse_existing(path, overwrite)
    target = refuse_full_disk(path, scene, len(times))
    with file_errors(path, "cannot be created"):
        partial = target.with_name(target.name + ".partial")
        lock = WriteLock(path)
        try:
            # another run may have finished just before this one got the lock
            refuse_existing(path, overwrite)
            with protected(path):
                write_new_file(partial, scene, times, choice, target, provenance)
                os.replace(partial, target)
        except BaseException:
            partial.unlink(missing_ok=True)
            lock.release()
            raise
    return lock


def refuse_existing(path: Path, overwrite: bool) -> None:
    """Raise if the file exists and may not be overwritten. A run checks this first."""
    if path.exists() and not overwrite:
        raise TrajectoryError(
            f"{path}: exists; it is replaced only with overwrite=True (--overwrite)"
        )


def refuse_full_disk(path: Path, scene: Scene, snapshots: int) -> Path:
    """Raise if the disk has no room for so many snapshots; return the real path of the file."""
    with file_errors(path, "cannot be created"):
        target = Path(os.path.realpath(path))
        free = shutil.disk_usage(target.parent).free
    free -= CHECKPOINT_POSES * pose_bytes(scene)
    refuse_snapshots(scene, free, f"free in {target.parent}", snapshots)
    return target


def protected(path: Path) -> AbstractContextManager[object]:
    """Hold a file that is to be replaced. Raises if somebody writes to it or it is read-only."""
    try:
        return DataFile(path)
    except FileNotFoundError:
        return nullcontext()
    except PermissionError as error:
        raise TrajectoryError(f"{path}: exists and is write-protected") from error


def lock_existing(path: Path) -> WriteLock:
    """The write lock of the file of a run that is to be resumed.

    Raises :class:`~nrchain.errors.TrajectoryError` for a file that does not exist, and for one that
    another run writes to, also if that run created it under another name.
    """
    refuse_missing(path)
    with file_errors(path, "cannot be opened"):
        lock = WriteLock(path)
    try:
        with open_file(path, "r") as file, damage_errors(path):
            created = Path(read_text(file, h5md.NAME))
            if (
                lock_path(created) != lock.file
                and is_locked(lock_path(created))
                and _is_renamed(created, path)
            ):
                holder = lock_holder(lock_path(created))
                raise TrajectoryError(
                    f"{path}: {holder} is writing to it, which was called {created}"
                )
    except BaseException:
        lock.release()
        raise
    return lock


def _is_renamed(created: Path, path: Path) -> bool:
    """Whether a file was renamed since it was created, and is not a copy."""
    return not created.exists() or os.path.samefile(created, path)


def open_file(path: Path, mode: str) -> Any:
    """The open file of a run, to read (``"r"``) or, with its write lock, to write (``"r+"``).

    HDF5's own locks are off, so that a file can be read while it is written. Raises
    :class:`~nrchain.errors.TrajectoryError` for a file that is not HDF5, cut short, of another
    program, or of another layout.
    """
    refuse_missing(path)
    with file_errors(path, "cannot be opened"):
        file = _open(path, mode)
    try:
        with damage_errors(path):
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
        # this process has the file open with locks: open it in the same way
        if mode != "r" or _OTHER_LOCKS not in str(error):
            raise
        return h5py.File(path, mode)


def _refuse_foreign(path: Path, file: Any) -> None:
    if h5md.OURS not in file:
        raise TrajectoryError(f"{path}: an HDF5 file, but not one written by nrchain")
    layout = int(file[h5md.OURS].attrs.get("layout", 1))
    if layout != h5md.LAYOUT:
        raise TrajectoryError(
            f"{path}: has layout {layout} of another version of nrchain; this one reads layout "
            f"{h5md.LAYOUT}"
        )


def refuse_missing(path: Path) -> None:
    """Raise for a file that does not exist or is empty. HDF5 would create it."""
    with file_errors(path, "cannot be opened"):
        if not path.exists():
            raise TrajectoryError(f"{path}: there is no such trajectory")
        if path.stat().st_size == 0:
            raise TrajectoryError(f"{path}: it is empty")


@contextmanager
def file_errors(path: Path, what: str) -> Iterator[None]:
    """Turn errors of the file system and of HDF5 into a TrajectoryError that names the file."""
    try:
        yield
    except TrajectoryError:
        raise
    except (OSError, RuntimeError, ValueError, LookupError, OverflowError, MemoryError) as error:
        raise TrajectoryError(f"{path}: {what}: {_cause(error)}") from error


def _cause(error: Exception) -> str:
    """The cause of an error of HDF5 in plain words."""
    if isinstance(error, OSError) and error.errno:
        return os.strerror(error.errno)
    text = str(error)
    if number := re.search(r"errno = (\d+)", text):
        return os.strerror(int(number[1]))
    here = "this process has it open"
    for known, plain in {
        "file signature not found": "it is not an HDF5 file",
        "truncated file": "it is cut short",
        "already open for read-only": f"{here} for reading, through HDF5; close it there",
        _OTHER_LOCKS: f"{here}, through HDF5; close it there",
    }.items():
        if known in text:
            return plain
    return text
