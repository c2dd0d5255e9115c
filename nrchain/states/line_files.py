"""A branch along a line of scenes in one HDF5 file, replaced as a whole while it grows.

The file is written beside its place and moved there, so that a program that is killed leaves the
file of a moment ago.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from nrchain.scene.scene import Scene
from nrchain.scene.toml import read_toml, write_toml
from nrchain.states.varied import Line
from nrchain.trajectory.checked_datasets import damage_errors
from nrchain.trajectory.file import file_errors
from nrchain.version import __version__


@contextmanager
def new_branch_file(path: Path, form: str, line: Line) -> Iterator[Any]:
    """An open file with the line; it replaces an older one at the end.

    ``form`` names what the file holds, for :func:`branch_file`.
    """
    import h5py

    partial = path.with_name(path.name + ".partial")
    with file_errors(path, "cannot be written"):
        with h5py.File(partial, "w") as file:
            file.attrs["format"] = form
            file.attrs["nrchain"] = __version__
            file.attrs["scene"] = write_toml(line.scene.to_mapping())
            file.attrs["ranges"] = json.dumps(line.ranges)
            yield file
        os.replace(partial, path)


@contextmanager
def branch_file(path: Path, form: str) -> Iterator[tuple[Any, Line]]:
    """The open file, to read, and its line.

    Raises :class:`~nrchain.errors.TrajectoryError` for a file that is damaged or of another kind.
    """
    import h5py

    with file_errors(path, "cannot be opened"):
        opened = h5py.File(path, "r")
    with opened as file, damage_errors(path):
        if file.attrs.get("format") != form:
            raise ValueError(f"its format is not {form!r}")
        ranges = {key: tuple(ends) for key, ends in json.loads(file.attrs["ranges"]).items()}
        yield file, Line(Scene.from_mapping(read_toml(file.attrs["scene"])), ranges)
