"""G(X) = w(X) − g(X): the twists of a chain less its motion as a whole, and their derivative J.

w are the twists of the spheres and g the motion of the chain as a whole that fits them best
(:mod:`nrchain.comoving.motions`). A chain is in a state of rest or of steady motion where G = 0.
There J = ∂G/∂(u, φ) at fixed V, Ω, s is the matrix of small changes in axes that go along with the
chain:

    J = ∂w/∂(u, φ) − [Ω×] on u, + s [e₁×] on φ.

Coordinates. u displaces and φ rotates each sphere in the lab. Rotations are multiplied by the
length ρ = √(γ_R/γ_T) = 2a/√3, so that the euclidean norm of a vector of coordinates is

    ‖(u, φ)‖² = Σ_i |u_i|² + ρ² |φ_i|².

In this norm J of a passive chain with one-body friction is symmetric. Held spheres have no
coordinates. The motions that the scene allows span a space that J maps to itself; Q is an
orthonormal basis of it, and what is orthogonal to Q changes the shape.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from nrchain.comoving.motions import INDEPENDENT, TURN, Motion, allowed_motions, fields, moved
from nrchain.effects.base import cross_matrix
from nrchain.motion.model import Model
from nrchain.scene.scene import Scene
from nrchain.theory.line_loads import from_blocks
from nrchain.types import Poses

VANISHING = 1e-9
"""Motions that move every sphere by less than this fraction of ρ are none."""

DENSE = 500
"""Spheres of the longest chain whose interactions of all pairs are kept as a matrix."""

Product = Callable[[np.ndarray], np.ndarray]


class RelativeChain:
    """The twists of a scene less the motion of the chain as a whole, at any poses.

    Attributes
    ----------
    free
        Indices of the spheres that are not held.
    units
        (n,) of each coordinate: 1 for displacements, ρ for rotations.
    dimension
        n = 6 · number of free spheres.
    origin
        o (3,), about which the chain rotates: by default the mean position of the held spheres, or
        of all.
    """

    def __init__(self, scene: Scene, poses: Poses, origin: np.ndarray | None = None) -> None:
        self.scene, self.model = scene, Model(scene)
        held = self.model.held
        self.free = np.flatnonzero(~held)
        self.dimension = 6 * len(self.free)
        self.length = math.sqrt(scene.drag.rotation / scene.drag.translation)
        self.units = np.tile(np.repeat([1.0, self.length], 3), len(self.free))
        self.origin = origin_of(self.model, poses[0]) if origin is None else origin
        self.allowed = allowed_motions(scene, self.model, poses, self.origin, self.length)
        # the point about which the model was linearised last
        self.linearised: Point | None = None

    def at(self, poses: Poses, elementary: np.ndarray | None = None) -> Point:
        """G at these poses, with the motion that fits best or the given rates (7,)."""
        return Point(self, *poses, elementary)

    def columns(self, positions: np.ndarray, frames: np.ndarray) -> np.ndarray:
        """(n, 7): the elementary motions of the chain as a whole, in coordinates."""
        elementary = fields(positions, frames, self.origin, self.length)
        return np.stack([self.coordinates(one) for one in elementary], axis=1)

    def motion(self, elementary: np.ndarray) -> Motion:
        """V, Ω and s of rates (7,) of the elementary motions."""
        velocity, rotation = elementary[:3] * self.length, elementary[3:TURN]
        return Motion(velocity, rotation, float(elementary[TURN]))

    def coordinates(self, twists: np.ndarray) -> np.ndarray:
        """(n,) of (u, φ) or (v, ω) (N, 6) of the free spheres, rotations times ρ."""
        return twists[self.free].ravel() * self.units

    def poses(self, vector: np.ndarray) -> np.ndarray:
        """(u, φ) (N, 6) of coordinates (n,), zero for held spheres; real or complex."""
        poses = np.zeros((self.model.count, 6), vector.dtype)
        poses[self.free] = (vector / self.units).reshape(-1, 6)
        return poses


def origin_of(model: Model, positions: np.ndarray) -> np.ndarray:
    """o (3,): the mean position of the held spheres, or of all."""
    held = model.held
    return positions[held].mean(axis=0) if held.any() else positions.mean(axis=0)


class Point:
    """G, Q and J at one pose of the chain.

    Attributes
    ----------
    residual
        G (n,), in coordinates.
    elementary, motion
        g, as rates (7,) of the elementary motions and as :class:`~nrchain.comoving.motions.Motion`:
        the one that fits best, unless rates are given.
    columns
        (n, 7), the elementary motions.
    """

    def __init__(
        self,
        chain: RelativeChain,
        positions: np.ndarray,
        frames: np.ndarray,
        elementary: np.ndarray | None = None,
    ) -> None:
        self.chain, self.positions, self.frames = chain, positions, frames
        self.columns = chain.columns(positions, frames)
        twists = chain.coordinates(chain.model.twists(positions, frames))
        if not np.isfinite(twists).all():
            raise FloatingPointError("velocities leave the range of floats")
        if elementary is None:
            combinations = self._combinations
            along = self.neutral.T @ twists
            self.elementary = combinations @ along
            self.residual = twists - self.neutral @ along
        else:
            self.elementary = elementary
            self.residual = twists - self.columns @ elementary
        self.motion = chain.motion(self.elementary)

    @property
    def neutral(self) -> np.ndarray:
        """Q (n, r)."""
        return self._neutral[0]

    @property
    def _combinations(self) -> np.ndarray:
        """(7, r): Q = columns · combinations."""
        return self._neutral[1]

    @cached_property
    def _neutral(self) -> tuple[np.ndarray, np.ndarray]:
        return orthonormal_motions(self.columns, self.chain.allowed, self.chain.length)

    @property
    def poses(self) -> Poses:
        """Positions (N, 3) and frames (N, 3, 3)."""
        return self.positions, self.frames

    def moved(self, vector: np.ndarray) -> Point:
        """G at the poses changed by coordinates (n,)."""
        return self.chain.at(moved(*self.poses, self.chain.poses(vector)))

    @cached_property
    def near(self) -> Any:
        """J as a sparse matrix (n, n) of near neighbours: all of J if :attr:`is_banded`."""
        chain, model = self.chain, self.chain.model
        blocks = self._linearise()
        blocks[:, model.reach] += self._turning
        ratio = np.repeat([1.0, chain.length], 3)
        blocks *= ratio[:, None] / ratio
        matrix = from_blocks(blocks, periodic=model.period > 0.0)
        if not model.held.any():
            return matrix
        kept = np.ravel(6 * chain.free[:, None] + np.arange(6))
        return matrix[kept][:, kept].tocsc()

    def _linearise(self) -> np.ndarray:
        """Take the derivative of the model here; returns its blocks (N, 2w + 1, 6, 6)."""
        model = self.chain.model
        blocks = np.empty((model.count, 2 * model.reach + 1, 6, 6))
        model.linearise(self.positions, self.frames, blocks)
        self.chain.linearised = self
        return blocks

    @property
    def is_banded(self) -> bool:
        """Whether interactions of near neighbours are all there are."""
        return self.chain.model.is_banded

    @cached_property
    def matrix(self) -> Any:
        """J, sparse for near neighbours and dense for all pairs; None for too many spheres."""
        near = self.near
        if self.is_banded:
            return near
        if self.chain.model.count > DENSE:
            return None
        if self.chain.model.has_pair_blocks:
            return near.toarray() + self._far()
        columns = np.empty((self.chain.dimension,) * 2)
        for unit, column in zip(np.eye(self.chain.dimension), columns, strict=True):
            column[:] = self._product(unit)
        return columns.T

    @property
    def has_blocks(self) -> bool:
        """Whether blocks of pairs give :attr:`matrix`, at the cost of a few products."""
        model = self.chain.model
        return self.is_banded or (model.has_pair_blocks and model.count <= DENSE)

    def _far(self) -> np.ndarray:
        """J (n, n) less :attr:`near`."""
        chain, count = self.chain, self.chain.model.count
        ratio = np.repeat([1.0, chain.length], 3)
        blocks = chain.model.far_blocks(*self.poses) * (ratio[:, None] / ratio)
        whole = np.empty((count, 6, count, 6))
        for i, own in enumerate(blocks):
            whole[i] = own[count - 1 - i : 2 * count - 1 - i].swapaxes(0, 1)
        free = chain.free
        return whole[free][:, :, free].reshape(chain.dimension, chain.dimension)

    def product(self, vector: np.ndarray) -> np.ndarray:
        """J · vector (n,) or (n, k), real or complex.

        A matrix of all pairs is used if there is one already, and not made for a product.
        """
        if self.is_banded or vars(self).get("matrix") is not None:
            return self.matrix @ vector
        if vector.ndim == 2:
            return np.stack([self.product(column) for column in vector.T], axis=1)
        if np.iscomplexobj(vector):
            return self._product(vector.real.copy()) + 1j * self._product(vector.imag.copy())
        return self._product(vector)

    def _product(self, vector: np.ndarray) -> np.ndarray:
        """J · vector with all pairs."""
        if self.chain.linearised is not self:
            self._linearise()
        poses = self.chain.poses(vector)
        twists = np.einsum("npq,nq->np", self._turning, poses)
        self.chain.model.add_product(poses, twists)
        return self.chain.coordinates(twists)

    @cached_property
    def _turning(self) -> np.ndarray:
        """−∂g/∂(u, φ) (N, 6, 6) at fixed V, Ω and s."""
        own = np.zeros((self.chain.model.count, 6, 6))
        own[:, :3, :3] = -cross_matrix(self.motion.rotation[None])
        own[:, 3:, 3:] = self.motion.turn * cross_matrix(self.frames[:, 0])
        return own

    @cached_property
    def largest(self) -> float:
        """max |G|, as a velocity of a free sphere or a times its angular velocity."""
        chain = self.chain
        parts = (self.residual / chain.units).reshape(-1, 2, 3)
        sizes = np.linalg.norm(parts, axis=2) * [1.0, chain.scene.chain.radius]
        return float(sizes.max(initial=0.0))


def orthonormal_motions(
    columns: np.ndarray, allowed: np.ndarray, length: float
) -> tuple[np.ndarray, np.ndarray]:
    """Q (m, r) and the combinations (7, r) of allowed motions with Q = columns · combinations.

    ``columns`` (m, 7) are those of one pose, or of several below each other.
    """
    chosen = _independent(columns, allowed, length)
    basis, sizes, directions = _basis(columns @ chosen, length)
    return basis, chosen @ (directions.T / sizes)


def _independent(columns: np.ndarray, allowed: np.ndarray, length: float) -> np.ndarray:
    """The allowed combinations; without a turn that is a rotation of the chain as a whole.

    On a straight chain the turn about e₁ and the rotation about its axis are one motion.
    """
    rigid = allowed[:, np.abs(allowed[TURN]) == 0.0]
    turning = allowed[:, np.abs(allowed[TURN]) > 0.0]
    if not turning.size or not rigid.size:
        return allowed
    basis, _, _ = _basis(columns @ rigid, length)
    image = columns @ turning
    rest = image - basis @ (basis.T @ image)
    if np.linalg.norm(rest) > INDEPENDENT * np.linalg.norm(image):
        return allowed
    return rigid


def _basis(columns: np.ndarray, length: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(Q, σ, Vᵀ) with columns = Q σ Vᵀ, without directions that are dependent to rounding."""
    lengths = np.linalg.norm(columns, axis=0)
    scales = np.where(lengths > 0.0, lengths, 1.0)
    basis, sizes, directions = np.linalg.svd(columns / scales, full_matrices=False)
    kept = sizes > INDEPENDENT * max(float(sizes.max(initial=0.0)), 1e-300)
    kept &= sizes * lengths.max(initial=0.0) > VANISHING * length
    return basis[:, kept], sizes[kept], directions[kept] / scales
