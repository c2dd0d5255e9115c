"""Folders that are made for a result, and taken back if there is none."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from nrchain.errors import TrajectoryError
from nrchain.run.interruption import undone


@contextmanager
def made(folder: Path) -> Iterator[None]:
    """Make a folder and those it lies in; where an exception leaves them empty, remove them.

    Raises :class:`~nrchain.errors.TrajectoryError` where it cannot be made.
    """
    new: list[Path] = []
    try:
        for path in (folder, *folder.parents):
            if path.exists():
                break
            new.append(path)
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        told = error.strerror if isinstance(error, OSError) else error
        raise TrajectoryError(f"{folder}: cannot be made: {told}") from error

    def take_back() -> None:
        with suppress(OSError):
            for path in new:
                path.rmdir()

    try:
        with undone(take_back):
            yield
    except BaseException:
        take_back()
        raise
