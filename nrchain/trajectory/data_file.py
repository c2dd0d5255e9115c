"""The file that a run writes to, whatever becomes of its name, and whoever else has it open."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Self

from nrchain.errors import TrajectoryError
from nrchain.trajectory.claim import fcntl, is_at


class DataFile:
    """The file of that name, kept free of other programs that write to it while this is open.

    HDF5 locks a file, for itself alone where it writes, shared where it reads: a shared lock here
    lets readers in, in whatever order, and keeps writers out. Raises
    :class:`~nrchain.errors.TrajectoryError` where another program has the file open for writing,
    and OSError for a file that cannot be written.
    """

    def __init__(self, path: Path) -> None:
        self._descriptor = os.open(path, os.O_RDWR)
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError as error:
            os.close(self._descriptor)
            raise TrajectoryError(f"{path}: another program has it open for writing") from error
        except OSError:
            # no locks on this file system
            return

    def holds(self, path: Path) -> bool:
        """Whether this is still the file of that name."""
        return is_at(path, self._descriptor)

    def size(self) -> int:
        """Bytes of the file."""
        return os.fstat(self._descriptor).st_size

    def cut(self, size: int) -> None:
        """Leave no more than the first bytes of the file."""
        os.ftruncate(self._descriptor, size)

    def close(self) -> None:
        """Let other programs write again; a second time does nothing."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
        self._descriptor = -1

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
