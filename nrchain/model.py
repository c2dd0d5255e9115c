"""v = F/γ_T + Σ u, ω = T/γ_R + Σ w: the overdamped motion of exactly the effects a scene names.

A :class:`Model` turns poses into twists, and gives the derivative of the twists with the poses:
blocks between spheres near each other along the chain, and a product for what lies beyond. It
knows nothing of time, of charts or of integrators.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nrchain._compile import kernel
from nrchain.effects import cosserat
from nrchain.hydrodynamics.pairs import SlipFlow

if TYPE_CHECKING:
    from nrchain.scene import Scene


@kernel
def _divide(twists, translational, rotational):
    for i in range(twists.shape[0]):
        for k in range(3):
            twists[i, k] /= translational
            twists[i, 3 + k] /= rotational


@kernel
def _divide_blocks(blocks, translational, rotational):
    for i in range(blocks.shape[0]):
        for m in range(blocks.shape[1]):
            for k in range(6):
                for row in range(3):
                    blocks[i, m, row, k] /= translational
                    blocks[i, m, 3 + row, k] /= rotational


class Model:
    """Twists of all spheres and their derivatives, for the effects of a scene.

    Attributes
    ----------
    count
        Number of spheres N.
    period
        Length after which a periodic chain repeats along x; 0 for open chains.
    held
        (N,) booleans: the spheres whose pose is clamped.
    reach
        Number of places w along the chain over which :meth:`add_jacobian` gives exact blocks.
    has_far
        Whether anything acts beyond those places, through :meth:`add_far_product`.
    """

    def __init__(self, scene: Scene) -> None:
        chain, slip = scene.chain, scene.slip
        self.count = chain.particles
        self.period = chain.particles * chain.spacing if chain.ends == "periodic" else 0.0
        self.held = np.zeros(self.count, bool)
        if chain.ends == "clamped":
            self.held[[0, -1]] = True
        self.moduli = scene.moduli
        self._isotropic = scene.elasticity.measure == "isotropic"
        self.translational, self.rotational = scene.friction
        self._spacing = chain.spacing
        self.slip = SlipFlow(
            list(slip.modes),
            [np.broadcast_to(mode.strength, self.count) for mode in slip.modes.values()],
            [mode.axis for mode in slip.modes.values()],
            count=self.count,
            reach=self.count - 1 if slip.neighbours == "all" else slip.neighbours,
            radius=chain.radius,
            period=self.period,
            finite_size=slip.finite_size,
        )
        self._pystokes = slip.backend == "pystokes"
        self._viscosity = chain.viscosity
        self._neighbours = slip.neighbours
        self.elastic = any(self.moduli)
        elastic_reach = cosserat.REACH if self.elastic else 0
        slip_reach = (self.slip.near or 1) if self.slip else 0
        self.reach = max(elastic_reach, slip_reach, 1)
        self.has_far = bool(self.slip) and self.slip.reach > self.reach

    def twists(
        self, positions: np.ndarray, frames: np.ndarray, out: np.ndarray | None = None
    ) -> np.ndarray:
        """(v, ω) (N, 6) of every sphere in the lab; zero for clamped ones."""
        twists = np.empty((self.count, 6)) if out is None else out
        twists[:] = 0.0
        if self.elastic:
            cosserat.add_wrenches(
                positions,
                frames,
                self._spacing,
                self.period,
                *self.moduli,
                twists,
                self._isotropic,
            )
            _divide(twists, self.translational, self.rotational)
        self.add_slip_twists(positions, frames, twists)
        if self.held.any():
            twists[self.held] = 0.0
        return twists

    def add_slip_twists(
        self, positions: np.ndarray, frames: np.ndarray, twists: np.ndarray
    ) -> None:
        """twists += the flow and half its curl that the slip of the other spheres induces."""
        if not self.slip:
            return
        if not self._pystokes:
            self.slip.add_twists(positions, frames, twists)
            return
        from nrchain.hydrodynamics import pystokes

        law = self.slip.law
        velocities, spins = pystokes.twists(
            positions,
            [np.einsum("b,nbk->nk", np.array(law.axes[g]), frames) for g in law.axis_of],
            list(self.slip.strengths),
            neighbours=self._neighbours,
            radius=self.slip.radius,
            viscosity=self._viscosity,
            finite_size=law.finite_size,
            labels=law.labels,
        )
        twists[:, :3] += velocities
        twists[:, 3:] += spins

    def add_jacobian(self, positions: np.ndarray, frames: np.ndarray, blocks: np.ndarray) -> None:
        """blocks (N, 2w + 1, 6, 6) += ∂(v, ω)_i / ∂(u, φ)_{i+m−w}, lab displacement and rotation.

        Pairs further apart than w are left to :meth:`add_far_product`, also where they change a
        sphere's own block.
        """
        if self.elastic:
            cosserat.add_jacobian(
                positions,
                frames,
                self._spacing,
                self.period,
                *self.moduli,
                blocks,
                self._isotropic,
            )
            _divide_blocks(blocks, self.translational, self.rotational)
        if self.slip:
            self.slip.add_jacobian(positions, frames, blocks)

    def add_far_product(self, poses: np.ndarray, twists: np.ndarray) -> None:
        """twists += the change of the twists with ``poses`` (N, 6) through pairs beyond the blocks.

        About the poses last passed to :meth:`add_jacobian`.
        """
        self.slip.add_product(poses, self.reach, twists)
