"""The right to write a file, which one run has at a time, whoever reads the file meanwhile.

The right is a lock on a file beside it, ``trajectory.h5.lock``, which names the process that holds
it. HDF5 locks the data file itself, for readers too, so a lock there would keep readers out of a
run, or a run out of what somebody reads. A process that is killed gives its lock up; the file that
it leaves is taken over, and removed, by the next run.
"""

from __future__ import annotations

import os
import socket
from contextlib import suppress
from pathlib import Path
from typing import Self

from nrchain.errors import PlatformError, TrajectoryError

try:
    import fcntl
except ImportError:
    raise PlatformError from None

LONGEST_NOTE = 4096
"""Bytes of a lock file that are read."""


class Claim:
    """The right to write ``path``, whether or not there is a file of that name yet.

    Raises :class:`~nrchain.errors.TrajectoryError`, which names the process that has it, if
    somebody else has, and OSError where no file can be made. On a file system without locks
    everybody is given it.
    """

    def __init__(self, path: Path) -> None:
        self.lock = lock_of(path)
        while not self._take(path):
            continue

    def _take(self, path: Path) -> bool:
        """Whether the lock taken is still the one of that name; its owner removes it at the end."""
        self._descriptor = os.open(self.lock, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            if not _locked(self._descriptor):
                raise TrajectoryError(f"{path}: {holder(self.lock)} is writing to it")
            if is_at(self.lock, self._descriptor):
                os.ftruncate(self._descriptor, 0)
                os.pwrite(self._descriptor, f"{os.getpid()} {socket.gethostname()}".encode(), 0)
                return True
        except BaseException:
            self._let_go()
            raise
        self._let_go()
        return False

    def release(self) -> None:
        """Give up the right; a second time does nothing."""
        if self._descriptor < 0:
            return
        # while it is locked, so that nobody takes a lock that has lost its name; a process forked
        # meanwhile keeps this one, which stands for nothing then
        if is_at(self.lock, self._descriptor):
            with suppress(OSError):
                self.lock.unlink()
        self._let_go()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    def _let_go(self) -> None:
        os.close(self._descriptor)
        self._descriptor = -1


def lock_of(path: Path) -> Path:
    """The file whose lock is the right to write ``path``, the same for every link to it."""
    real = Path(os.path.realpath(path))
    return real.with_name(real.name + ".lock")


def is_held(lock: Path) -> bool:
    """Whether some process has the right that goes with a lock file."""
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


def holder(lock: Path) -> str:
    """Who holds a lock, as a message says it."""
    try:
        with lock.open("rb") as file:
            words = file.read(LONGEST_NOTE).decode(errors="replace").split()
        process, host = int(words[0]), words[1]
    except (OSError, ValueError, IndexError):
        # it is being written, or has just been removed
        return "another process"
    if host != socket.gethostname():
        return f"process {process} on {host}"
    return "this process" if process == os.getpid() else f"process {process}"


def _locked(descriptor: int) -> bool:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        # no locks on this file system, as HDF5 takes it too
        return True
    return True


def is_at(path: Path, descriptor: int) -> bool:
    """Whether an open file is still the one of that name."""
    try:
        return os.path.samestat(os.stat(path), os.fstat(descriptor))
    except (FileNotFoundError, NotADirectoryError):
        return False
