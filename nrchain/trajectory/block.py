"""Snapshots in a row, as a run hands them over."""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np

from nrchain.trajectory.error_estimate import NOT_KNOWN


class Block(NamedTuple):
    """K snapshots in a row.

    Attributes
    ----------
    time, steps
        (K,) the times, and the steps of the run by then.
    positions, frames
        (K, N, 3) and (K, N, 3, 3).
    errors
        (K, 2): the errors of positions and of frames, if they are estimated.
    """

    time: np.ndarray
    positions: np.ndarray
    frames: np.ndarray
    steps: np.ndarray
    errors: np.ndarray | None = None

    @classmethod
    def of_one(cls, time: float, positions: np.ndarray, frames: np.ndarray, step: int) -> Self:
        """That of one snapshot.

        >>> Block.of_one(0.5, np.zeros((4, 3)), np.zeros((4, 3, 3)), 7).positions.shape
        (1, 4, 3)
        """
        whole = np.asarray(positions)[None], np.asarray(frames)[None]
        return cls(np.array([time], float), *whole, np.array([step]))

    def part(self, begin: int, end: int) -> Self:
        """Those from ``begin`` on, without ``end``."""
        rows = slice(begin, end)
        errors = None if self.errors is None else self.errors[rows]
        poses = self.positions[rows], self.frames[rows]
        return type(self)(self.time[rows], *poses, self.steps[rows], errors)

    def errors_known(self) -> np.ndarray:
        """The ``errors``, NaN where none are estimated."""
        if self.errors is None:
            return np.tile(NOT_KNOWN, (len(self.time), 1))
        return self.errors
