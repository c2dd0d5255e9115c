"""Σ_m μ_m W_{i±m}: twists due to wrenches on all other spheres of an infinite straight chain.

The mobility of two spheres on a line is a sum of pure powers of their distance, and so is its
derivative with a displacement. The coefficients come from the code of the simulation, evaluated
for two spheres at a few distances.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from nrchain.errors import SceneError
from nrchain.hydrodynamics.friction import PairFriction
from nrchain.scene.chain_sections import ChainSpec
from nrchain.theory.lattice_sums import STRIDE, Reach, cosine_sum, power_sum, sine_sum, take_apart

Sides = dict[int, np.ndarray]
"""Of every power s, (2, …): the coefficients of 1/m^s of the sphere m places right, and left."""

_FORCES, _TORQUES = slice(0, 3), slice(3, 6)
_POWERS = (
    (_FORCES, _FORCES, (1, 3)),
    (_FORCES, _TORQUES, (2,)),
    (_TORQUES, _FORCES, (2,)),
    (_TORQUES, _TORQUES, (3,)),
)
"""Rows, columns and the powers of a/r in them, for spheres that do not overlap."""


class LineMobility:
    """μ between the spheres of an infinite straight chain along x, up to ``reach`` neighbours.

    ``powers[s]`` (2, 6, 6) are the coefficients of 1/m^s in the twist that a wrench on the sphere m
    places to the right (row 0) or left (row 1) gives.
    """

    def __init__(self, chain: ChainSpec, reach: Reach) -> None:
        self._chain, self.reach = chain, reach
        samples = np.empty((2, 2, 6, 6))
        for n, pair in enumerate(samples):
            friction, positions = self._pair(n)
            matrix = friction.matrix(positions)
            pair[0], pair[1] = matrix[:6, 6:], matrix[6:, :6]
        self.powers: Sides = {}
        for rows, columns, powers in _POWERS:
            _add_share(self.powers, samples, rows, columns, powers)

    def _pair(self, n: int) -> tuple[PairFriction, np.ndarray]:
        """Two spheres at the n-th distance, and their friction."""
        positions = np.zeros((2, 3))
        positions[1, 0] = self._chain.spacing * STRIDE**n
        return PairFriction(2, 1, self._chain.radius, self._chain.viscosity), positions

    def waves(self, phases: np.ndarray) -> NDArray[np.complex128]:
        """Σ_m μ_m e^{imθ} (..., 6, 6), without a sphere's own mobility; 1/m is left out at θ = 0.

        At θ = 0 the forces of a wave sum to zero.
        """
        operator = np.zeros((*phases.shape, 6, 6), complex)
        for power, (right, left) in self.powers.items():
            cosine = cosine_sum(power, phases, self.reach)[..., None, None]
            cosine = np.where(np.isinf(cosine), 0.0, cosine)
            sine = sine_sum(power, phases, self.reach)[..., None, None]
            operator += (right + left) * cosine + 1j * (right - left) * sine
        return operator

    def twist(self, wrench: np.ndarray) -> np.ndarray:
        """The twist (6,) that the same wrench (6,) on all other spheres gives each.

        Raises :class:`~nrchain.errors.SceneError` where it has no sum.
        """
        twist = np.zeros(6)
        for power, (right, left) in self.powers.items():
            both = (right + left) @ wrench
            pushed = np.abs(both) > 1e-14 * (np.abs(right) + np.abs(left)) @ np.abs(wrench)
            total = power_sum(power, self.reach)
            if pushed.any() and math.isinf(total):
                allowed = (
                    "the same force on all spheres of an infinite chain gives a velocity without"
                    " limit: use a number"
                )
                raise SceneError("friction.neighbours", self.reach, allowed)
            twist[pushed] += both[pushed] * total
        return twist

    def blocks(self, wrench: np.ndarray) -> Sides:
        """∂(μ_m W)/∂(u, φ) of the sphere that the wrench (6,) acts on, (2, 6, 6) of each power."""
        samples, sides = np.empty((3, 2, 6, 6)), dict[int, np.ndarray]()
        wrenches, constant = np.tile(wrench, (2, 1)), np.zeros((2, 3, 6, 6))
        for n, pair in enumerate(samples):
            friction, positions = self._pair(n)
            blocks = np.zeros((2, 3, 6, 6))
            friction.add_jacobian(positions, wrenches, constant, blocks, near=1)
            pair[0], pair[1] = blocks[0, 2], blocks[1, 0]
        every = slice(0, 6)
        _add_share(sides, samples, _FORCES, every, (2, 3, 4))
        _add_share(sides, samples, _TORQUES, every, (3, 4))
        return sides


def _add_share(
    sides: Sides, samples: np.ndarray, rows: slice, columns: slice, powers: tuple[int, ...]
) -> None:
    for power, share in take_apart(samples[:, :, rows, columns], list(powers)).items():
        sides.setdefault(power, np.zeros((2, 6, 6)))[:, rows, columns] += share
