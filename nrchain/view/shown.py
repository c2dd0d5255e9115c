"""The snapshots that a picture of a chain shows: their times and colours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from nrchain.errors import SceneError
from nrchain.trajectory.trajectory import Trajectory
from nrchain.view.drawing import pick_evenly
from nrchain.view.style import time_colours

Spacing = Literal["linear", "logarithmic"]
SPACINGS: tuple[Spacing, ...] = ("linear", "logarithmic")

FRAMES, FRAME_LENGTH = 12, 0.4
"""Most frames that are drawn along a chain, and the length of their vectors over d."""


@dataclass(frozen=True)
class Shown:
    """Chains at some times, in units of the sphere radius a.

    Attributes
    ----------
    time
        ``(T,)``, in the units of the scene.
    chains
        ``(T, N, 3)``, the centres over a.
    frames
        ``(T, N, 3, 3)``; ``frames[t, i, k]`` is e_{k+1} of sphere i.
    colours
        ``(T, 4)``, from light to dark.
    length
        Of a drawn vector of a frame, over a.
    """

    time: np.ndarray
    chains: np.ndarray
    frames: np.ndarray
    colours: np.ndarray
    length: float

    def arrows(self, number: int, vector: int) -> tuple[np.ndarray, np.ndarray]:
        """(m, 3) and (m, 3): where vectors e_{vector + 1} at time ``number`` begin and point."""
        count = self.chains.shape[1]
        picked = np.arange(0, count, -(-count // FRAMES))
        return self.chains[number, picked], self.length * self.frames[number, picked, vector]


def choose(trajectory: Trajectory, times: int, spacing: str) -> Shown:
    """``times`` snapshots of a trajectory, from the first to the last; see :func:`pick_times`."""
    chosen = pick_times(trajectory.time, times, spacing)
    chain = trajectory.scene.chain
    return Shown(
        trajectory.time[chosen],
        trajectory.positions[chosen] / chain.radius,
        trajectory.frames[chosen],
        time_colours(len(chosen)),
        FRAME_LENGTH * chain.spacing / chain.radius,
    )


def pick_times(time: np.ndarray, most: int, spacing: str = "linear") -> np.ndarray:
    """At most ``most`` indices of increasing times, from the first to the last.

    Linear times are evenly spaced. Logarithmic ones have even ratios of the time since the first,
    which is shown too.

    Raises :class:`~nrchain.errors.SceneError` for less than one time and for another spacing.

    >>> pick_times(np.arange(101.0), 4), pick_times(np.arange(101.0), 4, "logarithmic")
    (array([  0,  33,  67, 100]), array([  0,   1,  10, 100]))
    """
    if most < 1:
        raise SceneError("times", most, "must be at least 1")
    if spacing not in SPACINGS:
        raise SceneError("spacing", spacing, f"must be one of {', '.join(SPACINGS)}")
    if spacing == "linear" or most < 3 or len(time) < 3:
        return pick_evenly(len(time), most)
    since = time - time[0]
    wanted = np.geomspace(since[1], since[-1], most - 1)
    nearest = np.abs(since[None, 1:] - wanted[:, None]).argmin(axis=1) + 1
    return np.unique([0, *nearest])
