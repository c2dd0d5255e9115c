"""Rows of a data set, written by the calls of HDF5 itself.

A snapshot of a small chain is a few rows of some kilobytes. The indexing of h5py takes several
times as long to find their place as HDF5 takes to write them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike


class Rows:
    """The rows ``(…)`` of an open data set ``(T, …)``.

    >>> import h5py
    >>> file = h5py.File("rows", "w", driver="core", backing_store=False)
    >>> data = file.create_dataset("data", (0, 2), float, maxshape=(None, 2))
    >>> rows = Rows(data)
    >>> rows.resize(2)
    >>> rows.write(1, [[3.0, 4.0]])
    >>> data[1]
    array([3., 4.])
    """

    def __init__(self, data: Any) -> None:
        self.data = data
        self._row: tuple[int, ...] = data.shape[1:]

    def resize(self, count: int) -> None:
        """Set the number of rows."""
        self.data.id.set_extent((count, *self._row))

    def write(self, first: int, values: ArrayLike) -> None:
        """Write the rows from ``first`` on."""
        from h5py import h5s

        rows = np.ascontiguousarray(values, self.data.dtype)
        place = self.data.id.get_space()
        place.select_hyperslab((first, *len(self._row) * (0,)), rows.shape)
        put(self.data, h5s.create_simple(rows.shape), place, rows)


def write_whole(data: Any, values: ArrayLike) -> None:
    """Write all numbers of an open data set."""
    from h5py import h5s

    row = np.ascontiguousarray(values, data.dtype).reshape(data.shape)
    put(data, h5s.ALL, h5s.ALL, row)


def put(data: Any, memory: Any, place: Any, values: np.ndarray) -> None:
    """Write ``values``, laid out as ``memory``, to a place of a data set."""
    data.id.write(memory, place, values)
