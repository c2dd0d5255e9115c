"""(v, ω) = μ·(F, T) + Σ (u, w): the overdamped motion of exactly the effects a scene names.

One pass over the links sums the terms of the elastic energy, and one pass over the pairs sums the
modes of slip. Every further effect that acts adds its own wrench or twist
(:mod:`nrchain.effects.base`). Friction turns wrenches into twists (:mod:`nrchain.motion.mobility`).
Slip velocities are twists already: the mobility does not multiply them again.

A :class:`Model` turns poses into twists and differentiates them. It does not know time, charts or
integrators.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from nrchain.effects.registry import acting
from nrchain.effects.shared.elasticity import elasticity_of
from nrchain.effects.shared.slip_flow import make_flow
from nrchain.motion.mobility import Mobility
from nrchain.potential.chain import REACH
from nrchain.potential.link import add_block_product

if TYPE_CHECKING:
    from nrchain.hydrodynamics.pairs import SlipFlow
    from nrchain.scene.scene import Scene


class Model:
    """(v, ω) of all spheres and its derivative, for the effects of a scene.

    Attributes
    ----------
    count
        Number of spheres N.
    period
        Length after which a periodic chain repeats along x; 0 for open chains.
    held
        (N,) booleans: the spheres whose pose is clamped.
    reach
        Number of neighbours w on either side for which :meth:`linearise` gives blocks.
    is_banded
        Whether those blocks are the whole derivative. If not, use :meth:`add_product`.
    is_near
        Whether terms by address give the whole derivative: interactions of near neighbours, with
        blocks of ``near_reach`` neighbours, and of spheres that touch.
    near_reach, wrench_reach
        Number of neighbours on either side that change twists, and that change wrenches, if
        ``is_near``.
    needs_places
        Whether an effect depends on absolute positions in the lab.
    ties_frames
        Whether an effect other than slip, fields and flows exerts torques, as elasticity does.
    friction
        Friction between spheres; None with one-body friction.
    drag
        γ_T and γ_R, of one sphere.
    further_effects
        Those that are not summed with others in one pass.
    """

    def __init__(self, scene: Scene) -> None:
        chain = scene.chain
        self.count = chain.particles
        self.period = scene.period
        self.held = np.zeros(self.count, bool)
        if chain.ends == "clamped":
            self.held[[0, -1]] = True
        self.elasticity = elasticity_of(scene)
        self.drag = scene.drag
        self.effects = acting(scene)
        further = [effect(scene) for effect in self.effects if not effect.fused]
        self.further_effects = tuple(further)
        self._wrench_effects = [effect for effect in further if effect.gives == "wrench"]
        self._twist_effects = [effect for effect in further if effect.gives == "twist"]
        wrenches = [effect for effect in self.effects if effect.gives == "wrench"]
        self._mobility = Mobility(scene, self.held, bool(wrenches))
        self.friction = self._mobility.pairs
        self.slip = make_flow(scene)
        self._scene = scene
        slip_reach = (self.slip.near or 1) if self.slip else 0
        places = [effect.places for effect in further]
        self.reach = max(
            REACH if self.elasticity else 0, slip_reach, *(p for p in places if p is not None), 1
        )
        self.ties_frames = not all(effect.carries or effect.torque_free for effect in wrenches)
        self.needs_places = any(effect.placed for effect in further)
        slip_is_near = not self.slip or self.slip.reach <= self.reach
        given = [effect.places for effect in self._wrench_effects if effect.places is not None]
        self.wrench_reach = max(REACH if self.elasticity else 0, *given, 0)
        friction_reach, touching = self._mobility.near, None in places
        self.is_near = slip_is_near and all(
            effect.places is not None or (effect.whole_term and self.friction is None)
            for effect in further
        )
        self.is_near &= friction_reach is not None
        through_friction = self.wrench_reach + (friction_reach or 0)
        self.near_reach = max(self.reach, through_friction) if self.is_near else self.reach
        self.is_banded = self.is_near and self.friction is None and not touching
        if not self.is_banded:
            self._elastic_blocks = np.zeros((self.count, 2 * REACH + 1, 6, 6))

    @cached_property
    def _linearised_slip(self) -> SlipFlow:
        """A flow of its own: evaluations at other poses leave the point of linearisation."""
        return make_flow(self._scene)

    def twists(
        self, positions: np.ndarray, frames: np.ndarray, out: np.ndarray | None = None
    ) -> np.ndarray:
        """(v, ω) (N, 6) of every sphere in the lab; zero for clamped spheres."""
        twists = np.empty((self.count, 6)) if out is None else out
        twists[:] = 0.0
        if self.friction is None:
            self._add_wrenches(positions, frames, twists)
            self._mobility.divide(twists)
            self._add_flows(positions, frames, twists)
            if self.held.any():
                twists[self.held] = 0.0
            return twists
        self._add_flows(positions, frames, twists)
        self._move(positions, frames, twists)
        return twists

    def wrenches(self, positions: np.ndarray, frames: np.ndarray) -> np.ndarray:
        """(F, T) (N, 6) on every sphere, with the supports of clamped spheres."""
        twists = np.zeros((self.count, 6))
        self._add_flows(positions, frames, twists)
        if self.friction is not None:
            return self._move(positions, frames, twists)
        wrenches = np.zeros((self.count, 6))
        self._add_wrenches(positions, frames, wrenches)
        wrenches[self.held] = -np.repeat(self.drag, 3) * twists[self.held]
        return wrenches

    def mobile_twists(self, positions: np.ndarray, wrenches: np.ndarray) -> np.ndarray:
        """μ·W (N, 6): the twists of given wrenches, without the supports of clamped spheres."""
        return self._mobility.twists(positions, wrenches)

    def _move(self, positions: np.ndarray, frames: np.ndarray, twists: np.ndarray) -> np.ndarray:
        """twists += μ·(F, T) with friction between spheres; returns (F, T) with supports."""
        wrenches = np.zeros((self.count, 6))
        self._add_wrenches(positions, frames, wrenches)
        return self._mobility.move(positions, wrenches, twists)

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
        """twists += (u, ½ curl u) of the flows that the slip of the other spheres induces."""
        self.slip.add_twists(positions, frames, twists)

    def carrying_twists(self, positions: np.ndarray, frames: np.ndarray) -> np.ndarray:
        """(v, ω) (N, 6) of slip, fields and flows, which may move the chain as a whole.

        Elastic forces sum to zero over the chain; they are left out, with their fast transients.
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
            self._mobility.apply(positions, wrenches, twists)
        elif carriers:
            self._mobility.divide(wrenches)
            twists += wrenches
        return twists

    def linearise(self, positions: np.ndarray, frames: np.ndarray, blocks: np.ndarray) -> None:
        """blocks (N, 2w + 1, 6, 6) = ∂(v, ω)_i / ∂(u, φ)_{i+m−w} at these poses.

        u displaces and φ rotates a sphere in the lab. The blocks are the whole derivative if
        :attr:`is_banded`. Otherwise they are its stiff part, for preconditioning: wrenches through
        one-body friction, and the flows of up to w neighbours on either side.
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
        self._mobility.divide_blocks(blocks)
        self.linearise_slip(positions, frames, blocks)
        for effect in self._twist_effects:
            effect.add_blocks(blocks)
        if self.friction is not None:
            twists = np.zeros((self.count, 6))
            self._add_flows(positions, frames, twists)
            self._mobility.linearise(positions, self._move(positions, frames, twists))

    def linearise_slip(self, positions: np.ndarray, frames: np.ndarray, blocks: np.ndarray) -> None:
        """Take the derivative of slip here; blocks += that of near neighbours."""
        self._linearised_slip.add_jacobian(positions, frames, blocks)

    @property
    def has_pair_blocks(self) -> bool:
        """Whether :meth:`far_blocks` holds all that :meth:`linearise` leaves out: slip alone."""
        near = all(effect.places is not None for effect in self.further_effects)
        return near and self.friction is None and not self.period

    def far_blocks(self, positions: np.ndarray, frames: np.ndarray) -> np.ndarray:
        """(N, 2N − 1, 6, 6): ∂(v, ω)_i / ∂(u, φ)_{i+m−N+1} less the blocks of :meth:`linearise`."""
        flow, reach, count = self._linearised_slip, self.reach, self.count
        blocks = np.zeros((count, 2 * count - 1, 6, 6))
        near = np.zeros((count, 2 * reach + 1, 6, 6))
        flow.add_jacobian(positions, frames, blocks)
        flow.add_jacobian(positions, frames, near)
        width = min(reach, count - 1)
        blocks[:, count - 1 - width : count + width] -= near[:, reach - width : reach + width + 1]
        return blocks

    def add_product(self, poses: np.ndarray, twists: np.ndarray) -> None:
        """twists += the change of the twists with ``poses`` (N, 6), about the last linearisation.

        ``poses`` is (u, φ) of every sphere, zero for held spheres.
        """
        self._linearised_slip.add_product(poses, twists)
        for effect in self._twist_effects:
            effect.add_product(poses, twists)
        changes = np.zeros((self.count, 6))
        if self.elasticity:
            add_block_product(self._elastic_blocks, poses, self.period > 0.0, changes)
        for effect in self._wrench_effects:
            effect.add_product(poses, changes)
        self._mobility.add_product(poses, changes, twists)
