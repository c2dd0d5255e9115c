"""Σ_s c_s m^−s: pair twists, blocks and mobilities of the infinite straight chain of a scene.

On a line, the twist that a slip flow gives the m-th neighbour is a sum of pure powers of m, and so
are its derivative and the mobility of a pair. The coefficients come from the code of the
simulation, evaluated for two spheres at a few distances, mode by mode
(:mod:`nrchain.theory.line_slip`). Elastic blocks come from a short ring of spheres.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from nrchain.effects.base import Effect
from nrchain.effects.registry import acting
from nrchain.effects.shared.image_sums import refuse_reach
from nrchain.errors import SceneError
from nrchain.hydrodynamics.slip import Slip
from nrchain.potential.chain import REACH, TERMS, Elasticity, terms_of
from nrchain.scene.checks import NO_SUM
from nrchain.scene.fluid_sections import SlipSpec
from nrchain.scene.loading import require_scene
from nrchain.scene.scene import Scene
from nrchain.theory.lattice_sums import (
    MOST_TERMS,
    Reach,
    cosine_defect,
    cosine_sum,
    power_sum,
    sine_sum,
)
from nrchain.theory.line_mobility import LineMobility, Sides
from nrchain.theory.line_slip import add_powers, line_poses, slip_powers

Complex = NDArray[np.complex128]

_QUARTER = np.kron(np.eye(2), [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""A quarter turn about the chain, of (u, φ)."""


