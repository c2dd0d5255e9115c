"""(v, ω) = μ·(F, T) + Σ (u, w): the overdamped motion of exactly the effects a scene names.

The terms of the elastic energy are summed in one pass over the links, the modes of slip in one over
the pairs; every further effect that acts adds its own wrench or twist
(:mod:`nrchain.effects.base`). An effect that does not act is not there.

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
from nrchain.effects.elasticity import elasticity_of
from nrchain.effects.registry import acting
from nrchain.effects.slip import make_flow
from nrchain.potential.chain import REACH
from nrchain.potential.link import add_block_product

if TYPE_CHECKING:
    from nrchain.hydrodynamics.friction import PairFriction
    from nrchain.scene.scene import Scene


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
    needs_places
        Whether anything that acts depends on where in the lab the chain is.
    ties_frames
        Whether anything but slip, fields and flows turns spheres, as elasticity does.
    """

    def __init__(self, scene: Scene) -> None:
        chain = scene.chain
        self.count = chain.particles
        self.period = chain.particles * chain.spacing if chain.ends == "periodic" else 0.0
        self.held = np.zeros(self.count, bool)
        if chain.ends == "clamped":
            self.held[[0, -1]] = True
        self.elasticity = elasticity_of(scene)
        self._drag = scene.drag
        self._scene = scene
        self.effects = acting(scene)
        further = [effect(scene) for effect in self.effects if not effect.fused]
        self._wrench_effects = [effect for effect in further if effect.gives == "wrench"]
        self._twist_effects = [effect for effect in further if effect.gives == "twist"]
        self.slip = make_flow(scene)
        self.friction = self._make_friction()
        # what the derivative is taken about stays as it was while twists are evaluated elsewhere
        self._slip_there, self._friction_there = make_flow(scene), self._make_friction()
        slip_reach = (self.slip.near or 1) if self.slip else 0
        places = [effect.places for effect in further]
        self.reach = max(
            REACH if self.elasticity else 0, slip_reach, *(p for p in places if p is not None), 1
        )
        wrenches = (effect for effect in self.effects if effect.gives == "wrench")
        self.ties_frames = not all(effect.carries or effect.torque_free for effect in wrenches)
        self.needs_places = any(effect.placed for effect in further)
        slip_is_near = not self.slip or self.slip.reach <= self.reach
        self.is_banded = slip_is_near and self.friction is None and None not in places
        if not self.is_banded:
            self._elastic_blocks = np.zeros((self.count, 2 * REACH + 1, 6, 6))

    def _make_friction(self) -> PairFriction | None:
        """Friction between spheres, where there are wrenches for it to carry."""
        friction, chain = self._scene.friction, self._scene.chain
        wrenches = any(effect.gives == "wrench" for effect in self.effects)
        if friction.kind == "one-body" or not (wrenches or self.held.any()):
            return None
        from nrchain.hydrodynamics.friction import PairFriction

        reach = self._places(friction.neighbours)
        return PairFriction(self.count, reach, chain.radius, chain.viscosity, self.period)

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
            self._add_flows(positions, frames, twists)
            if self.held.any():
                twists[self.held] = 0.0
            return twists
        self._add_flows(positions, frames, twists)
        self._wrenches(positions, frames, twists)
        return twists

    def wrenches(self, positions: np.ndarray, frames: np.ndarray) -> np.ndarray:
        """(F, T) (N, 6) on every sphere, with those that hold clamped ones in their place."""
        twists = np.zeros((self.count, 6))
        self._add_flows(positions, frames, twists)
        if self.friction is not None:
            return self._wrenches(positions, frames, twists)
        wrenches = np.zeros((self.count, 6))
        self._add_wrenches(positions, frames, wrenches)
        wrenches[self.held] = -np.repeat(self._drag, 3) * twists[self.held]
        return wrenches

    def mobile_twists(self, positions: np.ndarray, wrenches: np.ndarray) -> np.ndarray:
        """μ·W (N, 6): the twists that these wrenches give, clamps or not."""
        if self.friction is None:
            return wrenches / np.repeat(self._drag, 3)
        twists = np.zeros((self.count, 6))
        self._apply_friction(positions, wrenches, twists)
        return twists

    def _wrenches(
        self, positions: np.ndarray, frames: np.ndarray, twists: np.ndarray
    ) -> np.ndarray:
        """The wrenches (N, 6), supports included; ``twists``, from flows, gain what they cause."""
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
        from nrchain.hydrodynamics import pystokes_backend

        chain = self._scene.chain
        twists += pystokes_backend.mobility(
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
        """wrenches += (F, T) of elasticity and of all further effects."""
        self.elasticity.add_wrenches(positions, frames, wrenches)
        for effect in self._wrench_effects:
            effect.add_wrenches(positions, frames, wrenches)

    def _add_flows(self, positions: np.ndarray, frames: np.ndarray, twists: np.ndarray) -> None:
        """twists += (v, ω) of slip and of all further effects."""
        self.add_slip_twists(positions, frames, twists)
        for effect in self._twist_effects:
            effect.add_twists(positions, frames, twists)

    def add_slip_twists(
        self, positions: np.ndarray, frames: np.ndarray, twists: np.ndarray
    ) -> None:
        """twists += the flow and half its curl that the slip of the other spheres induces."""
        self.slip.add_twists(positions, frames, twists)

    def carrying_twists(self, positions: np.ndarray, frames: np.ndarray) -> np.ndarray:
        """Twists (N, 6) of the effects that may carry the chain as a whole: slip, fields, flows.

        Elasticity sums to nothing over the chain, and is left out with its fast transients.
        """
        twists, wrenches = np.zeros((2, self.count, 6))
        self.add_slip_twists(positions, frames, twists)
        for effect in self._twist_effects:
            if effect.carries:
                effect.add_twists(positions, frames, twists)
        carriers = [effect for effect in self._wrench_effects if effect.carries]
        for effect in carriers:
            effect.add_wrenches(positions, frames, wrenches)
        if carriers and self.friction is not None:
            self._apply_friction(positions, wrenches, twists)
        elif carriers:
            _divide(wrenches, *self._drag)
            twists += wrenches
        return twists

    def linearise(self, positions: np.ndarray, frames: np.ndarray, blocks: np.ndarray) -> None:
        """blocks (N, 2w + 1, 6, 6) = ∂(v, ω)_i / ∂(u, φ)_{i+m−w} at these poses.

        u displaces and φ turns a sphere in the lab. The blocks are the whole derivative if
        :attr:`is_banded`. If not they are its stiff part, for preconditioning: wrenches through
        one-body friction, and the flows of the spheres within w places.
        """
        blocks[:] = 0.0
        self.elasticity.add_jacobian(positions, frames, blocks)
        if not self.is_banded and self.elasticity:
            near = slice(self.reach - REACH, self.reach + REACH + 1)
            self._elastic_blocks[:] = blocks[:, near]
        for effect in (*self._wrench_effects, *self._twist_effects):
            effect.linearise(positions, frames)
        for effect in self._wrench_effects:
            effect.add_blocks(blocks)
        _divide_blocks(blocks, *self._drag)
        self._slip_there.add_jacobian(positions, frames, blocks)
        for effect in self._twist_effects:
            effect.add_blocks(blocks)
        if self._friction_there is not None:
            twists = np.zeros((self.count, 6))
            self._add_flows(positions, frames, twists)
            wrenches = self._wrenches(positions, frames, twists)
            self._positions_there = positions.copy()
            self._friction_there.apply(positions, wrenches, np.zeros((self.count, 6)))

    def add_product(self, poses: np.ndarray, twists: np.ndarray) -> None:
        """twists += the change of the twists with ``poses`` (N, 6), about the last linearisation.

        ``poses`` is (u, φ) of every sphere, zero where it is held.
        """
        self._slip_there.add_product(poses, twists)
        for effect in self._twist_effects:
            effect.add_product(poses, twists)
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
        if self.elasticity:
            add_block_product(self._elastic_blocks, poses, self.period > 0.0, wrenches)
        for effect in self._wrench_effects:
            effect.add_product(poses, wrenches)
