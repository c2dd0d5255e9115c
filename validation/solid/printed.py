"""The tables of the paper as printed, and closed forms for uniform strain, by hand.

Symbols are those of ``nrchain.rod.SYMBOLS``. A term is (coefficient, power of a, power of 1/d, "T"
or "R" for Γ^T or Γ^R), per V.
"""

from __future__ import annotations

from fractions import Fraction

from nrchain import Rod

Terms = tuple[tuple[str, int, int, str], ...]

CLASSES = {
    (False, False): "F_pre C_par_F_eps C_par_M_tau C_perp_F_eps C_perp_M_tau H_odd_f_tau"
    " H_odd_m_eps",
    (False, True): "M_pre C_par_F_tau C_par_M_eps C_perp_F_tau C_perp_M_eps H_odd_f_eps"
    " H_odd_m_tau",
    (True, False): "f_pre H_par_f_eps H_par_m_tau C_odd_F_tau C_odd_M_eps H_perp_f_eps"
    " H_perp_m_tau",
    (True, True): "m_pre H_par_f_tau H_par_m_eps C_odd_F_eps C_odd_M_tau H_perp_f_tau H_perp_m_eps",
}
"""Table syms: the constants of each class, (polar, chiral)."""

SIGNS = {
    "ε": (True, False),
    "τ": (True, True),
    "F": (True, False),
    "M": (True, True),
    "f": (False, False),
    "m": (False, True),
}
"""Table signs: whether a vector depends on the polarity of the rod, and whether it is axial."""

CUT: dict[str, dict[str, Terms]] = {
    "2s": {"C_perp_M_tau": (("-7/4", 2, 1, "R"), ("7/36", 2, -1, "T"))},
    "3a": {
        "C_perp_F_tau": (("-13/24", 3, 1, "T"),),
        "C_perp_M_eps": (("-13/6", 3, 3, "R"), ("13/24", 3, 1, "T")),
        "H_odd_m_tau": (("-13/12", 3, 3, "R"), ("13/24", 3, 1, "T")),
    },
    "3t": {
        "C_odd_F_tau": (("1/10", 3, 1, "T"),),
        "C_odd_M_eps": (("-1/10", 3, 1, "T"),),
        "H_perp_m_tau": (("1/10", 3, 1, "T"),),
    },
    "4a": {"C_odd_M_tau": (("-1089/40", 4, 3, "R"), ("363/40", 4, 1, "T"))},
}
"""Moduli of uniform strain, nearest neighbours, where they differ from those of linear response.

The wrench on a sphere depends on the axis of the other alone. In a bend τ each of two neighbours
turns by τd/2 from the cut between them: C^{Fτ} and the torques in C^{Mτ} are half of the
coefficients of φ″. The other terms are lever arms: of the forces about the cut, and of the
prestress about the arc, −F̃d²/12.
"""


def value(terms: Terms, rod: Rod, strength: float) -> float:
    """Σ coefficient a^p d^−n Γ V."""
    drag = {"T": rod.Gamma_T, "R": rod.Gamma_R}
    return strength * sum(
        float(Fraction(c)) * rod.radius**p / rod.spacing**n * drag[kind] for c, p, n, kind in terms
    )
