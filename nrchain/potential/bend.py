"""V = Σ_links (μ⊥/2)[(e₁·e₂′)² + (e₃·e₁′)²]: links resist bending; primed frames are the next's.

The printed form is transversely isotropic to linear order only: on a chain that spins it gives an
oscillating torque about e₁ of order μβ², with β the bend of a link. The ``isotropic`` measure has
the same linear response without this torque,

    V = Σ_links μ⊥(1 − e₁·e₁′).

Source: paper, Appendix B.
"""

from __future__ import annotations

from nrchain._compile import part
from nrchain.potential.link import (
    add_cross,
    add_product_moment,
    dot,
    product_energy,
)
from nrchain.potential.link_blocks import add_product_blocks, add_turned_cross


@part
def energy(e, f):
    """V/μ⊥ of a link between frames e and f."""
    return product_energy(e[0], f[1]) + product_energy(e[2], f[0])


@part
def add_moment(e, f, modulus, moment):
    """moment += the torque of the link on its first sphere."""
    add_product_moment(e[0], f[1], modulus, moment)
    add_product_moment(e[2], f[0], modulus, moment)


@part
def add_blocks(e, f, modulus, turning):
    """turning (3, 3) += the derivative of the moment with the rotation of the first sphere."""
    add_product_blocks(e[0], f[1], modulus, turning)
    add_product_blocks(e[2], f[0], modulus, turning)


@part
def isotropic_energy(e, f):
    """V/μ⊥ = 1 − e₁·e₁′."""
    return 1.0 - dot(e[0], f[0])


@part
def add_isotropic_moment(e, f, modulus, moment):
    add_cross(e[0], f[0], modulus, moment)


@part
def add_isotropic_blocks(e, f, modulus, turning):
    add_turned_cross(e[0], f[0], modulus, turning)
