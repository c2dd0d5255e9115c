"""Λ(q) for qd ≪ 1: the closed-form laws of the paper for the passive chain and the four modes.

Nearest neighbours, leading order in a/d, leading order in qd for every term. The contributions of
several modes and of the elasticity add up. Hands are those of
:class:`nrchain.lattice.Branch`: +1 is w_y + i w_z, for q > 0 the right-handed helix. Rates are in
the lab, at fixed index of sphere. What each law leaves out is a factor 1 + O(qd)² (for 3t, whose
third-order term is cancelled on the lattice, (a/d)² O(qd)² + O(qd)⁴) and 1 + O(μ q²/λ).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nrchain.errors import SceneError
from nrchain.inputs.arguments import finite_array
from nrchain.theory.rod.parameters import Rod

Complex = NDArray[np.complex128]


class Law(NamedTuple):
    """coefficient · (a^p/d^{p+1}) V (qd)^n, times ``hand`` for chiral laws."""

    coefficient: complex
    radius: int
    order: int
    chiral: bool
    source: str


TRANSVERSE = {
    "2s": Law(7 / 3, 2, 2, False, "Eq. 2s_tr_displ"),
    "3a": Law(-13 / 18, 3, 3, True, "Eq. 3a_trans_ac_disp"),
    "3t": Law(4j / 5, 3, 1, False, "Eq. 3t_trans_ac_disp"),
    "4a": Law(363j / 10, 4, 2, True, "Eq. 4a_trans_ac_disp"),
}
"""The term of each mode in the rate of bending waves, in the beam limit."""

LONGITUDINAL = {
    "2s": Law(-14 / 3, 2, 2, False, "C_par_F_eps of Table moduli"),
    "3t": Law(-12j / 5, 3, 1, False, "Eq. 3t_long_tr_disp"),
}
"""The term of each mode in the rate of waves of u_x; 3a and 4a have none."""

OPTICAL = {
    "2s": Law(-7, 2, 0, False, "Eq. 2s_micro_rot at q = 0"),
    "4a": Law(-363j / 2, 4, 0, True, "Eq. 4a_discr_rot at q = 0"),
}
"""The term of each mode in the rate of a uniform shear."""


def transverse(rod: Rod, wavenumbers: ArrayLike, hand: int = 1) -> Complex:
    """Λ = −(κ_R/Γ^T) q⁴ + Σ_modes: bending waves of a hand, for λ⊥ → ∞ (Eq. pass_ac and others)."""
    q = finite_array("wavenumbers", wavenumbers)
    return _active(TRANSVERSE, rod, q, hand) - rod.kappa_R[1] / rod.Gamma_T * q**4


def longitudinal(rod: Rod, wavenumbers: ArrayLike) -> Complex:
    """Λ = −(κ_T∥/Γ^T) q² + Σ_modes: waves of u_x (Eq. 3t_long_tr_disp)."""
    q = finite_array("wavenumbers", wavenumbers)
    return _active(LONGITUDINAL, rod, q, 1) - rod.kappa_T[0] / rod.Gamma_T * q**2


def twisting(rod: Rod, wavenumbers: ArrayLike) -> Complex:
    """Λ = −(κ_R∥/Γ^R) q²: waves of φ_x, which uniaxial slip does not change."""
    q = finite_array("wavenumbers", wavenumbers)
    return (-rod.kappa_R[0] / rod.Gamma_R * q**2).astype(complex)


def optical(rod: Rod, hand: int = 1) -> complex:
    """Λ = −κ_T⊥/Γ^R + Σ_modes: the gap, at q = 0 (Eq. pass_op, with its active part)."""
    active = complex(_active(OPTICAL, rod, np.zeros(()), hand))
    return active - rod.kappa_T[1] / rod.Gamma_R


def steady_motion(rod: Rod) -> tuple[float, float]:
    """V⁰ = 4a³V/(5d³) of 3t and Ω⁰ = −363a⁴V/(5d⁵) of 4a, along x (Eqs. 3t_vel, 4a_ang_vel)."""
    a, d = rod.radius, rod.spacing
    return (
        4 * a**3 / (5 * d**3) * rod.strengths.get("3t", 0.0),
        -363 * a**4 / (5 * d**5) * rod.strengths.get("4a", 0.0),
    )


def _active(laws: dict[str, Law], rod: Rod, q: np.ndarray, hand: int) -> Complex:
    if hand not in (1, -1):
        raise SceneError("hand", hand, "must be 1 or -1")
    total = np.zeros(q.shape, complex)
    for mode, strength in rod.strengths.items():
        if (law := laws.get(mode)) is not None:
            scale = rod.radius**law.radius / rod.spacing ** (law.radius + 1)
            sign = hand if law.chiral else 1
            total += sign * law.coefficient * scale * strength * (q * rod.spacing) ** law.order
    return total
