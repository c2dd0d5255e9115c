"""d/dt (u, φ) = M(q) (u, φ): the paper's linearised equations of the chain and of the rod.

Written from the paper's text (Appendix C), independently of the code of the simulation: nearest
neighbours, leading order in a/d, one-body friction, e_1 along the chain. Plane waves are exp(iqx);
u and φ have lab components, about the translating or spinning steady state. Where the paper
contradicts itself, the form that follows from its pair laws is used; the printed form is used if
``misprints`` names it: see :data:`MISPRINTS`.
"""

from __future__ import annotations

from collections.abc import Collection
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nrchain.errors import SceneError
from nrchain.inputs.arguments import finite_array
from nrchain.theory.rod.moduli import moduli
from nrchain.theory.rod.parameters import Rod

Complex = NDArray[np.complex128]

MISPRINTS = {
    "4a force": "Table discr_forces, polar chiral: (φ^{i+1} + φ^{i−1}) for a difference",
    "4a torque": "Table discr_torques, polar chiral: d x̂×(…) for (3/5) d x̂×(…)",
    "differences": "Appendix B: C¹ and D² carry 1/d and 1/d², which λ and λd in the equations of"
    " motion have taken in already",
    "2s torque": "Table cont_torques, apolar achiral: C_∥^{Fε} for C_⊥^{Fε}",
    "leading moduli": "Table moduli: H_↺^{mτ} of 3a and H_⊥^{mε} of 4a without the terms that their"
    " combinations leave, and M̃∥ of 3a with the opposite sign",
    "rotation": "Eq. rot_part: −κ_T φ′_⊥ for −κ_T φ_⊥",
}
"""What the paper prints differently, by the names that ``misprints`` takes."""

X = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""x̂ ×"""
ALONG = np.diag([1.0, 0.0, 0.0])
ACROSS = np.diag([0.0, 1.0, 1.0])
_TENSORS = {"I-3xx": np.eye(3) - 3 * ALONG, "x×": X, "⊥": ACROSS}


class Term(NamedTuple):
    """coefficient · a^p/d^n V · tensor · stencil: a force over γ_T or a torque over γ_R."""

    row: str
    of: str
    tensor: str
    stencil: str
    coefficient: Fraction
    radius: int
    spacing: int


def _term(row: str, of: str, tensor: str, stencil: str, coefficient: str, p: int, n: int) -> Term:
    return Term(row, of, tensor, stencil, Fraction(coefficient), p, n)


DISCRETE = {
    "2s": (
        _term("force", "u", "I-3xx", "second", "-7/3", 2, 3),
        _term("torque", "u", "x×", "difference", "7/2", 2, 4),
        _term("torque", "φ", "⊥", "sum", "-7/2", 2, 3),
    ),
    "3a": (
        _term("force", "u", "x×", "difference", "13/12", 3, 4),
        _term("force", "φ", "⊥", "sum", "-13/12", 3, 3),
        _term("torque", "u", "I-3xx", "second", "-13/6", 3, 5),
        _term("torque", "φ", "x×", "difference", "-13/12", 3, 4),
    ),
    "3t": (
        _term("force", "u", "I-3xx", "difference", "3/5", 3, 4),
        _term("force", "φ", "x×", "sum", "1/5", 3, 3),
    ),
    "4a": (
        _term("force", "u", "x×", "second", "363/10", 4, 5),
        _term("force", "φ", "⊥", "difference", "-363/10", 4, 4),
        _term("torque", "u", "I-3xx", "difference", "-363/4", 4, 6),
        _term("torque", "φ", "x×", "sum", "-1089/20", 4, 5),
        _term("torque", "φ", "x×", "self", "-363/5", 4, 5),  # Ω0 × φ
    ),
}
"""Eqs. 2s_micro_tr to 4a_discr_rot, over γ_T and γ_R: what tables discr_forces and discr_torques
give up to prefactors."""

_PRINTED_TERMS = {
    DISCRETE["4a"][1]: ("4a force", _term("force", "φ", "⊥", "sum", "-363/10", 4, 4)),
    DISCRETE["4a"][3]: ("4a torque", _term("torque", "φ", "x×", "sum", "-363/4", 4, 5)),
}


def discrete_operator(
    rod: Rod, wavenumbers: ArrayLike, *, misprints: Collection[str] = ()
) -> Complex:
    """M(q) (..., 6, 6) of the linearised equations of the discrete chain (Appendix C)."""
    _check(misprints)
    theta = finite_array("wavenumbers", wavenumbers) * rod.spacing
    operator = _elastic_chain(rod, theta, divided="differences" in misprints)
    stencils = {
        "second": -2.0 * (1.0 - np.cos(theta)),
        "difference": 2j * np.sin(theta),
        "sum": 2.0 * np.cos(theta),
        "self": np.ones_like(theta),
    }
    rows = {"force": slice(0, 3), "torque": slice(3, 6)}
    columns = {"u": slice(0, 3), "φ": slice(3, 6)}
    for mode, strength in rod.strengths.items():
        for term in DISCRETE[mode]:
            name, printed = _PRINTED_TERMS.get(term, ("", term))
            if name in misprints:
                term = printed
            size = float(term.coefficient) * rod.radius**term.radius / rod.spacing**term.spacing
            entry = strength * size * np.asarray(stencils[term.stencil])[..., None, None]
            operator[..., rows[term.row], columns[term.of]] += entry * _TENSORS[term.tensor]
    return operator


def differences(theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(d C¹, C⁰) on exp(iqx), at midpoints: C¹ ≈ iq and C⁰ ≈ 1 to fourth order in θ = qd."""
    half = np.asarray(theta) / 2.0
    first = 2j * (27.0 * np.sin(half) - np.sin(3.0 * half)) / 24.0
    return np.asarray(first), np.asarray((9.0 * np.cos(half) - np.cos(3.0 * half)) / 8.0)


