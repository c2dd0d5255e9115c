"""The lock that lets one run at a time write a trajectory, while others read it.

The lock is on a file beside the trajectory, ``trajectory.h5.lock``, which names the process that
holds it. A lock on the data file itself would keep readers out of a run, or a run out of what
somebody reads: HDF5 locks that file, for readers too. A process that is killed loses its lock. The
next run takes over the lock file that it leaves, and removes it at its end.
"""

from __future__ import annotations

import os
import socket
from contextlib import suppress
from pathlib import Path
from typing import Self

from nrchain.errors import PlatformError, TrajectoryError

try:
    import fcntl as fcntl
except ImportError:
    raise PlatformError from None

LONGEST_NOTE = 4096
"""Bytes of a lock file that are read."""


class WriteLock:
    """The lock for writing ``path``, whether or not there is a file of that name yet.

    ``file`` is the lock file. Raises :class:`~nrchain.errors.TrajectoryError`, with the process
    that holds the lock, if another one does, and OSError where no file can be made. On a file
    system without locks everybody gets the lock.
    """

    def __init__(self, path: Path) -> None:
        self.file = lock_path(path)
        while not self._acquire(path):
            continue

    def _acquire(self, path: Path) -> bool:
        """Lock the file; False if its last owner removed it meanwhile."""
        self._descriptor = os.open(self.file, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            if not _try_lock(self._descriptor):
                raise TrajectoryError(f"{path}: {lock_holder(self.file)} is writing to it")
            if is_same_file(self.file, self._descriptor):
                os.ftruncate(self._descriptor, 0)
                os.pwrite(self._descriptor, f"{os.getpid()} {socket.gethostname()}".encode(), 0)
                return True
        except BaseException:
            self._close()
            raise
        self._close()
        return False

    def release(self) -> None:
        """Release the lock; a second time does nothing."""
        if self._descriptor < 0:
            return
        # remove the file while it is locked, so that nobody locks one that has lost its name; a
        # process forked meanwhile keeps a lock on a removed file, which bars nobody
        if is_same_file(self.file, self._descriptor):
            with suppress(OSError):
                self.file.unlink()
        self._close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    def _close(self) -> None:
        os.close(self._descriptor)
        self._descriptor = -1


def lock_path(path: Path) -> Path:
    """The lock file of ``path``, the same for every link to it."""
    real = Path(os.path.realpath(path))
    return real.with_name(real.name + ".lock")


def is_locked(lock: Path) -> bool:
    """Whether some process holds the lock on a lock file."""
    try:
        descriptor = os.open(lock, os.O_RDONLY)
    except OSError:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    finally:
        os.close(descriptor)
    return False


def lock_holder(lock: Path) -> str:
    """The process that holds a lock, in words."""
    try:
        with lock.open("rb") as file:
            words = file.read(LONGEST_NOTE).decode(errors="replace").split()
        process, host = int(words[0]), words[1]
    except (OSError, ValueError, IndexError):
        # the file is being written, or has just been removed
        return "another process"
    if host != socket.gethostname():
        return f"process {process} on {host}"
    return "this process" if process == os.getpid() else f"process {process}"


def _try_lock(descriptor: int) -> bool:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        # this file system has no locks; HDF5 ignores that too
        return True
    return True


def is_same_file(path: Path, descriptor: int) -> bool:
    """Whether an open file still has that name."""
    try:
        return os.path.samestat(os.stat(path), os.fstat(descriptor))
    except (FileNotFoundError, NotADirectoryError):
        return False
