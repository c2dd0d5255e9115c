"""dx/dt = u(x, t): tracers that the fluid carries past a chain, and the paths behind them.

A tracer that comes into a sphere, or far from the chain, is put at a new random place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nrchain.analysis.flow import flow
from nrchain.trajectory.trajectory import Trajectory

ROOM, REACH = 6.0, 10.0
"""Distances from the box about the chain, in radii: up to the first, tracers are put into the
fluid; beyond the second, they are taken out."""
STRIDE = 0.8
"""Longest way of most tracers from one frame to the next, in radii."""
MOST = 0.9
"""The fraction of tracers that :data:`STRIDE` holds for: next to a sphere the fluid is fast."""
STEP, MOST_STEPS = 0.25, 12
"""Longest way in one step of integration, in radii, and most steps from frame to frame."""
TRAIL, STILL_TRAIL = 12, 40
"""Number of places of the path behind a tracer, in a film and in a picture of one time."""


@dataclass(frozen=True)
class Tracers:
    """Paths of M tracers.

    Attributes
    ----------
    paths
        (F, M, K, 3): at each frame the last K places of each tracer, the present one last, in
        units of the trajectory. Places before it was put into the fluid repeat its first one.
    slowed
        How many times slower than the chain tracers move at most; 1 where the frames are so close
        that tracers keep pace.
    """

    paths: np.ndarray
    slowed: float

    @property
    def words(self) -> str:
        """How much slower than the chain the tracers are; empty where they keep pace."""
        return f"tracers {float(f'{self.slowed:.2g}'):g} times slower" if self.slowed > 1.0 else ""


def trace(trajectory: Trajectory, count: int, seed: int = 0) -> Tracers:
    """Paths of ``count`` tracers in the flow of a film, or of a picture of one time.

    Between two frames the flow changes linearly. Where the fluid would carry most tracers farther
    than :data:`STRIDE`, they move in the flow of each frame for as long as that takes: they are
    slower than the chain. At one time they are carried by the flow of that time.

    Raises :class:`~nrchain.errors.SceneError` where the flow is not known
    (:func:`nrchain.flow`).
    """
    cloud = _Cloud(trajectory, count, np.random.default_rng(seed))
    if len(trajectory.time) == 1:
        for _ in range(STILL_TRAIL):
            cloud.advance(0, 0, cloud.stride_time(0))
        return Tracers(cloud.trails[None], 1.0)
    paths, slowed = [], 1.0
    for frame, interval in enumerate(np.diff(trajectory.time)):
        paths.append(cloud.trails[:, -TRAIL:].copy())
        lasting = min(float(interval), cloud.stride_time(frame))
        slowed = max(slowed, float(interval) / lasting)
        keeps_pace = lasting == interval
        cloud.advance(frame, frame + 1 if keeps_pace else frame, lasting)
        cloud.renew(frame + 1)
    paths.append(cloud.trails[:, -TRAIL:].copy())
    return Tracers(np.array(paths), slowed)


class _Cloud:
    """Tracers now, with the paths behind them."""

    def __init__(self, trajectory: Trajectory, count: int, random: np.random.Generator) -> None:
        self._trajectory, self._random = trajectory, random
        self._radius = trajectory.scene.chain.radius
        self.trails = np.zeros((count, STILL_TRAIL, 3))
        self._put(0, np.ones(count, bool))

    @property
    def places(self) -> np.ndarray:
        return self.trails[:, -1]

    def velocity(self, frame: int, places: np.ndarray) -> np.ndarray:
        """u (M, 3) at a frame; 0 inside a sphere."""
        return np.nan_to_num(flow(self._trajectory, places, frame=frame).velocity, nan=0.0)

    def stride_time(self, frame: int) -> float:
        """How long most tracers take for :data:`STRIDE` in the flow of a frame."""
        speeds = np.linalg.norm(self.velocity(frame, self.places), axis=1)
        usual = float(np.quantile(speeds, MOST))
        return STRIDE * self._radius / usual if usual > 0.0 else np.inf

    def advance(self, first: int, second: int, lasting: float) -> None:
        """Carry the tracers on for a time, from the flow of one frame to that of the next."""
        places = self.places.copy()
        if np.isfinite(lasting):
            speed = np.linalg.norm(self.velocity(first, places), axis=1).max(initial=0.0)
            steps = int(np.clip(np.ceil(speed * lasting / (STEP * self._radius)), 1, MOST_STEPS))
            for step in range(steps):
                begin, middle = step / steps, (step + 0.5) / steps
                half = self._between(first, second, begin, places) * (lasting / steps / 2)
                places += self._between(first, second, middle, places + half) * (lasting / steps)
        self.trails = np.concatenate([self.trails[:, 1:], places[:, None]], axis=1)

    def _between(self, first: int, second: int, fraction: float, places: np.ndarray) -> np.ndarray:
        velocity = self.velocity(first, places)
        if first == second:
            return velocity
        return (1 - fraction) * velocity + fraction * self.velocity(second, places)

    def renew(self, frame: int) -> None:
        """Put tracers that are inside a sphere, or far away, at new places."""
        low, high = self._box(frame, REACH)
        far = ((self.places < low) | (self.places > high)).any(axis=1)
        self._put(frame, far | self._inside(frame, self.places))

    def _put(self, frame: int, which: np.ndarray) -> None:
        """Put the tracers ``which`` (M,) at random places in the fluid about the chain."""
        low, high = self._box(frame, ROOM)
        while which.any():
            new = self._random.uniform(low, high, (int(which.sum()), 3))
            self.trails[which] = new[:, None]
            which = which & self._inside(frame, self.places)

    def _inside(self, frame: int, places: np.ndarray) -> np.ndarray:
        apart = places[:, None] - self._trajectory.positions[frame]
        return ((apart**2).sum(axis=-1) < (1.02 * self._radius) ** 2).any(axis=1)

    def _box(self, frame: int, room: float) -> tuple[np.ndarray, np.ndarray]:
        positions = self._trajectory.positions[frame]
        away = room * self._radius
        return positions.min(axis=0) - away, positions.max(axis=0) + away
