"""Folders for results: created before a run, removed again if it fails and leaves them empty."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from nrchain.errors import TrajectoryError
from nrchain.run.interruption import cleanup_on_exit


@contextmanager
def new_folder(folder: Path) -> Iterator[None]:
    """Create a folder and its parents; remove those created if an exception leaves them empty.

    Raises :class:`~nrchain.errors.TrajectoryError` where it cannot be created.
    """
    created: list[Path] = []
    try:
        for path in (folder, *folder.parents):
            if path.exists():
                break
            created.append(path)
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else error
        raise TrajectoryError(f"{folder}: cannot be made: {why}") from error

    def remove_created() -> None:
        with suppress(OSError):
            for path in created:
                path.rmdir()

    try:
        with cleanup_on_exit(remove_created):
            yield
    except BaseException:
        remove_created()
        raise