class StraightChain:
    """The infinite straight chain of a scene: pair twists and blocks as powers of the distance.

    ``twists[s]`` (2, 6) and ``blocks[s]`` (2, 6, 6) are the coefficients of 1/m^s in the twist,
    and in its derivative, due to the slip of the m-th sphere to the right (row 0) or left (row 1).
    ``between`` holds the mobilities of friction between spheres, None with one-body friction.
    ``dragged[s]`` are the coefficients in the derivative of the twist due to the uniform wrench on
    all other spheres. ``own`` and ``own_wrench`` (6, 6) are the derivatives of uniform effects with
    the own pose. Other wrenches vanish on the straight chain.

    ``turning`` and ``fixed`` say what makes the chain anisotropic: axes and forces that rotate with
    the spheres, and fields and flows fixed in the lab.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = require_scene(scene)
        self.reach: Reach = scene.slip.neighbours
        self.twists: Sides = {}
        self.blocks: Sides = {}
        self.dragged: Sides = {}
        self.twist = np.zeros(6)
        self.turning = self.fixed = False
        self.friction = np.repeat(scene.drag, 3)
        self.between: LineMobility | None = None
        if scene.friction.kind == "pairwise":
            refuse_reach(scene, "friction.neighbours", scene.friction.neighbours, MOST_TERMS)
            self.between = LineMobility(scene.chain, scene.friction.neighbours)
        refuse_reach(scene, "slip.neighbours", self.reach, MOST_TERMS)
        for label, slip in scene.slip.modes.items():
            strengths = np.unique(np.atleast_1d(slip.strength))
            if len(strengths) > 1:
                allowed = "must be one number for all spheres: a plane wave needs a uniform chain"
                raise SceneError(SlipSpec.key(label), slip.strength, allowed)
            if strengths[0] != 0.0:
                self.turning |= not slip.axis[1] == slip.axis[2] == 0.0
                self._add_mode(label, Slip(float(strengths[0]), slip.axis))
        self.own, self.own_wrench = np.zeros((2, 6, 6))
        self._check_steady()
        for effect in acting(scene):
            if not effect.fused:
                self._add_effect(effect)

    @property
    def isotropic(self) -> bool:
        """Whether a rotation about the chain changes nothing."""
        return not (self.turning or self.fixed)

    def _add_mode(self, label: str, slip: Slip) -> None:
        """Add the pairs of a mode, power by power."""
        twists, blocks = slip_powers(self.scene, label, slip)
        add_powers(self.twists, twists)
        add_powers(self.blocks, blocks)

    def _add_effect(self, effect: type[Effect]) -> None:
        """Add a uniform effect to the motion and its derivative.

        An effect that depends on position counts as fixed in the lab; one that depends on
        rotation counts as rotating with the sphere.
        """
        given, own = effect.straight(self.scene)
        if np.any(given[4:]):
            allowed = (
                "turns every sphere of the straight chain across it: it does not stay straight"
            )
            raise SceneError(effect.key, effect.value(self.scene), allowed)
        self.fixed |= _is_anisotropic(own[:, :3])
        self.turning |= _is_anisotropic(own[:, 3:])
        if effect.gives == "twist":
            self.twist += given
            self.own += own
            return
        self.twist += given / self.friction
        self.own_wrench += own
        if self.between is not None and given.any():
            self.twist += self.between.twist(given)
            for power, sides in self.between.blocks(given).items():
                self.dragged[power] = self.dragged.get(power, 0.0) + sides
            # a force across the chain, less the part that turns with the spheres
            turned = own[:3, 3]
            self.fixed |= bool(given[1] != turned[2] or given[2] != -turned[1])

    def _check_steady(self) -> None:
        """Compute V0 and Ω0; refuse a chain that does not stay straight."""
        scale = np.zeros(6)
        for power, sides in self.twists.items():
            both = sides[0] + sides[1]
            pushed = np.abs(both) > 1e-14 * np.abs(sides).sum(axis=0)
            total = power_sum(power, self.reach)
            if pushed.any() and math.isinf(total):
                self._refuse_sum()
            self.twist[pushed] += both[pushed] * total
            scale += np.abs(sides).sum(axis=0)
        if np.abs(self.twist[4:]).max() > 1e-12 * scale[3:].max():
            axes = {label: slip.axis for label, slip in self.scene.slip.modes.items()}
            allowed = (
                "with these axes every sphere of the straight chain turns about an axis across it,"
                f" at {self.twist[3:].tolist()}: it has no straight steady state to linearise about"
            )
            raise SceneError("slip", axes, allowed)

    def _refuse_sum(self) -> None:
        raise SceneError("slip.neighbours", self.reach, NO_SUM)

    def mobility(self, phases: np.ndarray) -> Complex:
        """μ(q) (..., 6, 6) in (u̇, φ̇) = μ (F, T), Hermitian; (6, 6) with one-body friction."""
        operator = np.diag(1.0 / self.friction).astype(complex)
        return operator if self.between is None else operator + self.between.waves(phases)

    def soft_operator(self, phases: np.ndarray) -> Complex:
        """M in the lab without its stretch and shear, and with no Ω0 × φ yet."""
        moduli = self.scene.moduli
        bend = self.elastic(phases, (0.0, 0.0, moduli.twist, moduli.bend))
        operator = self.mobility(phases) @ (bend + self.own_wrench) + self.own
        self._add_waves(operator, self.blocks, phases, self.reach)
        if self.between is not None:
            self._add_waves(operator, self.dragged, phases, self.between.reach)
        return operator

    def _add_waves(
        self, operator: Complex, blocks: Sides, phases: np.ndarray, reach: Reach
    ) -> None:
        """operator += Σ_m B_m (e^{imθ} − 1) of displacements, Σ_m B_m e^{imθ} of rotations."""
        for power, (right, left) in blocks.items():
            even, odd = right + left, right - left
            even[np.abs(even) < 1e-14 * np.abs(odd)] = 0.0
            sine = sine_sum(power, phases, reach)[..., None, None]
            operator += 1j * odd * sine
            if even[:, :3].any():
                defect = cosine_defect(power, phases, reach)[..., None, None]
                operator[..., :3] -= even[:, :3] * defect
            if even[:, 3:].any():
                cosine = cosine_sum(power, phases, reach)[..., None, None]
                if not np.isfinite(cosine).all():
                    self._refuse_sum()
                operator[..., 3:] += even[:, 3:] * cosine

    def elastic(self, phases: np.ndarray, moduli: tuple[float, ...]) -> Complex:
        """K(q) (..., 6, 6): the wrenches (F, T) = K (u, φ) that these moduli give."""
        row = elastic_row(self.scene, moduli)
        centre = len(row) // 2
        total = row.sum(axis=0)
        # for uniform displacement and shear the two sides cancel: remove rounding
        total[:, :3] = total[:3] = 0.0
        operator = np.zeros((*phases.shape, 6, 6), complex) + total
        for m in range(1, centre + 1):
            right, left = row[centre + m], row[centre - m]
            phase = m * phases[..., None, None]
            operator -= (right + left) * (2.0 * np.sin(phase / 2.0) ** 2)
            operator += 1j * (right - left) * np.sin(phase)
        return operator


def elastic_row(scene: Scene, moduli: tuple[float, ...]) -> np.ndarray:
    """∂(F, T)_i / ∂(u, φ)_{i+m} (2w + 1, 6, 6) of an inner sphere of the straight chain at rest."""
    # zero terms stay, so that the kernels of the simulation are reused
    kept = {*terms_of(scene.moduli), *terms_of(moduli)}
    terms = tuple(term for term in TERMS if term in kept)
    chain, count = scene.chain, 2 * REACH + 1
    isotropic = scene.elasticity.measure == "isotropic"
    ring = Elasticity(chain.spacing, count * chain.spacing, moduli, isotropic, terms)
    blocks = np.zeros((count, count, 6, 6))
    ring.add_jacobian(*line_poses(count, chain.spacing), blocks)
    return blocks[0]


def _is_anisotropic(half: np.ndarray) -> bool:
    """Whether a quarter turn about the chain changes the columns (6, 3) of u, or of φ."""
    turned = _QUARTER @ half @ _QUARTER[:3, :3].T
    return not np.allclose(turned, half, rtol=1e-14, atol=0.0)
