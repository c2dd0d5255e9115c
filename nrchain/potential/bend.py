"""V = Σ_links (μ⊥/2)[(e₁·e₂′)² + (e₃·e₁′)²]: links resist bending; primed frames are the next's.

The printed form is transversely isotropic to linear order only: on a chain that spins it gives an
oscillating torque about e₁ of order μβ², with β the bend of a link. The ``isotropic`` measure has
the same linear response without this torque,

    V = Σ_links μ⊥(1 − e₁·e₁′).

Source: paper, Appendix B.
"""

from __future__ import annotations

from nrchain._compile import kernel
from nrchain.potential.link import (
    add_cross,
    add_product_blocks,
    add_product_moment,
    add_turned_cross,
    dot,
    product_energy,
)


@kernel
def energy(e, f):
    """V/μ⊥ of a link between frames e and f."""
    return product_energy(e[0], f[1]) + product_energy(e[2], f[0])


@kernel
def add_moment(e, f, modulus, moment):
    """moment += the torque of the link on its first sphere."""
    add_product_moment(e[0], f[1], modulus, moment)
    add_product_moment(e[2], f[0], modulus, moment)


@kernel
def add_blocks(e, f, modulus, axis, own, other):
    """own, other += the derivatives of the moment with rotations of the two spheres."""
    add_product_blocks(e[0], f[1], modulus, axis, own, other)
    add_product_blocks(e[2], f[0], modulus, axis, own, other)


@kernel
def isotropic_energy(e, f):
    """V/μ⊥ = 1 − e₁·e₁′."""
    return 1.0 - dot(e[0], f[0])


@kernel
def add_isotropic_moment(e, f, modulus, moment):
    add_cross(e[0], f[0], modulus, moment)


@kernel
def add_isotropic_blocks(e, f, modulus, axis, own, other):
    add_turned_cross(e[0], f[0], modulus, own, other)
