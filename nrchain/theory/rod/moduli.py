"""F̃∥ = −(7a²/3d) Γ^T V, …: the effective moduli of the active chain (paper, Table moduli).

Every modulus is a sum of terms coefficient · a^p / d^n · Γ V with Γ = Γ^T or Γ^R, kept as data in
:data:`TABLE`. Symbols are the paper's in ASCII: ``C_perp_F_eps`` for C_⊥^{Fε}, ``odd`` for ↺, and
``F_pre``, ``M_pre``, ``f_pre``, ``m_pre`` for F̃∥, M̃∥, f̃∥, m̃∥.

The printed table is at leading order in a/d. For two moduli this is not enough: in the torque
balance of the rod their leading terms cancel, and the next order remains. The printed pre-moment
has the sign of the torque of the left half of the chain on the right half, while the prestress has
that of right on left. Each such row carries both forms.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from nrchain.inputs.names import Named
from nrchain.theory.rod.parameters import Rod

Term = tuple[str, int, int, str]
"""(coefficient, power of a, power of 1/d, "T" or "R" for the friction density)."""


@dataclass(frozen=True)
class Modulus:
    """One entry of the table: Σ coefficient a^p d^−n Γ V, and the printed form where it differs."""

    mode: str
    symbol: str
    terms: tuple[Term, ...]
    printed: tuple[Term, ...] | None = None
    note: str = ""

    def value(self, rod: Rod, *, printed: bool = False) -> float:
        """The modulus of a rod; 0 where its mode is absent."""
        terms = self.printed if printed and self.printed is not None else self.terms
        strength = rod.strengths.get(self.mode, 0.0)
        friction = {"T": rod.Gamma_T, "R": rod.Gamma_R}
        return sum(
            float(Fraction(c)) * rod.radius**p / rod.spacing**n * friction[kind] * strength
            for c, p, n, kind in terms
        )


TABLE = (
    Modulus("2s", "F_pre", (("-7/3", 2, 1, "T"),)),
    Modulus("2s", "C_par_F_eps", (("14/3", 2, 1, "T"),)),
    Modulus("2s", "C_par_M_tau", ()),
    Modulus("2s", "C_perp_F_eps", (("-7/3", 2, 1, "T"),)),
    Modulus("2s", "C_perp_M_tau", (("-7/2", 2, 1, "R"),)),
    Modulus("2s", "H_odd_f_tau", ()),
    Modulus("2s", "H_odd_m_eps", (("7", 2, 3, "R"),)),
    Modulus(
        "3a",
        "M_pre",
        (("-13/12", 3, 3, "R"),),
        printed=(("13/12", 3, 3, "R"),),
        note="right on left, the sign of F_pre, is negative; the print has left on right",
    ),
    Modulus("3a", "C_par_F_tau", ()),
    Modulus("3a", "C_par_M_eps", (("13/3", 3, 3, "R"),)),
    Modulus("3a", "C_perp_F_tau", (("-13/12", 3, 1, "T"),)),
    Modulus("3a", "C_perp_M_eps", (("-13/6", 3, 3, "R"),)),
    Modulus("3a", "H_odd_f_eps", (("13/6", 3, 3, "T"),)),
    Modulus(
        "3a",
        "H_odd_m_tau",
        (("13/12", 3, 1, "T"), ("-13/12", 3, 3, "R")),
        printed=(("13/12", 3, 1, "T"),),
        note="C_perp_F_tau + H_odd_m_tau − M_pre vanishes only with the dropped term, M_pre",
    ),
    Modulus("3t", "f_pre", (("4/5", 3, 3, "T"),)),
    Modulus("3t", "H_par_f_eps", (("-12/5", 3, 3, "T"),)),
    Modulus("3t", "H_par_m_tau", ()),
    Modulus("3t", "C_odd_F_tau", (("1/5", 3, 1, "T"),)),
    Modulus("3t", "C_odd_M_eps", ()),
    Modulus("3t", "H_perp_f_eps", (("6/5", 3, 3, "T"),)),
    Modulus("3t", "H_perp_m_tau", (("1/5", 3, 1, "T"),)),
    Modulus("4a", "m_pre", (("-363/5", 4, 5, "R"),)),
    Modulus("4a", "H_par_f_tau", ()),
    Modulus("4a", "H_par_m_eps", (("363", 4, 5, "R"),)),
    Modulus("4a", "C_odd_F_eps", (("363/10", 4, 3, "T"),)),
    Modulus("4a", "C_odd_M_tau", (("-1089/20", 4, 3, "R"),)),
    Modulus("4a", "H_perp_f_tau", (("-363/10", 4, 3, "T"),)),
    Modulus(
        "4a",
        "H_perp_m_eps",
        (("363/10", 4, 3, "T"), ("-363/2", 4, 5, "R")),
        printed=(("363/10", 4, 3, "T"),),
        note="H_perp_m_eps − C_odd_F_eps, the torque on a sheared chain, is the dropped term alone",
    ),
)
"""Table moduli of the paper, row by row."""


def moduli(rod: Rod, *, printed: bool = False) -> dict[str, float]:
    """Every modulus of :data:`TABLE` by its symbol; those of absent modes are 0."""
    return Named({row.symbol: row.value(rod, printed=printed) for row in TABLE})
