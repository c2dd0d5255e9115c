"""V = Σ_links [stretch + shear + twist + bend]: the elastic chain of the paper's Appendix B.

Each term has its own file (:mod:`~nrchain.potential.stretch`, :mod:`~nrchain.potential.shear`,
:mod:`~nrchain.potential.twist`, :mod:`~nrchain.potential.bend`). The kernels here sum them in one
pass over the links. ``terms`` and ``isotropic`` are constants to the compiler: a kernel contains
the terms present and no others.

Force F = −∂V/∂r and torque T = −Σ_a e_a × ∂V/∂e_a, both in the lab frame, so that a displacement
u and a small rotation φ of a sphere change V by −F·u − T·φ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from nrchain._addresses import Term, carray, compile_term, floats_at, integers_at
from nrchain._compile import kernel, rename
from nrchain.potential import bend as bending
from nrchain.potential import shear as shearing
from nrchain.potential import stretch as stretching
from nrchain.potential import twist as twisting
from nrchain.potential.link import (
    E1,
    E2,
    E3,
    REACH,
    add_strain_wrenches,
    add_turning_moment,
    axes_of,
    is_wide,
    link_spheres,
    link_tangent,
    link_weights,
    mid_vector,
)
from nrchain.potential.link_blocks import add_strain_blocks, add_turning_blocks, set_strain_parts

__all__ = ["REACH", "TERMS", "Elasticity", "terms_of"]

TERMS = ("stretch", "shear", "twist", "bend")
"""The terms, in the order of their moduli."""


def terms_of(moduli: Sequence[float]) -> tuple[str, ...]:
    """The terms whose modulus is not zero."""
    return tuple(term for term, modulus in zip(TERMS, moduli, strict=True) if modulus)


def _axes(terms: tuple[str, ...]) -> tuple[int, int]:
    """The range of frame vectors with a strain: e₁ for stretch, e₂ and e₃ for shear."""
    return (0 if "stretch" in terms else 1), (3 if "shear" in terms else 1)


@cache
def wrench_kernel(terms: tuple[str, ...], isotropic: bool) -> Any:
    """Compile the wrenches of these terms: see :meth:`Elasticity.add_wrenches`."""
    first, last = _axes(terms)
    stretched, sheared, twisted, bent = (term in terms for term in TERMS)

    def add_wrenches(positions, frames, spacing, period, stretch, shear, twist, bend, wrenches):
        count, periodic = positions.shape[0], period > 0.0
        tensile, lateral = stretch * spacing**2, shear * spacing**2
        moment = np.empty(3)
        for link in range(count if periodic else count - 1):
            if stretched or sheared:
                wide = is_wide(link, count, periodic)
                weights, spheres = link_weights(wide), link_spheres(link, count, wide)
                t = link_tangent(positions, link, spheres, weights, spacing, period)
                e1 = mid_vector(frames, E1, spheres, weights) if stretched else t
                e2 = mid_vector(frames, E2, spheres, weights) if sheared else t
                e3 = mid_vector(frames, E3, spheres, weights) if sheared else t
                tensions = (
                    tensile * stretching.strain(e1, t) if stretched else 0.0,
                    lateral * shearing.strain(e2, t) if sheared else 0.0,
                    lateral * shearing.strain(e3, t) if sheared else 0.0,
                )
                add_strain_wrenches(
                    frames, first, last, spheres, wide, weights, spacing, t, tensions, wrenches
                )
            if twisted or bent:
                i, j = link, (link + 1 if link + 1 < count else 0)
                e, f = frames[i], frames[j]
                moment[:] = 0.0
                if twisted and isotropic:
                    twisting.add_isotropic_moment(e, f, twist, moment)
                elif twisted:
                    twisting.add_moment(e, f, twist, moment)
                if bent and isotropic:
                    bending.add_isotropic_moment(e, f, bend, moment)
                elif bent:
                    bending.add_moment(e, f, bend, moment)
                add_turning_moment(moment, i, j, wrenches)

    return kernel(rename(add_wrenches, *terms, isotropic))


@cache
def energy_kernel(terms: tuple[str, ...], isotropic: bool) -> Any:
    """Compile the energy of these terms: see :meth:`Elasticity.energy`."""
    stretched, sheared, twisted, bent = (term in terms for term in TERMS)

    def energy(positions, frames, spacing, period, stretch, shear, twist, bend):
        count, periodic = positions.shape[0], period > 0.0
        total = 0.0
        for link in range(count if periodic else count - 1):
            if stretched or sheared:
                wide = is_wide(link, count, periodic)
                weights, spheres = link_weights(wide), link_spheres(link, count, wide)
                t = link_tangent(positions, link, spheres, weights, spacing, period)
                if stretched:
                    strain = stretching.strain(mid_vector(frames, E1, spheres, weights), t)
                    total += 0.5 * stretch * (spacing * strain) ** 2
                if sheared:
                    for a in range(1, 3):
                        strain = shearing.strain(mid_vector(frames, a, spheres, weights), t)
                        total += 0.5 * shear * (spacing * strain) ** 2
            e, f = frames[link], frames[link + 1 if link + 1 < count else 0]
            if twisted:
                total += twist * (
                    twisting.isotropic_energy(e, f) if isotropic else twisting.energy(e, f)
                )
            if bent:
                total += bend * (
                    bending.isotropic_energy(e, f) if isotropic else bending.energy(e, f)
                )
        return total

    return kernel(rename(energy, *terms, isotropic))


@cache
def block_kernel(terms: tuple[str, ...], isotropic: bool) -> Any:
    """Compile the derivative of these terms: see :meth:`Elasticity.add_jacobian`."""
    first, last = _axes(terms)
    stretched, sheared, twisted, bent = (term in terms for term in TERMS)

    def add_jacobian(positions, frames, spacing, period, stretch, shear, twist, bend, blocks):
        count, periodic = positions.shape[0], period > 0.0
        stiffness, roots, tensions = np.empty(3), np.empty(3), np.empty(3)
        pulls, tensile, turning = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
        levers, ties = np.empty((4, 3, 3)), np.empty((4, 3, 3))
        pulls[:] = 0.0
        levers[:] = 0.0
        for a in range(3):
            stiffness[a] = (stretch if a == 0 else shear) * spacing**2
            roots[a], tensions[a] = np.sqrt(stiffness[a]), 0.0
        for link in range(count if periodic else count - 1):
            if stretched or sheared:
                wide = is_wide(link, count, periodic)
                weights, spheres = link_weights(wide), link_spheres(link, count, wide)
                t = link_tangent(positions, link, spheres, weights, spacing, period)
                for a in range(first, last):
                    e_a = mid_vector(frames, a, spheres, weights)
                    strain = stretching.strain(e_a, t) if a == 0 else shearing.strain(e_a, t)
                    tensions[a] = stiffness[a] * strain
                    for k in range(3):
                        pulls[a, k] = roots[a] * e_a[k]
                set_strain_parts(
                    frames,
                    first,
                    last,
                    spheres,
                    weights,
                    t,
                    roots,
                    tensions,
                    pulls,
                    levers,
                    ties,
                    tensile,
                    blocks,
                )
                add_strain_blocks(spheres, wide, weights, spacing, levers, ties, tensile, blocks)
            if twisted or bent:
                i, j = link, (link + 1 if link + 1 < count else 0)
                e, f = axes_of(frames, i), axes_of(frames, j)
                turning[:] = 0.0
                if twisted and isotropic:
                    twisting.add_isotropic_blocks(e, f, twist, turning)
                elif twisted:
                    twisting.add_blocks(e, f, twist, turning)
                if bent and isotropic:
                    bending.add_isotropic_blocks(e, f, bend, turning)
                elif bent:
                    bending.add_blocks(e, f, bend, turning)
                add_turning_blocks(turning, i, j, blocks)

    return kernel(rename(add_jacobian, *terms, isotropic))


add: Any = None
"""The kernel of a term: :func:`compile_term` puts that of a chain in its place."""


def _add_wrenches(context, positions, frames, out, width):
    """The term of :meth:`Elasticity.add_wrenches`; its table: N, and the address of parameters."""
    table = carray(integers_at(context), 2)
    n, p = table[0], carray(floats_at(table[1]), 6)
    r, e = carray(floats_at(positions), (n, 3)), carray(floats_at(frames), (n, 3, 3))
    wrenches = carray(floats_at(out), (n, 6))
    add(r, e, p[0], p[1], p[2], p[3], p[4], p[5], wrenches)
    return 0


def _add_blocks(context, positions, frames, out, width):
    """The term of :meth:`Elasticity.add_jacobian`."""
    table = carray(integers_at(context), 2)
    n, p = table[0], carray(floats_at(table[1]), 6)
    r, e = carray(floats_at(positions), (n, 3)), carray(floats_at(frames), (n, 3, 3))
    blocks = carray(floats_at(out), (n, 2 * width + 1, 6, 6))
    add(r, e, p[0], p[1], p[2], p[3], p[4], p[5], blocks)
    return 0


@dataclass(frozen=True)
class Elasticity:
    """V, −∂V/∂(u, φ) and its derivative: the elastic energy of a chain for given moduli.

    Parameters
    ----------
    spacing
        Rest distance d.
    period
        Length along x after which the chain repeats; 0 for an open chain.
    moduli
        λ∥, λ⊥, μ∥ and μ⊥.
    isotropic
        Whether twist and bend have the isotropic measure.
    terms
        The terms compiled into the kernels; all others are left out, for any modulus.
    """

    spacing: float
    period: float
    moduli: tuple[float, ...]
    isotropic: bool
    terms: tuple[str, ...]

    def __bool__(self) -> bool:
        return bool(self.terms)

    def add_wrenches(self, positions: np.ndarray, frames: np.ndarray, wrenches: np.ndarray) -> None:
        """wrenches (N, 6) += (F, T)."""
        if self:
            add = wrench_kernel(self.terms, self.isotropic)
            add(positions, frames, self.spacing, self.period, *self.moduli, wrenches)

    def add_jacobian(self, positions: np.ndarray, frames: np.ndarray, blocks: np.ndarray) -> None:
        """blocks[i, w + m] += ∂(F, T)_i / ∂(u, φ)_{i+m}, for −3 ≤ m ≤ 3 and w ≥ 3.

        u displaces and φ rotates a sphere in the lab: e_a → e_a + φ × e_a.
        """
        if self:
            add = block_kernel(self.terms, self.isotropic)
            add(positions, frames, self.spacing, self.period, *self.moduli, blocks)

    def term(self, count: int) -> Term:
        """The wrenches of ``count`` spheres as a term by address."""
        options = self.terms, self.isotropic
        parameters = np.array([self.spacing, self.period, *self.moduli])
        entries = (
            compile_term(_add_wrenches, add=wrench_kernel(*options)),
            compile_term(_add_blocks, add=block_kernel(*options)),
        )
        context = np.array([count, parameters.ctypes.data])
        return Term(entries[0].address, entries[1].address, context, (parameters, *entries))

    def energy(self, positions: np.ndarray, frames: np.ndarray) -> float:
        """V, summed over links."""
        if not self:
            return 0.0
        total = energy_kernel(self.terms, self.isotropic)
        return float(total(positions, frames, self.spacing, self.period, *self.moduli))
