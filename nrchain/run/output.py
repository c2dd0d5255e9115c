"""Where the trajectory of a run is written: a file, or a folder for one."""

from __future__ import annotations

import re
from pathlib import Path

from nrchain.errors import TrajectoryError
from nrchain.trajectory.file import FILE_NAME, file_errors, refuse_existing

ENDINGS = (".h5", ".hdf5", ".h5md")
"""Of trajectory files."""

_ENDING = re.compile(r"\.[A-Za-z]\w*")


def output_file(output: str | Path, overwrite: bool = False) -> tuple[Path | None, Path]:
    """The folder to create, if ``output`` is one, and the trajectory file.

    A path without an ending is a folder. A dot and a number, as in ``runs/R1e7.5``, are no ending.

    Raises :class:`~nrchain.errors.TrajectoryError` for the ending of another kind of file, and for
    a file that exists unless ``overwrite`` is set.
    """
    path = Path(output)
    with file_errors(path, "cannot be made"):
        is_folder = path.is_dir() or not _ENDING.fullmatch(path.suffix)
        if not is_folder and path.suffix.lower() not in ENDINGS:
            raise TrajectoryError(
                f"{path}: must be a folder, or a file that ends in {', '.join(ENDINGS)}"
            )
        file = path / FILE_NAME if is_folder else path
        refuse_existing(file, overwrite)
    return path if is_folder else None, file
