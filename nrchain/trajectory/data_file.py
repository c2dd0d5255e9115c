"""The data file of a run: whether it still has its name, and protection from other writers."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Self

from nrchain.errors import TrajectoryError
from nrchain.trajectory.write_lock import fcntl, is_same_file


class DataFile:
    """The file of that name, locked against other programs that write while this is open.

    HDF5 takes an exclusive lock to write and a shared one to read. The shared lock here therefore
    lets readers in and keeps writers out. Raises :class:`~nrchain.errors.TrajectoryError` if
    another program has the file open for writing, and OSError for a file that cannot be written.
    """

    def __init__(self, path: Path) -> None:
        self._descriptor = os.open(path, os.O_RDWR)
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError as error:
            os.close(self._descriptor)
            raise TrajectoryError(f"{path}: another program has it open for writing") from error
        except OSError:
            # this file system has no locks
            return

    def holds(self, path: Path) -> bool:
        """Whether this file still has that name."""
        return is_same_file(path, self._descriptor)

    def size(self) -> int:
        """Bytes of the file."""
        return os.fstat(self._descriptor).st_size

    def cut(self, size: int) -> None:
        """Keep only the first ``size`` bytes."""
        os.ftruncate(self._descriptor, size)

    def close(self) -> None:
        """Close the file and unlock it; a second time does nothing."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
        self._descriptor = -1

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
