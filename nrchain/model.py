"""(v, ω) = μ·(F, T) + Σ (u, w): the overdamped motion of exactly the effects a scene names.

A :class:`Model` turns poses into twists and differentiates them. It knows nothing of time, of
charts or of integrators. Slip velocities enter once: they are not multiplied by the mobility again.

A clamped sphere is held by a wrench of its own, whatever it takes. With one-body friction that
wrench moves nobody else, and the sphere's twist is simply zero; with friction between spheres the
support is felt by all, and is found from μ_hh·W_h = −(twist of the held spheres without it).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nrchain._compile import kernel
from nrchain.effects import cosserat
from nrchain.hydrodynamics.pairs import SlipFlow

if TYPE_CHECKING:
    from nrchain.effects.steric import Repulsion
    from nrchain.hydrodynamics.friction import PairFriction
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
        Number of places w along the chain over which :meth:`linearise` gives blocks.
    is_banded
        Whether those blocks are the whole derivative; if not, :meth:`add_product` is.
    """

    def __init__(self, scene: Scene) -> None:
        chain = scene.chain
        self.count = chain.particles
        self.period = chain.particles * chain.spacing if chain.ends == "periodic" else 0.0
        self.held = np.zeros(self.count, bool)
        if chain.ends == "clamped":
            self.held[[0, -1]] = True
        self.moduli = scene.moduli
        self.elastic = any(self.moduli)
        self._isotropic = scene.elasticity.measure == "isotropic"
        self._drag = scene.drag
        self._scene = scene
        self.steric = self._make_repulsion()
        self.slip = self._make_slip()
        self.friction = self._make_friction()
        # what the derivative is taken about stays as it was while twists are evaluated elsewhere
        self._slip_there, self._friction_there = self._make_slip(), self._make_friction()
        slip_reach = (self.slip.near or 1) if self.slip else 0
        self.reach = max(cosserat.REACH if self.elastic else 0, slip_reach, 1)
        slip_is_near = not self.slip or self.slip.reach <= self.reach
        self.is_banded = slip_is_near and self.friction is None and self.steric is None
        if not self.is_banded:
            self._elastic_blocks = np.zeros((self.count, 2 * cosserat.REACH + 1, 6, 6))

    def _make_slip(self) -> SlipFlow:
        slip = self._scene.slip
        return SlipFlow(
            list(slip.modes),
            [np.broadcast_to(mode.strength, self.count) for mode in slip.modes.values()],
            [mode.axis for mode in slip.modes.values()],
            count=self.count,
            reach=self._places(slip.neighbours),
            radius=self._scene.chain.radius,
            period=self.period,
            finite_size=slip.finite_size,
        )

    def _make_friction(self) -> PairFriction | None:
        friction, chain = self._scene.friction, self._scene.chain
        if friction.kind == "one-body":
            return None
        from nrchain.hydrodynamics.friction import PairFriction

        reach = self._places(friction.neighbours)
        return PairFriction(self.count, reach, chain.radius, chain.viscosity, self.period)

    def _make_repulsion(self) -> Repulsion | None:
        steric = self._scene.steric
        if not steric.acts:
            return None
        from nrchain.effects.steric import Repulsion

        assert steric.strength is not None
        return Repulsion(steric.kind, steric.strength, self._scene.steric_range, self.period)

    def _places(self, neighbours: int | str) -> int | None:
        return neighbours if isinstance(neighbours, int) else None

    def twists(
        self, positions: np.ndarray, frames: np.ndarray, out: np.ndarray | None = None
    ) -> np.ndarray:
        """(v, ω) (N, 6) of every sphere in the lab; zero for clamped ones."""
        twists = np.empty((self.count, 6)) if out is None else out
        twists[:] = 0.0
        if self.friction is None:
            self._add_wrenches(positions, frames, twists)
            _divide(twists, *self._drag)
            self.add_slip_twists(positions, frames, twists)
            if self.held.any():
                twists[self.held] = 0.0
            return twists
        self.add_slip_twists(positions, frames, twists)
        self._wrenches(positions, frames, twists)
        return twists

    def _wrenches(
        self, positions: np.ndarray, frames: np.ndarray, twists: np.ndarray
    ) -> np.ndarray:
        """The wrenches (N, 6), supports included; ``twists``, from slip, gain what they cause."""
        assert self.friction is not None
        wrenches = np.zeros((self.count, 6))
        self._add_wrenches(positions, frames, wrenches)
        wrenches[self.held] = 0.0
        self._apply_friction(positions, wrenches, twists)
        if self.held.any():
            support = np.zeros((self.count, 6))
            support[self.held] = self._support(positions, twists)
            self._apply_friction(positions, support, twists)
            twists[self.held] = 0.0
            wrenches += support
        return wrenches

    def _apply_friction(
        self, positions: np.ndarray, wrenches: np.ndarray, twists: np.ndarray
    ) -> None:
        assert self.friction is not None
        if self._scene.friction.backend == "native":
            self.friction.apply(positions, wrenches, twists)
            return
        from nrchain.hydrodynamics import pystokes

        chain = self._scene.chain
        twists += pystokes.mobility(
            positions,
            wrenches,
            neighbours=self._scene.friction.neighbours,
            radius=chain.radius,
            viscosity=chain.viscosity,
        )

    def _support(self, positions: np.ndarray, twists: np.ndarray) -> np.ndarray:
        """Wrenches (held, 6) that bring the twists of the held spheres to rest."""
        from nrchain.hydrodynamics.friction import PairFriction

        chain, friction = self._scene.chain, self._scene.friction
        held = np.flatnonzero(self.held)
        places = self._places(friction.neighbours)
        reach = None if places is None or np.ptp(held) <= places else 0
        pair = PairFriction(len(held), reach, chain.radius, chain.viscosity)
        mobility = pair.matrix(positions[held])
        return np.linalg.solve(mobility, -twists[held].ravel()).reshape(-1, 6)

    def _add_wrenches(
        self, positions: np.ndarray, frames: np.ndarray, wrenches: np.ndarray
    ) -> None:
        """wrenches += (F, T) of elasticity and repulsion."""
        if self.elastic:
            cosserat.add_wrenches(
                positions,
                frames,
                self._scene.chain.spacing,
                self.period,
                *self.moduli,
                wrenches,
                self._isotropic,
            )
        if self.steric is not None:
            self.steric.add_wrenches(positions, wrenches)

    def add_slip_twists(
        self, positions: np.ndarray, frames: np.ndarray, twists: np.ndarray
    ) -> None:
        """twists += the flow and half its curl that the slip of the other spheres induces."""
        if not self.slip:
            return
        if self._scene.slip.backend == "native":
            self.slip.add_twists(positions, frames, twists)
            return
        from nrchain.hydrodynamics import pystokes

        law = self.slip.law
        velocities, spins = pystokes.twists(
            positions,
            [np.einsum("b,nbk->nk", np.array(law.axes[g]), frames) for g in law.axis_of],
            list(self.slip.strengths),
            neighbours=self._scene.slip.neighbours,
            radius=self.slip.radius,
            viscosity=self._scene.chain.viscosity,
            finite_size=law.finite_size,
            labels=law.labels,
        )
        twists[:, :3] += velocities
        twists[:, 3:] += spins

    def linearise(self, positions: np.ndarray, frames: np.ndarray, blocks: np.ndarray) -> None:
        """blocks (N, 2w + 1, 6, 6) = ∂(v, ω)_i / ∂(u, φ)_{i+m−w} at these poses.

        u displaces and φ turns a sphere in the lab. The blocks are the whole derivative if
        :attr:`is_banded`. If not they are its stiff part, for preconditioning: elasticity and
        repulsion through one-body friction, and the slip of the spheres within w places.
        """
        blocks[:] = 0.0
        if self.elastic:
            cosserat.add_jacobian(
                positions,
                frames,
                self._scene.chain.spacing,
                self.period,
                *self.moduli,
                blocks,
                self._isotropic,
            )
            if not self.is_banded:
                centre = self.reach
                near = slice(centre - cosserat.REACH, centre + cosserat.REACH + 1)
                self._elastic_blocks[:] = blocks[:, near]
        if self.steric is not None:
            self.steric.linearise(positions)
            self.steric.add_blocks(blocks)
        _divide_blocks(blocks, *self._drag)
        if self.slip:
            self._slip_there.add_jacobian(positions, frames, blocks)
        if self._friction_there is not None:
            twists = np.zeros((self.count, 6))
            self.add_slip_twists(positions, frames, twists)
            wrenches = self._wrenches(positions, frames, twists)
            self._positions_there = positions.copy()
            self._friction_there.apply(positions, wrenches, np.zeros((self.count, 6)))

    def add_product(self, poses: np.ndarray, twists: np.ndarray) -> None:
        """twists += the change of the twists with ``poses`` (N, 6), about the last linearisation.

        ``poses`` is (u, φ) of every sphere, zero where it is held.
        """
        if self.slip:
            self._slip_there.add_product(poses, twists)
        if self._friction_there is None:
            changes = np.zeros((self.count, 6))
            self._add_wrench_product(poses, changes)
            _divide(changes, *self._drag)
            twists += changes
            return
        wrenches = np.zeros((self.count, 6))
        self._add_wrench_product(poses, wrenches)
        wrenches[self.held] = 0.0
        self._friction_there.add_product(poses, wrenches, twists)
        if self.held.any():
            support = np.zeros((self.count, 6))
            support[self.held] = self._support(self._positions_there, twists)
            self._apply_friction(self._positions_there, support, twists)
            twists[self.held] = 0.0

    def _add_wrench_product(self, poses: np.ndarray, wrenches: np.ndarray) -> None:
        if self.elastic:
            cosserat.add_block_product(self._elastic_blocks, poses, self.period > 0.0, wrenches)
        if self.steric is not None:
            self.steric.add_product(poses, wrenches)