def _elastic_chain(rod: Rod, theta: np.ndarray, *, divided: bool) -> Complex:
    """Eqs. passive_discr_tr and passive_discr_rot; ``divided`` by the d and d² of Appendix B."""
    first, mean = (entry[..., None, None] for entry in differences(theta))
    second = -2.0 * (1.0 - np.cos(theta))[..., None, None]
    d = rod.spacing
    if divided:
        first, second = first / d, second / d**2
    operator = np.zeros((*theta.shape, 6, 6), complex)
    operator[..., :3, :3] = first**2 * (rod.stretch * ALONG + rod.shear * ACROSS)
    operator[..., :3, 3:] = rod.shear * d * first * mean * X
    operator[..., 3:, :3] = rod.shear * d * first * mean * X
    operator[..., 3:, 3:] = rod.shear * d**2 * mean**2 * (X @ X)
    operator[..., 3:, 3:] += second * (rod.twist * ALONG + rod.bend * ACROSS)
    operator[..., :3, :] /= rod.gamma_T
    operator[..., 3:, :] /= rod.gamma_R
    return operator


def continuum_operator(
    rod: Rod, wavenumbers: ArrayLike, *, misprints: Collection[str] = ()
) -> Complex:
    """M(q) (..., 6, 6) of the linearised rod (tables cont_forces, cont_torques; Eqs. passive_cont).

    The moduli of all modes add up; Ω0 × φ of the lab and the turning of m̃∥ cancel for 4a.
    """
    _check(misprints)
    c = moduli(rod, printed="leading moduli" in misprints)
    slope = np.asarray(1j * finite_array("wavenumbers", wavenumbers))[..., None, None]
    curve = slope**2
    (stretching, shearing), (twisting, bending) = rod.kappa_T, rod.kappa_R
    sheared = c["C_par_F_eps"] if "2s torque" in misprints else c["C_perp_F_eps"]
    decay = slope if "rotation" in misprints else 1.0

    operator = np.zeros((*np.shape(slope)[:-2], 6, 6), complex)
    operator[..., :3, :3] = (
        curve * (stretching + c["C_par_F_eps"]) * ALONG
        + curve * (shearing + c["C_perp_F_eps"]) * ACROSS
        + slope * (c["H_odd_f_eps"] * X + c["H_par_f_eps"] * ALONG + c["H_perp_f_eps"] * ACROSS)
        + curve * c["C_odd_F_eps"] * X
    )
    operator[..., :3, 3:] = (
        slope * (shearing + c["C_perp_F_eps"] + c["H_odd_f_tau"] - c["F_pre"]) * X
        - c["H_odd_f_eps"] * ACROSS
        + curve * (c["C_par_F_tau"] * ALONG + c["C_perp_F_tau"] * ACROSS)
        + (c["H_perp_f_eps"] - c["f_pre"]) * X
        + curve * c["C_odd_F_tau"] * X
        + slope * (c["H_par_f_tau"] * ALONG + (c["H_perp_f_tau"] - c["C_odd_F_eps"]) * ACROSS)
    )
    force_free = c["H_odd_m_eps"] + sheared - c["F_pre"]
    odd = c["H_perp_m_eps"] - c["C_odd_F_eps"]
    operator[..., 3:, :3] = (
        slope * (shearing + force_free) * X
        + curve * (c["C_par_M_eps"] * ALONG + c["C_perp_M_eps"] * ACROSS)
        + curve * c["C_odd_M_eps"] * X
        + slope * (c["H_par_m_eps"] * ALONG + odd * ACROSS)
    )
    twisted = c["C_perp_M_eps"] + c["C_perp_F_tau"] + c["H_odd_m_tau"] - c["M_pre"]
    polar = c["H_perp_m_tau"] - c["C_odd_F_tau"] - c["C_odd_M_eps"]
    operator[..., 3:, 3:] = (
        -(shearing * decay + force_free) * ACROSS
        + curve * (twisting + c["C_par_M_tau"]) * ALONG
        + curve * (bending + c["C_perp_M_tau"]) * ACROSS
        + slope * twisted * X
        + slope * (polar * ACROSS + c["H_par_m_tau"] * ALONG)
        + odd * X
        + curve * c["C_odd_M_tau"] * X
    )
    operator[..., :3, :] /= rod.Gamma_T
    operator[..., 3:, :] /= rod.Gamma_R
    return operator


