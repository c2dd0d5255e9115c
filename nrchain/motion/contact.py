"""min |r_i − r_j| = 2a, and links turned by π/2: the limits of every start and run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from nrchain._compile import kernel
from nrchain.scene.scene import Scene

OVERCOME = 0.5
"""Smallest distance of repelling spheres, in units of two radii. Repulsion yields gradually; it has
failed when two spheres overlap by half."""


@dataclass(frozen=True)
class PoseLimits:
    """The lengths and springs that decide which poses no run may reach.

    Attributes
    ----------
    radius
        a, of a sphere.
    contact
        Distance of centres at which spheres touch; with a repulsion between them, the distance at
        which it has been overcome.
    period
        Length after which a periodic chain repeats along x; 0 for open chains.
    rotational_springs
        Whether links resist twist or bend, and may not turn by a quarter turn.
    """

    radius: float
    contact: float
    period: float
    rotational_springs: bool

    @classmethod
    def of(cls, scene: Scene) -> Self:
        """Those of a scene."""
        springs = has_rotational_springs(scene)
        return cls(scene.chain.radius, contact_distance(scene), scene.period, springs)


def contact_distance(scene: Scene) -> float:
    """The distance of two centres at which a run stops."""
    return 2.0 * scene.chain.radius * (OVERCOME if scene.steric.acts else 1.0)


def has_rotational_springs(scene: Scene) -> bool:
    """Whether links resist twist or bend."""
    return bool(scene.moduli.twist or scene.moduli.bend)


def most_turned_link(frames: np.ndarray, periodic: bool) -> tuple[float, int]:
    """The largest angle between the two frames of a link, and that link."""
    alignment, link = least_aligned(frames, periodic)
    return float(np.arccos(np.clip(alignment, -1.0, 1.0))), link


@kernel
def least_aligned(frames, periodic):
    """The least cos α = (Σ_a e_a·e_a′ − 1)/2 of a link, α between its frames, and which link."""
    count = frames.shape[0]
    least, which = np.inf, 0
    for link in range(count if periodic else count - 1):
        ahead = (link + 1) % count
        total = -1.0
        for a in range(3):
            for k in range(3):
                total += frames[link, a, k] * frames[ahead, a, k]
        if 0.5 * total < least:
            least, which = 0.5 * total, link
    return least, which


def least_alignment(frames: np.ndarray, periodic: bool) -> float:
    return least_aligned(frames, periodic)[0]
