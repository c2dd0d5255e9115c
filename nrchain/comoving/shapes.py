"""x(t): strains of all links, which know nothing of how a chain moves as a whole; and dx/dt.

Of every link three numbers are where the next sphere is in the frame of the first, less (d, 0, 0),
and three are d times the axial vector of the rotation between the frames: twist and both bends. For
motions of the whole that a field or a flow forbids, x holds the orientation or the place as well.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nrchain.comoving.motions import TURN, moved, span
from nrchain.comoving.relative import RelativeChain
from nrchain.types import Poses

NUDGE = 1e-6
"""Largest displacement, in radii or radians, by which dx/dt is differentiated."""


@dataclass(frozen=True)
class Shapes:
    """x (T, m) and dx/dt (T, m) at times (T,); the first ``links`` groups of six are strains."""

    time: np.ndarray
    values: np.ndarray
    rates: np.ndarray
    links: int

    def bends(self, values: np.ndarray) -> np.ndarray:
        """(…, links, 2): both bends of every link, of values (…, m)."""
        strains = values[..., : 6 * self.links]
        return strains.reshape(*values.shape[:-1], self.links, 6)[..., 4:]


class Series:
    """The shapes of a run at snapshots that are asked for: each costs two right-hand sides."""

    def __init__(
        self, chain: RelativeChain, time: np.ndarray, positions: np.ndarray, frames: np.ndarray
    ) -> None:
        self.chain, self.time = chain, time
        self._positions, self._frames = positions, frames

    def at(self, places: np.ndarray) -> Shapes:
        """The shapes at these snapshots."""
        poses = [(self._positions[k], self._frames[k]) for k in places]
        values = np.array([_shape(self.chain, *pose) for pose in poses])
        rates = np.array([_rate(self.chain, *pose) for pose in poses])
        spheres = self._positions.shape[1]
        links = spheres - (self.chain.scene.chain.ends != "periodic")
        return Shapes(self.time[places], values, rates, links)

    def late(self, most: int) -> Shapes:
        """The shapes at no more than ``most`` snapshots, spread over the last half."""
        count = len(self.time)
        return self.at(np.unique(np.linspace(count // 2, count - 1, most).astype(int)))


def _rate(chain: RelativeChain, positions: np.ndarray, frames: np.ndarray) -> np.ndarray:
    """dx/dt (m,), from poses a little before and after."""
    twists = chain.model.twists(positions, frames)
    sizes = np.abs(twists).max(axis=0) / np.repeat([chain.scene.chain.radius, 1.0], 3)
    step = NUDGE / max(float(sizes.max()), 1e-300)
    after, before = (moved(positions, frames, sign * step * twists) for sign in (1.0, -1.0))
    change: np.ndarray = _shape(chain, *after) - _shape(chain, *before)
    return change / (2.0 * step)


def _shape(chain: RelativeChain, positions: np.ndarray, frames: np.ndarray) -> np.ndarray:
    """x (m,)."""
    scene = chain.scene
    spacing = scene.chain.spacing
    links, ahead = np.diff(positions, axis=0), frames[1:]
    if scene.chain.ends == "periodic":
        closing = positions[:1] - positions[-1:] + [[scene.length, 0.0, 0.0]]
        links, ahead = np.concatenate([links, closing]), np.roll(frames, -1, axis=0)
    here = frames[: len(links)]
    strains = np.empty((len(links), 6))
    strains[:, :3] = np.einsum("nkc,nc->nk", here, links) - [spacing, 0.0, 0.0]
    between = np.einsum("nac,nbc->nab", here, ahead)
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        strains[:, 3 + k] = 0.5 * spacing * (between[:, i, j] - between[:, j, i])
    return np.concatenate([strains.ravel(), *_placed(chain, (positions, frames))])


def _placed(chain: RelativeChain, poses: Poses) -> list[np.ndarray]:
    """Orientation and place, as far as the scene does not leave them free."""
    if chain.model.held.any():
        return []
    positions, frames = poses
    shifts, turns = span(chain.allowed[:3]), span(chain.allowed[3:TURN])
    placed = []
    if len(turns) < 3:
        known = turns if len(turns) == 1 else np.eye(3)
        placed.append(chain.scene.chain.spacing * (frames[0] @ known.T).ravel())
    if len(shifts) < 3:
        centre = positions.mean(axis=0)
        placed.append(centre - centre @ shifts.T @ shifts)
    return placed