def beam_rates(rod: Rod, wavenumbers: ArrayLike, *, misprints: Collection[str] = ()) -> Complex:
    """Λ(q) (..., 2) of the bending waves of hand + and − of the discrete chain, for λ⊥ → ∞.

    In that limit a wave has no shear, C¹u + x̂ × C⁰φ = 0: it is v = (u, φ) = (C⁰, ±i C¹) in its
    hand, and moves with Λ = v†Γ M v / v†Γ v, because the force that keeps it unsheared does no
    work on it. Exact in qd, in V and in a/d; equal to the rates at finite λ⊥ up to 1/λ⊥.
    """
    theta = finite_array("wavenumbers", wavenumbers) * rod.spacing
    soft = Rod(
        radius=rod.radius,
        spacing=rod.spacing,
        viscosity=rod.viscosity,
        twist=rod.twist,
        bend=rod.bend,
        strengths=rod.strengths,
    )
    operator = discrete_operator(soft, wavenumbers, misprints=misprints)
    friction = np.repeat([rod.gamma_T, rod.gamma_R], 3)
    first, mean = differences(theta)
    rates = np.empty((*theta.shape, 2), complex)
    for n, hand in enumerate((1, -1)):
        wave = np.array([0.0, 1.0, -1j * hand])
        v = np.concatenate(
            [mean[..., None] * wave, (1j * hand * first / rod.spacing)[..., None] * wave], axis=-1
        )
        rates[..., n] = np.einsum("...i,i,...ij,...j->...", v.conj(), friction, operator, v)
        rates[..., n] /= np.einsum("...i,i,...i->...", v.conj(), friction, v)
    return rates


def _check(misprints: Collection[str]) -> None:
    for name in misprints:
        if name not in MISPRINTS:
            raise SceneError("misprints", name, f"must be among {', '.join(MISPRINTS)}")
