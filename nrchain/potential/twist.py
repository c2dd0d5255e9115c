"""V = Σ_links (μ∥/2)(e₂·e₃′)²: links resist turning about e₁; primed frames are the next sphere's.

The printed form is transversely isotropic to linear order only. The ``isotropic`` measure has the
same linear response and does not change if both frames rotate about their e₁ by the same angle,

    V = Σ_links (μ∥/2)[(e₂·e₃′ − e₃·e₂′)/2]².

A product e_a·f_b changes by (e_a × f_b)·(φ − φ′): the two spheres feel opposite moments.

Source: paper, Appendix B.
"""

from __future__ import annotations

from nrchain._compile import part
from nrchain.potential.link import (
    add_cross,
    add_product_moment,
    cross,
    dot,
    product_energy,
)
from nrchain.potential.link_blocks import add_outer, add_product_blocks, add_turned_cross


@part
def energy(e, f):
    """V/μ∥ of a link between frames e and f."""
    return product_energy(e[1], f[2])


@part
def add_moment(e, f, modulus, moment):
    """moment += the torque of the link on its first sphere."""
    add_product_moment(e[1], f[2], modulus, moment)


@part
def add_blocks(e, f, modulus, turning):
    """turning (3, 3) += the derivative of the moment with the rotation of the first sphere."""
    add_product_blocks(e[1], f[2], modulus, turning)


@part
def _sine(e, f):
    return 0.5 * (dot(e[1], f[2]) - dot(e[2], f[1]))


@part
def isotropic_energy(e, f):
    """V/μ∥ = ½ [(e₂·e₃′ − e₃·e₂′)/2]²."""
    return 0.5 * _sine(e, f) ** 2


@part
def add_isotropic_moment(e, f, modulus, moment):
    sine = _sine(e, f)
    add_cross(e[1], f[2], -0.5 * modulus * sine, moment)
    add_cross(e[2], f[1], 0.5 * modulus * sine, moment)


@part
def add_isotropic_blocks(e, f, modulus, turning):
    sine = _sine(e, f)
    add_turned_cross(e[1], f[2], -0.5 * modulus * sine, turning)
    add_turned_cross(e[2], f[1], 0.5 * modulus * sine, turning)
    a, b = cross(e[1], f[2]), cross(e[2], f[1])
    mean = 0.5 * (a[0] - b[0]), 0.5 * (a[1] - b[1]), 0.5 * (a[2] - b[2])
    add_outer(mean, -modulus, turning)
