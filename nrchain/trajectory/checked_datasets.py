"""Data sets of a trajectory file, checked: errors name what is missing or damaged."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from nrchain.errors import SceneError, TrajectoryError

Meaning = TypeVar("Meaning")

Shape = tuple[int | None, ...]
"""Sizes of a data set; None stands for any size."""


@contextmanager
def damage_errors(path: Path) -> Iterator[None]:
    """Turn errors in reading a file into a TrajectoryError that names the damage."""
    try:
        yield
    except TrajectoryError:
        raise
    except SceneError as error:
        raise TrajectoryError(f"{path}: its scene cannot be read: {_line(error)}") from error
    # damage causes errors of many kinds, in HDF5 and in code that uses what it returns
    except (
        *(OSError, LookupError, ValueError, RuntimeError, MemoryError),
        *(TypeError, AttributeError, ArithmeticError),
    ) as error:
        raise TrajectoryError(f"{path}: damaged: {_line(error)}") from error


def _line(error: Exception) -> str:
    """The message of an error in one line; that of a KeyError without its quotes."""
    message = error.args[0] if isinstance(error, KeyError) and error.args else error
    return " ".join(str(message).split())


def dataset(file: Any, name: str, shape: Shape, kinds: str = "f") -> Any:
    """The data set of that name. Raises ValueError if it is missing or of another shape or type."""
    import h5py

    found = _find(file, name)
    if not isinstance(found, h5py.Dataset):
        raise ValueError(f"{name} is not a data set")
    if found.shape is None or len(found.shape) != len(shape):
        raise ValueError(f"{name}: shape {found.shape}, not {_named(shape)}")
    if any(want not in (None, have) for want, have in zip(shape, found.shape, strict=True)):
        raise ValueError(f"{name}: shape {found.shape}, not {_named(shape)}")
    if found.dtype.kind not in kinds:
        raise ValueError(f"{name}: its numbers are of type {found.dtype}")
    return found


def _find(file: Any, name: str) -> Any:
    """The object of that name. HDF5 reports damage on the way to it as a missing name."""
    try:
        return file[name]
    except (KeyError, RuntimeError, OSError) as error:
        raise ValueError(f"{name} is missing, or cannot be read") from error


def read_text(file: Any, name: str) -> str:
    """A text of a file."""
    return str(dataset(file, name, (), "OS").asstr()[()])


def read_code(file: Any, name: str, meanings: Sequence[Meaning]) -> Meaning:
    """The meaning of a code in the file."""
    code = int(dataset(file, name, (1,), "u")[0])
    if code >= len(meanings):
        raise ValueError(f"{name} is {code}; the largest code is {len(meanings) - 1}")
    return meanings[code]


def _named(shape: Shape) -> str:
    return f"({', '.join('any' if size is None else str(size) for size in shape)})"


def require_array(array: np.ndarray | float, shape: tuple[int, ...], name: str) -> None:
    """Raise for an array of another shape, which HDF5 would broadcast, or with NaN or infinity."""
    if np.shape(array) != shape:
        raise ValueError(f"{name}: shape {np.shape(array)}, not {shape}")
    if not np.all(np.isfinite(array)):
        raise ValueError(f"{name}: not all values are finite")
