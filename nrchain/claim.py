"""The right to write a file, which one process has at a time.

Taken as a lock on the file itself, before anything is written to it, and kept until the file is
closed: it goes with the file where that is renamed, and a process that is killed gives it up.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Self

from nrchain.errors import PlatformError, TrajectoryError

try:
    import fcntl
except ImportError:
    raise PlatformError from None


class Claim:
    """The right to write ``path``, which is made, empty, if ``create`` is set and it is not there.

    Raises :class:`~nrchain.errors.TrajectoryError` if somebody else has it, and OSError for a file
    that cannot be written. On a file system without locks everybody is given it.
    """

    def __init__(self, path: Path, *, create: bool = False) -> None:
        while not self._take(path, os.O_RDWR | (os.O_CREAT if create else 0)):
            continue

    def _take(self, path: Path, flags: int) -> bool:
        """Whether the file locked is still the one of that name; it may be replaced meanwhile."""
        self._descriptor = os.open(path, flags, 0o666)
        try:
            _lock(self._descriptor, path)
            if self.holds(path):
                return True
        except BaseException:
            self.release()
            raise
        self.release()
        return False

    def holds(self, path: Path) -> bool:
        """Whether the file claimed is still the one of that name."""
        return _is_at(path, self._descriptor)

    def size(self) -> int:
        """Bytes of the file."""
        return os.fstat(self._descriptor).st_size

    def cut(self, size: int) -> None:
        """Leave no more than the first bytes of the file."""
        os.ftruncate(self._descriptor, size)

    def release(self) -> None:
        """Give up the right; a second time does nothing."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
        self._descriptor = -1

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()


def _lock(descriptor: int, path: Path) -> None:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise TrajectoryError(f"{path}: another process is writing to it") from error
    except OSError:
        # no locks on this file system, as HDF5 takes it too
        return


def _is_at(path: Path, descriptor: int) -> bool:
    try:
        return os.path.samestat(os.stat(path), os.fstat(descriptor))
    except (FileNotFoundError, NotADirectoryError):
        return False
