"""(v, ω) = μ·(F, T): from wrenches to twists, with clamped spheres held at rest.

With one-body friction μ is the drag of each sphere. With friction between spheres it is the matrix
of :mod:`nrchain.hydrodynamics.friction`. A clamp holds a sphere by a support wrench. With one-body
friction this wrench moves no other sphere, and the twist of the clamped sphere is zero. With
friction between spheres it moves all others, and solves μ_hh·W_h = −(twist of the held spheres
without it).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nrchain._addresses import address_of, carray, floats_at
from nrchain._compile import kernel

if TYPE_CHECKING:
    from nrchain.hydrodynamics.friction import PairFriction
    from nrchain.scene.scene import Scene


@kernel
def divide(twists, translational, rotational):
    """(F, T) → (F/γ_T, T/γ_R) (N, 6), in place."""
    for i in range(twists.shape[0]):
        for k in range(3):
            twists[i, k] /= translational
            twists[i, 3 + k] /= rotational


@kernel
def divide_blocks(blocks, translational, rotational):
    """Rows of forces over γ_T, rows of torques over γ_R, in place."""
    rows = carray(floats_at(address_of(blocks)), (blocks.shape[0] * blocks.shape[1], 36))
    for block in range(rows.shape[0]):
        for k in range(18):
            rows[block, k] /= translational
        for k in range(18, 36):
            rows[block, k] /= rotational


class Mobility:
    """(v, ω) = μ·(F, T) of all spheres of a scene, and its derivative.

    Parameters
    ----------
    scene
        Gives the drag of a sphere, the kind of friction and its reach.
    held
        (N,) booleans: the clamped spheres.
    carries_wrenches
        Whether wrenches act. Without wrenches and clamps there is no friction between spheres.

    Attributes
    ----------
    pairs
        Friction between spheres; None with one-body friction.
    """

    def __init__(self, scene: Scene, held: np.ndarray, carries_wrenches: bool) -> None:
        self._chain, self._friction, self._drag = scene.chain, scene.friction, scene.drag
        self._held, self._period = held, scene.period
        native = self._friction.backend == "native"
        self._accuracy = scene.pair_accuracy if native else 0.0
        neighbours = self._friction.neighbours
        self._reach = neighbours if isinstance(neighbours, int) else None
        self._acts = self._friction.kind != "one-body" and (carries_wrenches or bool(held.any()))
        self.pairs = self._make_pairs()
        # evaluations at other poses leave the point of linearisation as it is
        self._linearised = self._make_pairs()

    def _make_pairs(self) -> PairFriction | None:
        if not self._acts:
            return None
        from nrchain.hydrodynamics.friction import PairFriction

        chain, fluid = self._chain, (self._chain.radius, self._chain.viscosity)
        return PairFriction(chain.particles, self._reach, *fluid, self._period, self._accuracy)

    @property
    def near(self) -> int | None:
        """Neighbours that friction reaches, where its term holds: few, and no clamped spheres."""
        if self.pairs is None:
            return 0
        native = self._friction.backend == "native"
        return None if self._held.any() or not native else self.pairs.near

    def divide(self, wrenches: np.ndarray) -> None:
        """(F, T) → (F/γ_T, T/γ_R) (N, 6), in place: one-body friction."""
        divide(wrenches, *self._drag)

    def divide_blocks(self, blocks: np.ndarray) -> None:
        """blocks (N, 2w + 1, 6, 6): rows of forces over γ_T, rows of torques over γ_R, in place."""
        divide_blocks(blocks, *self._drag)

    def twists(self, positions: np.ndarray, wrenches: np.ndarray) -> np.ndarray:
        """μ·W (N, 6), without the supports of clamped spheres."""
        if self.pairs is None:
            return wrenches / np.repeat(self._drag, 3)
        twists = np.zeros_like(wrenches)
        self.apply(positions, wrenches, twists)
        return twists

    def apply(self, positions: np.ndarray, wrenches: np.ndarray, twists: np.ndarray) -> None:
        """twists (N, 6) += μ·W with friction between spheres, by the backend of the scene."""
        assert self.pairs is not None
        if self._friction.backend == "native":
            self.pairs.apply(positions, wrenches, twists)
            return
        from nrchain.hydrodynamics import pystokes_backend

        twists += pystokes_backend.mobility(
            positions,
            wrenches,
            neighbours=self._friction.neighbours,
            radius=self._chain.radius,
            viscosity=self._chain.viscosity,
        )

    def move(self, positions: np.ndarray, wrenches: np.ndarray, twists: np.ndarray) -> np.ndarray:
        """twists (N, 6) += μ·W with supports; returns W (N, 6) with the support wrenches."""
        wrenches[self._held] = 0.0
        self.apply(positions, wrenches, twists)
        if self._held.any():
            wrenches += self._hold(positions, twists)
        return wrenches

    def _hold(self, positions: np.ndarray, twists: np.ndarray) -> np.ndarray:
        """Bring the held spheres to rest: change ``twists``, and return the supports (N, 6)."""
        support = np.zeros_like(twists)
        support[self._held] = self._support(positions, twists)
        self.apply(positions, support, twists)
        twists[self._held] = 0.0
        return support

    def _support(self, positions: np.ndarray, twists: np.ndarray) -> np.ndarray:
        """W_h (held, 6) with μ_hh·W_h = −twists of the held spheres."""
        from nrchain.hydrodynamics.friction import PairFriction

        held = np.flatnonzero(self._held)
        reach = None if self._reach is None or np.ptp(held) <= self._reach else 0
        pair = PairFriction(len(held), reach, self._chain.radius, self._chain.viscosity)
        mobility = pair.matrix(positions[held])
        return np.linalg.solve(mobility, -twists[held].ravel()).reshape(-1, 6)

    def linearise(self, positions: np.ndarray, wrenches: np.ndarray) -> None:
        """Take the derivative here, for :meth:`add_product`; ``wrenches`` include supports."""
        assert self._linearised is not None
        self._positions = positions.copy()
        self._linearised.apply(positions, wrenches, np.zeros_like(wrenches))

    def add_product(
        self, poses: np.ndarray, wrench_changes: np.ndarray, twists: np.ndarray
    ) -> None:
        """twists (N, 6) += μ·δW + ∂μ·W, with δW the change of the wrenches without supports."""
        if self._linearised is None:
            divide(wrench_changes, *self._drag)
            twists += wrench_changes
            return
        wrench_changes[self._held] = 0.0
        self._linearised.add_product(poses, wrench_changes, twists)
        if self._held.any():
            self._hold(self._positions, twists)
